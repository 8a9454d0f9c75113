#include "occluder_finding/inner_solids.hpp"

#include "occluder_finding/frames.hpp"
#include "occluder_finding/grow_convex.hpp"
#include "occluder_finding/inside_tests.hpp"

#include <algorithm>

namespace antumbra {
namespace {

using grid::Point;
using grid::Triangle;

constexpr std::size_t kMostPlanes = 16, kMostFaces = 32, kMostTriangles = 50000;
constexpr double kLeastGain = 1.2;      ///< in worth, over the largest box along the axes
constexpr double kOverBox = 1.15;       ///< in worth, of a grown solid over an oriented box: that has six faces
constexpr double kInsets[] = {1, 4, 16, 64}; ///< grid steps that planes move inward until the tests hold
constexpr std::int64_t kLeastThickness = 8;  ///< grid steps

class Finder {
  public:
    Finder(const Enclosure& enclosure, const GridMesh& mesh) : enclosure_(enclosure), mesh_(mesh) {}

    /// Oriented boxes and what grows from the seeds, in one frame.
    void look(const Frame& frame, bool is_grid, const std::vector<GridBox>& boxes) {
        Vec3d origin = is_grid ? Vec3d{} : to_vector(mesh_.min);
        std::vector<std::array<Vec3d, 3>> triangles;
        Box3d bounds;
        for (const Triangle& t : mesh_.triangles) {
            triangles.push_back({frame.to_frame(to_vector(t[0]) - origin), frame.to_frame(to_vector(t[1]) - origin),
                                 frame.to_frame(to_vector(t[2]) - origin)});
            for (const Vec3d& p : triangles.back())
                bounds.extend(p);
        }
        std::vector<HalfSpace> around = sides_of(bounds, is_grid);
        if (enclosure_.opening.is_open())
            around.push_back(beyond_opening(frame, origin));
        for (const GridBox& box : boxes) {
            Box3d seed{to_vector(box.min), to_vector(box.max)};
            std::optional<InnerSolid> oriented;
            if (!is_grid)
                oriented = certified(sides_of(seed, false), frame, origin, true);
            Box3d half{seed.min * 0.75 + seed.max * 0.25, seed.min * 0.25 + seed.max * 0.75};
            std::optional<InnerSolid> grown;
            if (auto planes = grow_convex(triangles, half, around, kMostPlanes))
                grown = certified(*planes, frame, origin, false);
            if (grown && !(oriented && grown->shape.worth() < kOverBox * oriented->shape.worth()))
                found_.push_back(std::move(*grown));
            else if (oriented)
                found_.push_back(std::move(*oriented));
        }
    }

    /// The best of all, largest first, without those whose middle lies in a better one.
    std::vector<InnerSolid> best(double least, std::size_t most) {
        std::stable_sort(found_.begin(), found_.end(),
                         [](const InnerSolid& a, const InnerSolid& b) { return a.shape.worth() > b.shape.worth(); });
        std::vector<InnerSolid> kept;
        for (InnerSolid& solid : found_)
            if (kept.size() < most && solid.shape.worth() >= least &&
                std::none_of(kept.begin(), kept.end(), [&](const InnerSolid& k) { return is_strictly_inside(k.shape, middle(solid.shape)); }))
                kept.push_back(std::move(solid));
        return kept;
    }

  private:
    static std::vector<HalfSpace> sides_of(const Box3d& box, bool on_grid) {
        std::vector<HalfSpace> planes;
        for (int axis = 0; axis < 3; ++axis) {
            Vec3d normal;
            normal[axis] = 1;
            planes.push_back({normal, box.max[axis], on_grid});
            planes.push_back({-normal, -box.min[axis], on_grid});
        }
        return planes;
    }

