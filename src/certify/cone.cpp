#include "certify/cone.hpp"

namespace antumbra::certify {
namespace {

void divide_out(Vector6& x) {
    Integer divisor = 0;
    for (const Integer& c : x)
        divisor = gcd(divisor, c);
    if (divisor > 1)
        for (Integer& c : x)
            c /= divisor;
}

/// a * x + b * y.
Vector6 combine(const Integer& a, const Vector6& x, const Integer& b, const Vector6& y) {
    Vector6 out;
    for (std::size_t k = 0; k < 6; ++k)
        out[k] = a * x[k] + b * y[k];
    divide_out(out);
    return out;
}

} // namespace

Integer dot6(const Vector6& a, const Vector6& b) {
    Integer sum = 0;
    for (std::size_t k = 0; k < 6; ++k)
        sum += a[k] * b[k];
    return sum;
}

Cone::Cone() {
    for (std::size_t k = 0; k < 6; ++k) {
        Vector6 axis{};
        axis[k] = 1;
        lines_.push_back(axis);
    }
}

void Cone::insert(const Vector6& constraint) {
    constraints_.push_back(constraint);
    // A line that leaves the hyperplane becomes a ray; everything else is moved along it into the hyperplane.
    for (std::size_t l = 0; l < lines_.size(); ++l) {
        Integer value = dot6(constraint, lines_[l]);
        if (value == 0)
            continue;
        Vector6 line = lines_[l];
        if (value < 0) {
            value = -value;
            for (Integer& c : line)
                c = -c;
        }
        lines_.erase(lines_.begin() + static_cast<std::ptrdiff_t>(l));
        for (Vector6& other : lines_)
            other = combine(value, other, -dot6(constraint, other), line);
        for (std::size_t r = 0; r < rays_.size(); ++r) {
            rays_[r] = combine(value, rays_[r], -dot6(constraint, rays_[r]), line);
            on_[r].push_back(true);
        }
        rays_.push_back(line);
        std::vector<bool> on(constraints_.size(), true);
        on.back() = false;
        on_.push_back(on);
        return;
    }
    std::vector<Integer> value;
    for (const Vector6& ray : rays_)
        value.push_back(dot6(constraint, ray));
    std::vector<Vector6> rays;
    std::vector<std::vector<bool>> on;
    for (std::size_t i = 0; i < rays_.size(); ++i)
        if (value[i] >= 0) {
            rays.push_back(rays_[i]);
            on.push_back(on_[i]);
            on.back().push_back(value[i] == 0);
        }
    for (std::size_t i = 0; i < rays_.size(); ++i)
        for (std::size_t j = 0; j < rays_.size(); ++j) {
            if (!(value[i] > 0 && value[j] < 0))
                continue;
            // Two rays span a face iff no third one satisfies all the equalities that they share.
            std::vector<bool> shared(constraints_.size(), false);
            for (std::size_t c = 0; c + 1 < constraints_.size(); ++c)
                shared[c] = on_[i][c] && on_[j][c];
            bool adjacent = true;
            for (std::size_t k = 0; k < rays_.size() && adjacent; ++k) {
                if (k == i || k == j)
                    continue;
                bool all = true;
                for (std::size_t c = 0; c + 1 < constraints_.size() && all; ++c)
                    all = !shared[c] || on_[k][c];
                adjacent = !all;
            }
            if (!adjacent)
                continue;
            rays.push_back(combine(-value[j], rays_[i], value[i], rays_[j]));
            shared.back() = true;
            on.push_back(shared);
        }
    rays_.swap(rays);
    on_.swap(on);
}

} // namespace antumbra::certify
