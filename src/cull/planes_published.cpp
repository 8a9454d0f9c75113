// Supporting and separating planes as Coorg and Teller published them in 1997: for one occluder and one box the planes
// do not depend on the viewpoint, so they are formed once, by tangent look-up, and kept while the viewer moves.
// Full occlusion: the viewpoint is on the inner side of all supporting planes; partial: of all separating planes.
#include "cull/methods.hpp"
#include "cull/result_bits.hpp"
#include "cull/shadow.hpp"
#include "cull/tangent_table.hpp"
#include "cull/view_planes.hpp"
#include "occluders/occluder_sets.hpp"

#include <algorithm>

namespace antumbra {
namespace {

constexpr std::uint32_t kMostEdges = 8;
constexpr std::uint32_t kCacheEntries = 1u << 15; ///< about 600 bytes each
constexpr std::uint32_t kMostListed = 64;         ///< occluders of one view
constexpr std::uint32_t kDetailOccluders = 16;    ///< of one detail object

enum class Occlusion : std::uint8_t { none, partial, full };

/// Unit normal and offset; the occluder is on the positive side.
struct Plane {
    Vec3d normal;
    double offset = 0;
    double at(const Vec3d& p) const { return dot(normal, p) + offset; }
};

/// One occluder and one box: a pair of planes per occluder edge.
struct Relation {
    std::uint64_t key = ~std::uint64_t(0);
    bool possible = false; ///< false: the box does not lie wholly behind the occluder, or a plane is uncertain
    std::uint32_t edges = 0;
    Plane supporting[kMostEdges], separating[kMostEdges];
};

const Relation kImpossible;

struct Entry {
    std::uint32_t node, first, count; ///< occluders: list[first .. first + count)
};

struct State final : ViewState::Storage {
    std::vector<Relation> cache;
    std::vector<Entry> stack;
    std::vector<std::uint32_t> list;
};

class PublishedPlanes final : public Culler {
  public:
    PublishedPlanes(const CullScene& scene, const CullerOptions& options)
        : scene_(scene), most_(std::min(options.occluders, kMostListed)), serial_(new_culler_serial()) {
        OccluderSetsOptions sets;
        sets.per_set = most_;
        sets.most_corners = kMostEdges;
        sets_ = scene.data().front_sets;
        detail_sets_ = scene.data().back_sets;
        if (sets_.empty())
            sets_ = OccluderSets::build(scene.data().occluders, scene.data().tree_box, sets);
        sets.shown = OccluderSetsOptions::Shown::backs; // what turns its front to the viewer turns its back to the object
        if (detail_sets_.empty())
            detail_sets_ = OccluderSets::build(scene.data().occluders, scene.data().tree_box, sets);
        const Box3f& box = scene.data().tree_box;
        if (!box.empty())
            extent_ = length(to_double(box.max)) + length(to_double(box.min));
    }
    std::string_view name() const override { return "planes-published"; }
    Guarantee guarantee() const override { return Guarantee::conservative; }

    void cull(const View& view, ViewState& view_state, CullResult& result) const override {
        const CullScene::Data& scene = scene_.data();
        begin_result(scene, result);
        if (const char* problem = problem_of(view))
            return mark_everything(scene, result, problem);
        // The relations are about a viewpoint; parallel lines of sight have none.
        if (view.projection == Projection::orthographic)
            result.reason = "the published form knows no orthographic views: frustum only";
        else if (most_ == 0)
            result.reason = "no occluders allowed: frustum only";
        else if (scene.occluders.polygons.empty())
            result.reason = "the scene has no occluders: frustum only";
        if (!scene.binary.empty())
            walk(camera_of(view), view_state.storage<State>(serial_), result);
        finish_result(result);
    }

