// Integers without overflow, and how they become doubles.
#pragma once

#include "geometry/pluecker.hpp"

#include <boost/multiprecision/cpp_int.hpp>

#include <array>
#include <cmath>
#include <cstdint>

namespace antumbra::exact {

/// Unbounded; up to 512 bits live inside the object, which is more than nearly every vertex needs.
using Integer =
    boost::multiprecision::number<boost::multiprecision::cpp_int_backend<
                                      512, 0, boost::multiprecision::signed_magnitude,
                                      boost::multiprecision::unchecked, std::allocator<boost::multiprecision::limb_type>>,
                                  boost::multiprecision::et_off>;
__extension__ typedef __int128 Int128;
__extension__ typedef unsigned __int128 Unsigned128;

/// A point of Pluecker space, or a hyperplane of it, up to a positive factor.
using Six = Pluecker<Integer>;
using SmallSix = Pluecker<std::int64_t>;
/// A point of space as (x, y, z, weight), weight > 0.
using Homogeneous = std::array<Integer, 4>;

inline int sign_of(const Integer& value) { return value.sign(); }
inline int sign_of(Int128 value) { return value > 0 ? 1 : value < 0 ? -1 : 0; }
inline int bits_of(const Integer& value) {
    return value.is_zero() ? 0 : static_cast<int>(boost::multiprecision::msb(abs(value))) + 1;
}

/// value = result * 2^exponent up to a relative error below 2^-52.9; result in [0.5, 1) or 0.
inline double to_double(const Integer& value, int& exponent) {
    exponent = 0;
    if (value.is_zero())
        return 0;
    Integer magnitude = abs(value);
    int excess = bits_of(magnitude) - 62;
    if (excess > 0)
        magnitude >>= static_cast<unsigned>(excess);
    double fraction = std::frexp(static_cast<double>(static_cast<std::uint64_t>(magnitude)), &exponent);
    exponent += excess > 0 ? excess : 0;
    return value.sign() < 0 ? -fraction : fraction;
}

/// Divides by the greatest common divisor of the coordinates; the sign stays.
template <std::size_t N>
void make_primitive(std::array<Integer, N>& values) {
    Integer divisor = 0;
    for (const Integer& value : values)
        if (!value.is_zero()) {
            divisor = gcd(divisor, value);
            if (divisor == 1)
                return;
        }
    if (divisor > 1)
        for (Integer& value : values)
            value /= divisor;
}

} // namespace antumbra::exact
