#include "cull/joined_shadows.hpp"

#include <bit>
#include <cmath>

namespace antumbra {
namespace {

constexpr int kMostCrossed = 3; ///< planes of one shadow; boxes that cross more are hardly ever hidden

/// normal . p + offset, in doubles: the padding of shadows is for floats, so that these sums need a little more only.
struct Plane {
    double normal[3];
    double offset;
};

Plane plane_of(const Shadow& shadow, int i) {
    return {{shadow.normal[i][0], shadow.normal[i][1], shadow.normal[i][2]}, shadow.certainly[i]};
}

/// The least value of a + k b on the box, less what rounding may have added.
[[gnu::noinline]] double least(const Plane& a, double k, const Plane& b, const Box3f& box) {
    double sum = a.offset + k * b.offset, size = std::abs(a.offset) + std::abs(k * b.offset);
    for (int axis = 0; axis < 3; ++axis) {
        double n = a.normal[axis] + k * b.normal[axis];
        double corner = double(n >= 0 ? box.min[axis] : box.max[axis]);
        sum += n * corner;
        size += (std::abs(a.normal[axis]) + std::abs(k * b.normal[axis])) * std::abs(corner);
    }
    return sum - 1e-14 * size;
}

/// Is `plane` positive wherever on the box `crossed` is not?
bool holds_beyond(const Plane& plane, const Plane& crossed, const Box3f& box) {
    if (least(plane, 0, crossed, box) > 0)
        return true;
    for (int axis = 0; axis < 3; ++axis) {
        double k = -plane.normal[axis] / crossed.normal[axis];
        if (k > 0 && k < 1e6 && least(plane, k, crossed, box) > 0)
            return true;
    }
    return false;
}

bool is_out_of_view(const FrustumPlanes& view, std::uint32_t crossing, const Plane& crossed, const Box3f& box) {
    for (; crossing; crossing &= crossing - 1) {
        int i = std::countr_zero(crossing);
        Plane outward{{-double(view.normal[i][0]), -double(view.normal[i][1]), -double(view.normal[i][2])}, -double(view.offset[i])};
        if (holds_beyond(outward, crossed, box))
            return true;
    }
    return false;
}

/// The shadow that holds what of the box is beyond `crossed`; -1: none.
int find_cover(const Box3f& box, std::span<const Shadow> shadows, std::uint64_t others, const Plane& crossed) {
    for (; others; others &= others - 1) {
        int number = std::countr_zero(others);
        const Shadow& shadow = shadows[std::size_t(number)];
        bool holds = true;
        for (int i = 0; i < shadow.count && holds; ++i)
            holds = holds_beyond(plane_of(shadow, i), crossed, box);
        if (holds)
            return number;
    }
    return -1;
}

} // namespace

JoinedShadows find_joined_shadows(const Box3f& box, std::span<const Shadow> shadows, std::uint64_t relevant, int preferred, int most,
                                  const FrustumPlanes& view, std::uint32_t crossing) {
    std::uint64_t untried = relevant;
    for (int tried = preferred < 0 ? 0 : -1; untried && tried < most; ++tried) {
        int number = tried < 0 ? preferred : std::countr_zero(untried);
        untried &= ~(std::uint64_t(1) << number);
        const Shadow& shadow = shadows[std::size_t(number)];
        int crossed[kMostCrossed], count = 0;
        for (int i = 0; i < shadow.count && count <= kMostCrossed; ++i) {
            Plane plane = plane_of(shadow, i);
            if (least(plane, 0, plane, box) > 0)
                continue;
            if (count < kMostCrossed)
                crossed[count] = i;
            ++count;
        }
        JoinedShadows result{number, std::uint64_t(1) << number};
        for (int c = 0; c < count && count <= kMostCrossed && result.first >= 0; ++c) {
            Plane plane = plane_of(shadow, crossed[c]);
            if (is_out_of_view(view, crossing, plane, box))
                continue;
            int cover = find_cover(box, shadows, relevant & ~(std::uint64_t(1) << number), plane);
            if (cover < 0)
                result.first = -1;
            else
                result.used |= std::uint64_t(1) << cover;
        }
        if (count <= kMostCrossed && result.first >= 0)
            return result;
    }
    return {};
}

} // namespace antumbra