  private:
    static bool is_outside(const Box3f& box, const FrustumPlanes& planes) {
        for (int i = 0; i < planes.count; ++i) {
            const float* n = planes.normal[i];
            float sum = n[0] * (n[0] >= 0 ? box.max.x : box.min.x) + n[1] * (n[1] >= 0 ? box.max.y : box.min.y) +
                        n[2] * (n[2] >= 0 ? box.max.z : box.min.z);
            if (sum + planes.offset[i] < 0)
                return true;
        }
        return false;
    }

    /// The recursion of the paper: a node that is fully occluded is done with; below it only the occluders that hide
    /// it in part are tried.
    void walk(const Camera& camera, State& state, CullResult& result) const {
        const CullScene::Data& scene = scene_.data();
        FrustumPlanes planes = frustum_planes(camera, scene.tree_box);
        SightStart sight = sight_start(camera, scene.tree_box);
        if (state.cache.empty()) {
            state.cache.resize(kCacheEntries);
            state.stack.reserve(scene.stack_bound);
            state.list.reserve(std::size_t(kTreeDepth + 2) * kMostListed);
        }
        state.list.clear();
        state.stack.clear();
        if (!camera.orthographic)
            for (std::uint32_t polygon : sets_.at(camera.eye, camera.forward))
                if (state.list.size() < most_ && is_usable(polygon, sight))
                    state.list.push_back(polygon);
        result.counters.occluders_used = state.list.size();
        state.stack.push_back({0, 0, static_cast<std::uint32_t>(state.list.size())});
        while (!state.stack.empty()) {
            Entry entry = state.stack.back();
            state.stack.pop_back();
            const BinaryNode& node = scene.binary[entry.node];
            ++result.counters.boxes_tested;
            if (is_outside(node.box, planes)) {
                ++result.counters.outside_frustum;
                continue;
            }
            // Children are handled before anything above them on the stack: their part of the list can be reused.
            state.list.resize(entry.first + entry.count);
            Entry below{0, 0, 0};
            if (is_hidden(entry, camera.eye, below, state, result.counters)) {
                ++result.counters.hidden_by_planes;
            } else if (node.right == 0) {
                if (!is_hidden_detail(entry.node, camera, sight, state, result.counters))
                    mark_visible(result, scene.order[node.first]);
            } else {
                ++result.counters.nodes_visited;
                state.stack.push_back({node.right, below.first, below.count});
                state.stack.push_back({entry.node + 1, below.first, below.count});
            }
        }
    }

    /// Faces the viewer, and nothing of it can lie in front of the near plane.
    bool is_usable(std::uint32_t polygon, const SightStart& sight) const {
        const OccluderPolygon& p = scene_.data().occluders.polygons[polygon];
        int side = facing(p, sight.camera);
        return side != 0 && is_beyond_near(p, side, sight);
    }

    /// Full occlusion of the node's box by one of the entry's occluders, or by those together that hide it in part;
    /// else `below` gets the latter. The entry's occluders face the eye.
    bool is_hidden(const Entry& entry, const Vec3d& eye, Entry& below, State& state, CullCounters& counters) const {
        below.first = static_cast<std::uint32_t>(state.list.size());
        for (std::uint32_t i = entry.first; i < entry.first + entry.count; ++i) {
            std::uint32_t occluder = state.list[i];
            Occlusion occlusion = classify(relation(entry.node, occluder, eye, state, counters), eye);
            if (occlusion == Occlusion::full)
                return true;
            if (occlusion == Occlusion::partial) {
                state.list.push_back(occluder);
                ++below.count;
            }
        }
        return below.count > 1 && is_hidden_together(entry.node, below, eye, state, counters);
    }

