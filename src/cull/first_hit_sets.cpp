#include "cull/first_hit_sets.hpp"

#include "base/parallel.hpp"
#include "base/random.hpp"

#include <algorithm>

namespace antumbra {
namespace {

constexpr int kViewpoints = 8;           ///< of one leaf
constexpr int kRays = 20;                ///< across a view, and down
constexpr std::uint32_t kNear = 192;     ///< groups that are looked at from one viewpoint, by area over squared distance
constexpr std::uint32_t kSteps = 1 << 14; ///< of the search for them
constexpr std::uint32_t kNone = 0xFFFFFFFFu;

struct Face {
    Vec3d normal;
    double offset = 0;
    std::uint32_t group = 0, first = 0, count = 0; ///< edges: inward normals through the viewpoint
    bool front = false;
};

class LeafSampler {
  public:
    LeafSampler(const CullScene::Data& scene, std::uint32_t leaf, const Box3d& box,
                const std::function<bool(std::uint32_t, std::uint32_t)>& is_seen)
        : scene_(scene), leaf_(leaf), box_(box), is_seen_(is_seen) {
        for (std::vector<std::uint32_t>& counts : hits_)
            counts.assign(scene.groups.groups.size(), 0);
    }

    void run() {
        Random random(leaf_, 0x66697273);
        for (int v = 0; v < kViewpoints; ++v) {
            Vec3d eye;
            for (int axis = 0; axis < 3; ++axis)
                eye[axis] = random.uniform(box_.min[axis], box_.max[axis]);
            look_from(eye);
        }
    }

    std::vector<std::uint32_t> best(std::size_t direction, std::uint32_t most) const {
        const std::vector<std::uint32_t>& counts = hits_[direction];
        std::vector<std::uint32_t> list;
        for (std::uint32_t g = 0; g < counts.size(); ++g)
            if (counts[g] > 0)
                list.push_back(g);
        std::stable_sort(list.begin(), list.end(), [&](std::uint32_t a, std::uint32_t b) { return counts[a] > counts[b]; });
        list.resize(std::min<std::size_t>(list.size(), most));
        return list;
    }

  private:
    void look_from(const Vec3d& eye) {
        search_.begin(scene_.occluder_tree, eye, kNear);
        search_.advance(scene_.occluder_tree, kSteps, [&](std::uint32_t g) {
            const ConvexGroups::Group& group = scene_.groups.groups[g];
            const OccluderPolygon& largest = scene_.occluders.polygons[scene_.groups.members[group.first]];
            if (is_seen_ && !largest.synthetic && !is_seen_(leaf_, largest.object))
                return 0.0f;
            return area_angle_bound(static_cast<float>(group.area), group.box, to_float(eye));
        });
        take_faces(eye);
        std::uint64_t fronts = 0, backs = 0;
        std::vector<std::pair<std::size_t, std::uint32_t>> hits;
        for (std::size_t d = 0; d < OccluderSets::kDirections; ++d)
            for (int j = 0; j < kRays; ++j)
                for (int i = 0; i < kRays; ++i) {
                    const Face* face = first_hit(eye, ray(d, i, j));
                    if (!face)
                        continue;
                    ++(face->front ? fronts : backs);
                    if (face->front)
                        hits.push_back({d, face->group});
                }
        if (backs > fronts)
            return;
        for (auto [direction, group] : hits)
            ++hits_[direction][group];
    }

    static Vec3f to_float(const Vec3d& v) { return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)}; }

    static Vec3d ray(std::size_t direction, int i, int j) {
        Vec3d forward = OccluderSets::directions()[direction];
        Vec3d right = normalized(cross(forward, std::abs(forward.y) < 0.9 ? Vec3d{0, 1, 0} : Vec3d{1, 0, 0}));
        Vec3d up = cross(right, forward);
        return forward + right * ((2 * i + 1.0) / kRays - 1) + up * ((2 * j + 1.0) / kRays - 1);
    }

    void take_faces(const Vec3d& eye) {
        faces_.clear();
        edges_.clear();
        const OccluderSet& set = scene_.occluders;
        for (std::uint32_t g : search_.found_so_far()) {
            const ConvexGroups::Group& group = scene_.groups.groups[g];
            for (std::uint32_t m = group.first; m < group.first + group.count; ++m) {
                const OccluderPolygon& polygon = set.polygons[scene_.groups.members[m]];
                if (polygon.synthetic && !set.solids[polygon.solid].serves(Box3d{eye, eye}))
                    continue; // of no use from here
                double height = dot(polygon.normal, eye) + polygon.offset;
                double side = height > 0 ? 1 : -1;
                if (height == 0)
                    continue;
                Face face{polygon.normal, polygon.offset, g, static_cast<std::uint32_t>(edges_.size()), polygon.count,
                          height > 0 || polygon.double_sided};
                std::span<const std::uint32_t> loop = set.loop(polygon);
                for (std::size_t i = 0; i < loop.size(); ++i)
                    edges_.push_back(cross(to_double(set.vertices[loop[(i + 1) % loop.size()]]) - eye,
                                           to_double(set.vertices[loop[i]]) - eye) * side);
                faces_.push_back(face);
            }
        }
    }

    const Face* first_hit(const Vec3d& eye, const Vec3d& direction) const {
        const Face* best = nullptr;
        double nearest = std::numeric_limits<double>::infinity();
        for (const Face& face : faces_) {
            double along = dot(face.normal, direction);
            double t = -(dot(face.normal, eye) + face.offset) / along;
            // Faces come largest group first: of coplanar ones that stays.
            if (!(t > 0 && t < nearest * (1 - 1e-9)))
                continue;
            bool inside = true;
            for (std::uint32_t e = face.first; inside && e < face.first + face.count; ++e)
                inside = dot(edges_[e], direction) >= 0;
            if (inside) {
                best = &face;
                nearest = t;
            }
        }
        return best;
    }

    const CullScene::Data& scene_;
    std::uint32_t leaf_;
    Box3d box_;
    const std::function<bool(std::uint32_t, std::uint32_t)>& is_seen_;
    OccluderSearch search_;
    std::vector<Face> faces_;
    std::vector<Vec3d> edges_;
    std::array<std::vector<std::uint32_t>, OccluderSets::kDirections> hits_;
};

} // namespace

OccluderSets find_first_hit_sets(const CullScene::Data& scene, const SpaceCells& cells, std::uint32_t per_set,
                                 const std::function<bool(std::uint32_t, std::uint32_t)>& is_seen, const Job& job) {
    if (cells.nodes.empty() || scene.groups.groups.empty())
        return {};
    std::vector<Box3d> boxes = cells.boxes();
    std::vector<std::vector<std::uint32_t>> members(boxes.size() * OccluderSets::kDirections);
    parallel_for(boxes.size(), job, [&](std::size_t leaf, unsigned) {
        LeafSampler sampler(scene, static_cast<std::uint32_t>(leaf), boxes[leaf], is_seen);
        sampler.run();
        for (std::size_t d = 0; d < OccluderSets::kDirections; ++d)
            members[leaf * OccluderSets::kDirections + d] = sampler.best(d, per_set);
    });
    return OccluderSets::of_members(cells, members);
}

} // namespace antumbra
