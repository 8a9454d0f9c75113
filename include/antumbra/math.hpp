// Vectors and boxes: plain values, no invariants.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace antumbra {

template <class T>
struct Vec3 {
    T x{}, y{}, z{};

    constexpr T& operator[](int i) { return i == 0 ? x : i == 1 ? y : z; }
    constexpr const T& operator[](int i) const { return i == 0 ? x : i == 1 ? y : z; }
    constexpr Vec3 operator+(const Vec3& b) const { return {x + b.x, y + b.y, z + b.z}; }
    constexpr Vec3 operator-(const Vec3& b) const { return {x - b.x, y - b.y, z - b.z}; }
    constexpr Vec3 operator-() const { return {-x, -y, -z}; }
    constexpr Vec3 operator*(T s) const { return {x * s, y * s, z * s}; }
    constexpr Vec3 operator/(T s) const { return {x / s, y / s, z / s}; }
    constexpr Vec3& operator+=(const Vec3& b) { return *this = *this + b; }
    constexpr bool operator==(const Vec3&) const = default;
};

using Vec3f = Vec3<float>;
using Vec3d = Vec3<double>;

template <class T>
constexpr T dot(const Vec3<T>& a, const Vec3<T>& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
constexpr Vec3<T> cross(const Vec3<T>& a, const Vec3<T>& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class T>
T length(const Vec3<T>& a) {
    return std::sqrt(dot(a, a));
}
template <class T>
Vec3<T> normalized(const Vec3<T>& a) {
    return a / length(a);
}
template <class T>
bool is_finite(const Vec3<T>& a) {
    return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z);
}
constexpr Vec3d to_double(const Vec3f& a) { return {a.x, a.y, a.z}; }

/// Closed axis-aligned box; min > max in any axis means empty.
template <class T>
struct Box3 {
    Vec3<T> min{std::numeric_limits<T>::infinity(), std::numeric_limits<T>::infinity(),
                std::numeric_limits<T>::infinity()};
    Vec3<T> max{-std::numeric_limits<T>::infinity(), -std::numeric_limits<T>::infinity(),
                -std::numeric_limits<T>::infinity()};

    constexpr bool operator==(const Box3&) const = default;
    constexpr bool empty() const { return !(min.x <= max.x && min.y <= max.y && min.z <= max.z); }
    constexpr Vec3<T> size() const { return max - min; }
    constexpr Vec3<T> centre() const { return (min + max) * T(0.5); }
    constexpr void extend(const Vec3<T>& p) {
        for (int k = 0; k < 3; ++k) {
            min[k] = std::min(min[k], p[k]);
            max[k] = std::max(max[k], p[k]);
        }
    }
    constexpr void extend(const Box3& b) {
        for (int k = 0; k < 3; ++k) {
            min[k] = std::min(min[k], b.min[k]);
            max[k] = std::max(max[k], b.max[k]);
        }
    }
    /// False for NaN.
    constexpr bool contains(const Vec3<T>& p) const {
        return p.x >= min.x && p.x <= max.x && p.y >= min.y && p.y <= max.y && p.z >= min.z && p.z <= max.z;
    }
    constexpr bool overlaps(const Box3& b) const {
        return min.x <= b.max.x && b.min.x <= max.x && min.y <= b.max.y && b.min.y <= max.y &&
               min.z <= b.max.z && b.min.z <= max.z;
    }
    /// Corner i of 0..7: bit k of i chooses max (1) or min (0) along axis k.
    constexpr Vec3<T> corner(int i) const {
        return {i & 1 ? max.x : min.x, i & 2 ? max.y : min.y, i & 4 ? max.z : min.z};
    }
};

using Box3f = Box3<float>;
using Box3d = Box3<double>;

constexpr Box3d to_double(const Box3f& b) { return {to_double(b.min), to_double(b.max)}; }

} // namespace antumbra