    /// Joined occluders: all supporting planes, but for those of edges that two of the occluders share.
    bool is_hidden_together(std::uint32_t node, const Entry& below, const Vec3d& eye, State& state,
                            CullCounters& counters) const {
        const OccluderSet& set = scene_.data().occluders;
        std::span<const std::uint32_t> together(state.list.data() + below.first, below.count);
        std::uint32_t part[kMostListed], done[kMostListed];
        std::uint32_t done_count = 0;
        for (std::uint32_t seed : together) {
            // Only a connected part can have fewer planes than its members alone.
            if (std::find(done, done + done_count, seed) != done + done_count)
                continue;
            std::uint32_t size = 0;
            part[size++] = seed;
            for (std::uint32_t at = 0; at < size; ++at)
                for_neighbours(set, part[at], [&](std::uint32_t, std::uint32_t neighbour) {
                    if (std::find(part, part + size, neighbour) == part + size &&
                        std::find(together.begin(), together.end(), neighbour) != together.end())
                        part[size++] = neighbour;
                });
            std::copy(part, part + size, done + done_count); // parts are disjoint
            done_count += size;
            if (size < 2)
                continue;
            bool all = true;
            for (std::uint32_t m = 0; m < size && all; ++m) {
                const Relation& pair = relation(node, part[m], eye, state, counters);
                std::uint32_t open = (1u << pair.edges) - 1; // edges whose supporting plane counts
                for_neighbours(set, part[m], [&](std::uint32_t edge, std::uint32_t neighbour) {
                    if (std::find(part, part + size, neighbour) != part + size &&
                        is_across(set, part[m], edge, neighbour, eye))
                        open &= ~(1u << edge);
                });
                all = pair.possible;
                for (std::uint32_t edge = 0; edge < pair.edges && all; ++edge)
                    all = !(open >> edge & 1) || pair.supporting[edge].at(eye) > margin(eye);
            }
            if (all)
                return true;
        }
        return false;
    }

    template <class Visit>
    static void for_neighbours(const OccluderSet& set, std::uint32_t polygon, Visit&& visit) {
        const OccluderPolygon& p = set.polygons[polygon];
        for (std::uint32_t edge = 0; edge < p.count; ++edge)
            if (std::uint32_t n = set.neighbours[p.first + edge] & ~kSameDirection; n != kNoPolygon)
                visit(edge, n);
    }

    /// Do the two, which both face the eye, lie on opposite sides of their edge as seen from there?
    static bool is_across(const OccluderSet& set, std::uint32_t polygon, std::uint32_t edge, std::uint32_t neighbour,
                          const Vec3d& eye) {
        const OccluderPolygon &a = set.polygons[polygon], &b = set.polygons[neighbour];
        bool same_direction = (set.neighbours[a.first + edge] & kSameDirection) != 0;
        bool same_side = (dot(a.normal, eye) + a.offset > 0) == (dot(b.normal, eye) + b.offset > 0);
        return same_side != same_direction;
    }

    /// Detail objects have occluders of their own: those large in the direction of the viewer as seen from the object.
    bool is_hidden_detail(std::uint32_t node, const Camera& camera, const SightStart& sight, State& state,
                          CullCounters& counters) const {
        if (camera.orthographic)
            return false;
        Vec3d centre = to_double(scene_.data().binary[node].box).centre();
        std::size_t before = state.list.size();
        for (std::uint32_t polygon : detail_sets_.at(centre, camera.eye - centre))
            if (is_usable(polygon, sight) && state.list.size() < before + kDetailOccluders)
                state.list.push_back(polygon);
        Entry entry{node, static_cast<std::uint32_t>(before), static_cast<std::uint32_t>(state.list.size() - before)};
        Entry below{0, 0, 0};
        bool hidden = is_hidden(entry, camera.eye, below, state, counters);
        counters.hidden_by_planes += hidden;
        state.list.resize(before);
        return hidden;
    }

    double margin(const Vec3d& eye) const { return 1e-9 * (extent_ + length(eye)); }