    HalfSpace beyond_opening(const Frame& frame, const Vec3d& origin) const {
        Vec3d outward;
        outward[enclosure_.opening.axis] = enclosure_.opening.above ? -1 : 1;
        double at = double(enclosure_.opening.at + (enclosure_.opening.above ? 1 : -1));
        Vec3d on_plane;
        on_plane[enclosure_.opening.axis] = at;
        return {frame.to_frame(outward), dot(outward, on_plane - origin), false};
    }

    static Vec3d middle(const GridPolytope& shape) {
        Vec3d sum;
        for (const Point& p : shape.points)
            sum += to_vector(p);
        return sum / double(shape.points.size());
    }

    static bool is_strictly_inside(const GridPolytope& shape, const Vec3d& place) {
        Point p = to_grid(place);
        for (const auto& face : shape.faces) {
            const Point& a = shape.points[face[0]];
            Point normal = grid::cross(grid::minus(shape.points[face[1]], a), grid::minus(shape.points[face[2]], a));
            if (grid::dot(normal, grid::minus(p, a)) >= 0)
                return false;
        }
        return true;
    }

    std::optional<InnerSolid> certified(const std::vector<HalfSpace>& planes, const Frame& frame, const Vec3d& origin,
                                        bool is_box) const {
        for (double inset : kInsets) {
            std::vector<Point> points;
            for (const Vec3d& corner : corners_of(planes, inset))
                points.push_back(to_grid(frame.from_frame(corner) + origin));
            std::optional<GridPolytope> hull = convex_hull(std::move(points));
            if (!hull || hull->faces.size() > kMostFaces)
                return {};
            if (is_inside(*hull))
                return InnerSolid{std::move(*hull), mesh_.min, mesh_.max, enclosure_.opening, enclosure_.objects[0], is_box};
        }
        return {};
    }

    /// Decided on whole numbers alone.
    bool is_inside(const GridPolytope& hull) const {
        Point low = hull.points[0], high = low;
        for (const Point& p : hull.points)
            for (std::size_t k = 0; k < 3; ++k) {
                low[k] = std::min(low[k], p[k]);
                high[k] = std::max(high[k], p[k]);
            }
        Point cut_low = low, cut_high = high;
        enclosure_.opening.cut(cut_low, cut_high);
        if (cut_low != low || cut_high != high)
            return false;
        for (std::size_t k = 0; k < 3; ++k)
            if (high[k] - low[k] < kLeastThickness)
                return false;
        PolytopeTest test(hull);
        for (const Triangle& triangle : mesh_.triangles)
            if (test.is_entered_by(triangle))
                return false;
        // One point inside tells for all; uneven shares keep the ray off the edges of regular meshes.
        Vec3d centre = middle(hull);
        for (std::size_t i = 0; i < std::min<std::size_t>(hull.points.size(), 4); ++i) {
            Vec3d place = centre + (to_vector(hull.points[i]) - centre) * (0.07 * double(i));
            int winding = 0;
            if (is_strictly_inside(hull, place) && winding_number(to_grid(place), mesh_.triangles, winding))
                return winding > 0 || (enclosure_.any_winding && winding != 0);
        }
        return false;
    }

    const Enclosure& enclosure_;
    const GridMesh& mesh_;
    std::vector<InnerSolid> found_;
};

} // namespace

std::vector<InnerSolid> find_inner_solids(const Enclosure& enclosure, const GridMesh& mesh,
                                          const std::vector<GridBox>& boxes, const OccluderOptions& options) {
    if (mesh.triangles.size() > kMostTriangles)
        return {};
    Finder finder(enclosure, mesh);
    finder.look(Frame{}, true, boxes);
    for (const Frame& frame : oriented_frames(mesh)) {
        GridMesh there = turned(mesh, frame, to_vector(mesh.min));
        finder.look(frame, false,
                    largest_free_boxes(there, options.inner_box_resolution, enclosure.any_winding, options.boxes_per_solid));
    }
    double largest = 0;
    for (const GridBox& box : boxes)
        largest = std::max(largest, box.worth());
    return finder.best(kLeastGain * largest, options.boxes_per_solid);
}

} // namespace antumbra
