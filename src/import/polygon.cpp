#include "import/polygon.hpp"

namespace antumbra {
namespace {

struct Point {
    double x, y;
};

double turn(const Point& a, const Point& b, const Point& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/// Drops the axis along which Newell's normal is longest, keeping counter-clockwise what is so from the front.
/// Coordinates are taken relative to the first corner: scenes may lie far from the origin.
std::vector<Point> projected(std::span<const Vec3d> corners) {
    Vec3d normal;
    for (std::size_t i = 0; i < corners.size(); ++i)
        normal += cross(corners[i] - corners[0], corners[(i + 1) % corners.size()] - corners[0]);
    int axis = 0;
    for (int k = 1; k < 3; ++k)
        if (std::abs(normal[k]) > std::abs(normal[axis]))
            axis = k;
    std::vector<Point> points;
    points.reserve(corners.size());
    for (const Vec3d& corner : corners) {
        Vec3d p = corner - corners[0];
        double u = p[(axis + 1) % 3], v = p[(axis + 2) % 3];
        points.push_back(normal[axis] < 0 ? Point{v, u} : Point{u, v});
    }
    return points;
}

bool convex(const std::vector<Point>& points) {
    for (std::size_t i = 0, n = points.size(); i < n; ++i)
        if (turn(points[i], points[(i + 1) % n], points[(i + 2) % n]) < 0)
            return false;
    return true;
}

/// The outline that is left, as a ring.
class EarClipper {
  public:
    explicit EarClipper(const std::vector<Point>& points) : points_(points) {
        std::uint32_t n = static_cast<std::uint32_t>(points.size());
        for (std::uint32_t i = 0; i < n; ++i) {
            previous_.push_back((i + n - 1) % n);
            next_.push_back((i + 1) % n);
        }
        for (std::uint32_t i = 0; i < n; ++i)
            ear_.push_back(is_ear(i));
    }

    void clip(std::vector<std::array<std::uint32_t, 3>>& triangles) {
        std::uint32_t at = 0;
        for (std::size_t left = points_.size(); left >= 3; --left) {
            // No ear: the outline crosses itself. Cutting off any corner still covers every corner.
            for (std::size_t tried = 0; tried < left && !ear_[at]; ++tried)
                at = next_[at];
            std::uint32_t before = previous_[at], after = next_[at];
            triangles.push_back({before, at, after});
            next_[before] = after;
            previous_[after] = before;
            if (left > 3) {
                ear_[before] = is_ear(before);
                ear_[after] = is_ear(after);
            }
            at = after;
        }
    }

  private:
    bool is_ear(std::uint32_t i) const {
        const Point &a = points_[previous_[i]], &b = points_[i], &c = points_[next_[i]];
        if (turn(a, b, c) <= 0)
            return false;
        for (std::uint32_t j = next_[next_[i]]; j != previous_[i]; j = next_[j]) {
            const Point& p = points_[j];
            bool at_corner = same(p, a) || same(p, b) || same(p, c);
            if (!at_corner && turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0)
                return false;
        }
        return true;
    }
    static bool same(const Point& p, const Point& q) { return p.x == q.x && p.y == q.y; }

    const std::vector<Point>& points_;
    std::vector<std::uint32_t> previous_, next_;
    std::vector<bool> ear_;
};

} // namespace

bool triangulate(std::span<const Vec3d> corners, std::vector<std::array<std::uint32_t, 3>>& triangles) {
    bool fan = corners.size() == 3, cut_well = true;
    std::vector<Point> points;
    if (!fan) {
        points = projected(corners);
        fan = convex(points);
        cut_well = fan || corners.size() <= kLongestConcavePolygon;
    }
    if (fan || !cut_well) {
        for (std::uint32_t i = 2; i < corners.size(); ++i)
            triangles.push_back({0, i - 1, i});
        return cut_well;
    }
    EarClipper(points).clip(triangles);
    return true;
}

} // namespace antumbra