    Occlusion classify(const Relation& pair, const Vec3d& eye) const {
        if (!pair.possible)
            return Occlusion::none;
        double least = margin(eye);
        bool full = true;
        for (std::uint32_t edge = 0; edge < pair.edges && full; ++edge)
            full = pair.supporting[edge].at(eye) > least;
        if (full)
            return Occlusion::full;
        for (std::uint32_t edge = 0; edge < pair.edges; ++edge)
            if (pair.separating[edge].at(eye) < -least)
                return Occlusion::none;
        return Occlusion::partial;
    }

    /// From the cache, or formed and kept. Which side of a double-sided occluder the box must be on depends on the eye.
    const Relation& relation(std::uint32_t node, std::uint32_t occluder, const Vec3d& eye, State& state,
                             CullCounters& counters) const {
        const OccluderPolygon& polygon = scene_.data().occluders.polygons[occluder];
        bool front = dot(polygon.normal, eye) + polygon.offset > 0;
        // Most pairs end here, at the price of one plane; they are not worth a place in the cache.
        if (!is_behind(scene_.data().binary[node].box, polygon, front ? 1 : -1))
            return kImpossible;
        std::uint64_t key = (std::uint64_t(node) << 32 | occluder) << 1 | std::uint64_t(front);
        Relation& entry = state.cache[(key * 0x9E3779B97F4A7C15u) >> (64 - 15)];
        static_assert(kCacheEntries == 1u << 15);
        if (entry.key == key) {
            ++counters.relations_cached;
            return entry;
        }
        ++counters.relations_made;
        entry.key = key;
        form(entry, to_double(scene_.data().binary[node].box), polygon);
        return entry;
    }

    /// Strictly, as seen from `side`: coplanar walls stay visible.
    bool is_behind(const Box3f& box, const OccluderPolygon& polygon, double side) const {
        double nearest = polygon.offset * side;
        for (int axis = 0; axis < 3; ++axis) {
            double n = polygon.normal[axis] * side;
            nearest += n * (n > 0 ? box.max[axis] : box.min[axis]);
        }
        return nearest < -1e-9 * extent_;
    }

    void form(Relation& pair, const Box3d& box, const OccluderPolygon& polygon) const {
        const OccluderSet& set = scene_.data().occluders;
        pair.possible = false;
        pair.edges = polygon.count;
        std::span<const std::uint32_t> loop = set.loop(polygon);
        for (std::uint32_t edge = 0; edge < polygon.count; ++edge) {
            Vec3d a = to_double(set.vertices[loop[edge]]);
            Vec3d along = to_double(set.vertices[loop[(edge + 1) % polygon.count]]) - a;
            Tangents tangents = find_tangents(box, a, along);
            if (!tangents.valid)
                return;
            bool has_supporting = false, has_separating = false;
            for (int corner : {int(tangents.first), int(tangents.second)}) {
                Vec3d reach = box.corner(corner) - a, normal = cross(along, reach);
                double size = length(normal);
                // Planes whose direction is uncertain by more than the margin of the test decide nothing.
                if (!(size > 1e-5 * length(along) * length(reach)))
                    return;
                Plane plane{normal / size, 0};
                plane.offset = -dot(plane.normal, a);
                if (std::abs(plane.at(polygon.centre)) < 1e-9 * extent_)
                    return;
                if (plane.at(polygon.centre) < 0)
                    plane = {-plane.normal, -plane.offset};
                bool same_side = plane.at(box.centre()) > 0;
                (same_side ? pair.supporting : pair.separating)[edge] = plane;
                (same_side ? has_supporting : has_separating) = true;
            }
            if (!has_supporting || !has_separating)
                return;
        }
        pair.possible = true;
    }

    CullScene scene_;
    std::uint32_t most_;
    OccluderSets sets_, detail_sets_;
    double extent_ = 1;
    std::uint64_t serial_;
};

} // namespace

Result<CullerPointer> make_published_planes(const CullScene& scene, const CullerOptions& options) {
    return CullerPointer(std::make_unique<PublishedPlanes>(scene, options));
}

} // namespace antumbra
