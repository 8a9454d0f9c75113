// Supporting and separating planes as Coorg and Teller published them in 1997: a kd-tree of objects; for one occluder and
// one node the planes do not depend on the viewpoint, so they are formed once, by tangent look-up, and kept while the
// viewer moves. Full occlusion: the viewpoint is on the inner side of all supporting planes; partial: of all separating
// planes. Occluders that hide a node in part are handed to its children.
#include "cull/methods.hpp"
#include "cull/occluder_interest.hpp"
#include "cull/relations.hpp"
#include "cull/result_bits.hpp"
#include "cull/set_cells.hpp"
#include "cull/shadow.hpp"
#include "cull/view_planes.hpp"
#include "occluders/occluder_sets.hpp"
#include "tree/kd_tree.hpp"

#include <algorithm>
#include <array>
#include <memory>
#include <optional>

namespace antumbra {
namespace {

constexpr std::uint32_t kMostListed = 256;     ///< occluders of one view
constexpr std::uint32_t kDetailOccluders = 16; ///< of one detail object
constexpr std::uint32_t kChanges = 8;          ///< of the set, per frame
constexpr std::uint32_t kLeastInUse = 8;       ///< the set does not shrink below
constexpr std::size_t kLeavesKept = 32;        ///< whose sets a view has made
constexpr std::uint32_t kTrialFrames = 16;     ///< after which the size of the set is thought over

struct Entry {
    std::uint32_t node, first, count; ///< occluders: list[first .. first + count)
};

/// Sets of one leaf, by direction, where no file has them.
struct LeafSets {
    std::uint32_t leaf = 0, last_used = 0; ///< 0: never
    std::array<std::vector<std::uint32_t>, OccluderSets::kDirections> sets;
};

struct State final : ViewState::Storage {
    std::array<LeafSets, kLeavesKept> leaves;
    std::optional<OccluderSetMaker::Memory> making;
    RelationCache cache;
    OccluderInterest interest;
    std::vector<Entry> stack;
    std::vector<std::uint32_t> list;
    std::vector<std::uint32_t> current;            ///< the occluder set, which changes little by little
    std::vector<std::uint32_t> in_target, in_current; ///< per polygon: the frame in which it last was
    std::vector<std::uint32_t> decided;            ///< per object: the frame in which its own test was made
    std::vector<std::pair<double, std::uint32_t>> ranked;
    Viewpoint viewpoint{{}, 1};
    Box3d start; ///< around what lines of sight begin in
    std::uint32_t frame = 0;
    std::uint32_t in_use = 0;      ///< occluders that the set may have
    std::uint32_t useful = 0;      ///< of these the last, by rank, that hid something in the frames under trial
    std::vector<std::uint32_t> rank; ///< per polygon, in this frame
};

class PublishedPlanes final : public Culler {
  public:
    PublishedPlanes(const CullScene& scene, const CullerOptions& options)
        : scene_(scene), options_(options.published), choice_(options.occluder_choice), pvs_(options.pvs), most_(std::min(options.occluders, kMostListed)),
          serial_(new_culler_serial()) {
        const CullScene::Data& data = scene.data();
        build_tree();
        if (most_ > 0)
            find_sets(options.pvs);
        const Box3f& box = data.tree_box;
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
        if (most_ == 0)
            result.reason = "no occluders allowed: frustum only";
        else if (scene.occluders.polygons.empty())
            result.reason = "the scene has no occluders: frustum only";
        if (!tree_.nodes.empty())
            walk(camera_of(view), view_state.storage<State>(serial_), result);
        finish_result(result);
    }

  private:
    /// The sets of a prepared file, if it has those that are asked for, else made now, for the cells of the PVS if there is one.
    void find_sets(const Pvs* pvs) {
        const CullScene::Data& data = scene_.data();
        OccluderSetsOptions sets;
        sets.per_set = most_;
        sets.most_corners = kMostEdges;
        if (choice_ == OccluderChoice::first_hit)
            sets_ = polygons_of(data, data.first_hit_sets);
        else if (choice_ == OccluderChoice::area_angle)
            sets_ = data.front_sets;
        else
            sets.measure = OccluderSetsOptions::Measure::projected_size;
        if (sets_.empty()) {
            SetCells cells = choose_set_cells(data, pvs, PrepareOptions{}.leaves);
            sets.is_seen = cells.is_seen;
            sets.order = OccluderSetsOptions::Order::by_number; // as in files
            cells_ = std::move(cells.cells);
            if (!cells_.nodes.empty())
                maker_ = std::make_unique<OccluderSetMaker>(data.occluders, cells_, sets);
            sets.order = OccluderSetsOptions::Order::best_first;
            sets.is_seen = nullptr; // what hides an object from a viewer elsewhere need not be seen from where it is
        }
        sets.shown = OccluderSetsOptions::Shown::backs; // what turns its front to the viewer turns its back to the object
        detail_sets_ = data.back_sets;
        if (detail_sets_.empty())
            detail_sets_ = OccluderSets::build(data.occluders, cells_of_objects(data, PrepareOptions{}.detail_leaves), sets);
    }

    /// The set of the viewer's leaf and direction. What is not in a file is made when a viewer enters a leaf, and kept for a while.
    std::span<const std::uint32_t> target_set(const Camera& camera, State& state) const {
        if (!maker_)
            return sets_.at(camera.eye, camera.forward);
        std::uint32_t leaf = cells_.find(camera.eye);
        if (!state.making)
            state.making.emplace(*maker_);
        LeafSets* oldest = &state.leaves[0];
        for (LeafSets& known : state.leaves) {
            if (known.leaf == leaf && known.last_used != 0) {
                oldest = &known;
                break;
            }
            if (known.last_used < oldest->last_used)
                oldest = &known;
        }
        if (oldest->leaf != leaf || oldest->last_used == 0)
            maker_->make(leaf, *state.making, oldest->sets);
        oldest->leaf = leaf;
        oldest->last_used = state.frame;
        return oldest->sets[OccluderSets::direction_of(camera.forward)];
    }

    /// Sets of groups as sets of their polygons.
    OccluderSets polygons_of(const CullScene::Data& data, const OccluderSets& of_groups) const {
        if (of_groups.empty())
            return {};
        std::vector<std::vector<std::uint32_t>> members(of_groups.cells().leaves * OccluderSets::kDirections);
        for (std::size_t set = 0; set < members.size(); ++set)
            for (std::uint32_t number : of_groups.of_leaf(set / OccluderSets::kDirections, set % OccluderSets::kDirections)) {
                const ConvexGroups::Group& group = data.groups.groups[number];
                for (std::uint32_t m = group.first; m < group.first + group.count && members[set].size() < most_; ++m)
                    if (data.occluders.polygons[data.groups.members[m]].count <= kMostEdges)
                        members[set].push_back(data.groups.members[m]);
            }
        return OccluderSets::of_members(of_groups.cells(), members);
    }

    /// Cells of the kd-tree, and in place of each what it holds of its objects' boxes: empty space hides behind nothing.
    void build_tree() {
        const CullScene::Data& scene = scene_.data();
        KdTreeOptions options;
        options.rule = options_.split == KdSplit::balanced_counts ? KdRule::balanced_counts : KdRule::fewest_splits;
        options.leaf_items = options_.leaf_objects;
        tree_ = build_kd_tree(scene.bounds, scene.order, options);
        boxes_.resize(tree_.nodes.size());
        for (std::size_t n = tree_.nodes.size(); n-- > 0;) { // children follow their parents
            const KdNode& node = tree_.nodes[n];
            if (!node.leaf()) {
                boxes_[n] = boxes_[n + 1];
                boxes_[n].extend(boxes_[node.right]);
                continue;
            }
            for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
                Box3f part = scene.bounds[tree_.items[i]];
                for (int axis = 0; axis < 3; ++axis) {
                    part.min[axis] = std::max(part.min[axis], node.cell.min[axis]);
                    part.max[axis] = std::min(part.max[axis], node.cell.max[axis]);
                }
                boxes_[n].extend(part);
            }
        }
    }

    void prepare(State& state) const {
        const CullScene::Data& scene = scene_.data();
        state.cache.reset(options_.cache_bytes);
        state.stack.reserve(2 * kMaxKdDepth + 4);
        state.list.reserve(std::size_t(kMaxKdDepth + 2) * std::max(most_, kDetailOccluders));
        state.current.reserve(most_);
        state.ranked.reserve(most_);
        for (std::vector<std::uint32_t>* per_polygon : {&state.in_target, &state.in_current, &state.rank})
            per_polygon->assign(scene.occluders.polygons.size(), 0);
        state.decided.assign(scene.object_count(), 0);
        state.in_use = most_;
    }

    /// The set of the viewer's leaf and direction, approached by a few members per frame; at first and after a jump at
    /// once.
    void follow_set(const Camera& camera, State& state) const {
        std::span<const std::uint32_t> target = target_set(camera, state);
        for (std::uint32_t polygon : target)
            state.in_target[polygon] = state.frame;
        auto is_wanted = [&](std::uint32_t polygon) { return state.in_target[polygon] == state.frame; };
        auto kept = std::count_if(state.current.begin(), state.current.end(), is_wanted);
        if (2 * static_cast<std::size_t>(kept) < state.current.size() || state.current.empty()) {
            state.current.assign(target.begin(), target.end());
            return;
        }
        std::uint32_t changes = kChanges;
        for (std::size_t i = state.current.size(); i-- > 0 && changes > 0;)
            if (!is_wanted(state.current[i])) {
                state.current[i] = state.current.back();
                state.current.pop_back();
                --changes;
            }
        for (std::uint32_t polygon : state.current)
            state.in_current[polygon] = state.frame;
        for (std::uint32_t polygon : target)
            if (changes < 2 * kChanges && state.in_current[polygon] != state.frame) {
                state.current.push_back(polygon);
                ++changes;
            }
    }

    /// As a rule "- a (N . V) / |D|^2", with the viewing direction V as in the paper.
    double promise(std::uint32_t polygon, const Camera& camera, const OccluderInterest& interest) const {
        const OccluderPolygon& p = scene_.data().occluders.polygons[polygon];
        Vec3d sight = p.centre - camera.eye;
        double squared = camera.orthographic ? 1 : dot(sight, sight) + 0.05 * p.area;
        return interest.promise(polygon, p, p.area, std::abs(dot(p.normal, camera.forward)), squared);
    }

    /// The usable members of the set, those that promise most first, as many as pay; with a PVS what the cell sees.
    void list_occluders(const Camera& camera, const SightStart& sight, State& state) const {
        state.ranked.clear();
        state.interest.look(scene_.data(), choice_, pvs_, camera);
        for (std::uint32_t polygon : state.current)
            if (is_usable(polygon, sight, state) && state.interest.is_seen(scene_.data().occluders.polygons[polygon]))
                state.ranked.push_back({-promise(polygon, camera, state.interest), polygon});
        std::sort(state.ranked.begin(), state.ranked.end());
        for (const auto& [score, polygon] : state.ranked) {
            if (state.list.size() >= state.in_use)
                break;
            state.rank[polygon] = static_cast<std::uint32_t>(state.list.size());
            state.list.push_back(polygon);
        }
    }

    /// Occluders behind the last that hid anything for a while go; when the last ones hide something, more come.
    void adapt(State& state) const {
        if (!options_.adapt || state.frame % kTrialFrames != 0)
            return;
        if (4 * state.useful > 3 * state.in_use)
            state.in_use = std::min(most_, state.in_use + state.in_use / 2 + 1);
        else
            state.in_use = std::min(most_, std::max(kLeastInUse, state.useful + state.useful / 2 + 1));
        state.useful = 0;
    }

    /// The recursion of the paper: a node that is fully occluded is done with; below it only the occluders that hide
    /// it in part are tried.
    void walk(const Camera& camera, State& state, CullResult& result) const {
        FrustumPlanes planes = frustum_planes(camera, scene_.data().tree_box);
        SightStart sight = sight_start(camera, scene_.data().tree_box);
        if (state.cache.empty())
            prepare(state);
        ++state.frame;
        state.cache.begin_frame();
        if (!options_.reuse)
            state.cache.reset(options_.cache_bytes);
        state.list.clear();
        state.stack.clear();
        state.viewpoint = camera.orthographic ? Viewpoint(-camera.forward, 0) : Viewpoint(camera.eye, 1);
        state.start = {};
        for (const Vec3d& corner : sight.corners)
            state.start.extend(corner);
        follow_set(camera, state);
        list_occluders(camera, sight, state);
        result.counters.occluders_used = state.list.size();
        state.stack.push_back({0, 0, static_cast<std::uint32_t>(state.list.size())});
        while (!state.stack.empty()) {
            Entry entry = state.stack.back();
            state.stack.pop_back();
            const KdNode& node = tree_.nodes[entry.node];
            ++result.counters.boxes_tested;
            if (!is_in_view(boxes_[entry.node], planes)) {
                ++result.counters.outside_frustum;
                continue;
            }
            // Children are handled before anything above them on the stack: their part of the list can be reused.
            state.list.resize(entry.first + entry.count);
            Entry below{0, 0, 0};
            if (is_hidden(entry, boxes_[entry.node], below, state, result.counters)) {
                ++result.counters.hidden_by_planes;
            } else if (node.leaf()) {
                report_leaf(node, camera, planes, sight, state, result);
            } else {
                ++result.counters.nodes_visited;
                state.stack.push_back({node.right, below.first, below.count});
                state.stack.push_back({entry.node + 1, below.first, below.count});
            }
        }
        adapt(state);
    }

    void report_leaf(const KdNode& node, const Camera& camera, const FrustumPlanes& planes, const SightStart& sight,
                     State& state, CullResult& result) const {
        const CullScene::Data& scene = scene_.data();
        for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
            std::uint32_t object = tree_.items[i];
            if (state.decided[object] == state.frame) // in another leaf
                continue;
            state.decided[object] = state.frame;
            ++result.counters.boxes_tested;
            if (!is_in_view(scene.bounds[object], planes))
                ++result.counters.outside_frustum;
            else if (!is_hidden_detail(object, camera, sight, state, result.counters))
                mark_visible(result, object);
        }
    }

    /// Faces the viewer, and nothing of it can lie in front of the near plane; a solid's holds for who is outside of it.
    bool is_usable(std::uint32_t polygon, const SightStart& sight, const State& state) const {
        const OccluderSet& set = scene_.data().occluders;
        const OccluderPolygon& p = set.polygons[polygon];
        int side = facing(p, sight.camera);
        return side != 0 && is_beyond_near(p, side, sight) && !(p.synthetic && !set.solids[p.solid].serves(state.start));
    }

    /// Full occlusion of the box by one of the entry's occluders, or by those together that hide it in part; else
    /// `below` gets the latter. The entry's occluders face the eye.
    bool is_hidden(const Entry& entry, const Box3f& box, Entry& below, State& state, CullCounters& counters) const {
        const Viewpoint eye = state.viewpoint;
        below.first = static_cast<std::uint32_t>(state.list.size());
        for (std::uint32_t i = entry.first; i < entry.first + entry.count; ++i) {
            std::uint32_t occluder = state.list[i];
            if (is_before(box, occluder, eye))
                continue; // and so is everything in it
            const Relation& pair = relation(entry.node, box, occluder, state, counters);
            // A box on both sides of the occluder's plane, such as the root, has children that are wholly behind.
            Occlusion occlusion = pair.possible ? classify(pair, eye, margin(eye)) : Occlusion::partial;
            if (occlusion == Occlusion::full) {
                state.useful = std::max(state.useful, state.rank[occluder] + 1);
                return true;
            }
            if (occlusion == Occlusion::partial) {
                state.list.push_back(occluder);
                ++below.count;
            }
        }
        return options_.joined && below.count > 1 && is_hidden_together(entry.node, box, below, state, counters);
    }

    /// Nothing of the box is behind the occluder's plane, as seen from the eye.
    bool is_before(const Box3f& box, std::uint32_t occluder, const Viewpoint& eye) const {
        const OccluderPolygon& polygon = scene_.data().occluders.polygons[occluder];
        double side = is_in_front(polygon, eye) ? 1 : -1, farthest = polygon.offset * side;
        for (int axis = 0; axis < 3; ++axis) {
            double n = polygon.normal[axis] * side;
            farthest += n * (n > 0 ? box.min[axis] : box.max[axis]);
        }
        return farthest >= 0;
    }

    /// Joined occluders: all supporting planes, but for those of edges that two of the occluders share.
    bool is_hidden_together(std::uint32_t node, const Box3f& box, const Entry& below, State& state,
                            CullCounters& counters) const {
        const Viewpoint eye = state.viewpoint;
        const OccluderSet& set = scene_.data().occluders;
        std::span<const std::uint32_t> together(state.list.data() + below.first, below.count);
        std::uint32_t part[kMostListed], done[kMostListed];
        std::uint32_t done_count = 0;
        auto has_planes = [&](std::uint32_t occluder) { return relation(node, box, occluder, state, counters).possible; };
        for (std::uint32_t seed : together) {
            // Only a connected part can have fewer planes than its members alone.
            if (std::find(done, done + done_count, seed) != done + done_count || !has_planes(seed))
                continue;
            std::uint32_t size = 0;
            part[size++] = seed;
            for (std::uint32_t at = 0; at < size; ++at)
                for_neighbours(set, part[at], [&](std::uint32_t, std::uint32_t neighbour) {
                    if (std::find(part, part + size, neighbour) == part + size &&
                        std::find(together.begin(), together.end(), neighbour) != together.end() && has_planes(neighbour))
                        part[size++] = neighbour;
                });
            std::copy(part, part + size, done + done_count); // parts are disjoint
            done_count += size;
            if (size < 2)
                continue;
            bool all = true;
            for (std::uint32_t m = 0; m < size && all; ++m) {
                const Relation& pair = relation(node, box, part[m], state, counters);
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
            if (!all)
                continue;
            for (std::uint32_t m = 0; m < size; ++m)
                state.useful = std::max(state.useful, state.rank[part[m]] + 1);
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

    static bool is_in_front(const OccluderPolygon& polygon, const Viewpoint& eye) {
        return dot(polygon.normal, eye.at) + polygon.offset * eye.weight > 0;
    }

    /// Do the two, which both face the eye, lie on opposite sides of their edge as seen from there?
    static bool is_across(const OccluderSet& set, std::uint32_t polygon, std::uint32_t edge, std::uint32_t neighbour,
                          const Viewpoint& eye) {
        const OccluderPolygon &a = set.polygons[polygon], &b = set.polygons[neighbour];
        bool same_direction = (set.neighbours[a.first + edge] & kSameDirection) != 0;
        bool same_side = is_in_front(a, eye) == is_in_front(b, eye);
        return same_side != same_direction;
    }

    /// Detail objects have occluders of their own: those large in the direction of the viewer as seen from the object's
    /// centre. They are tested against the whole box.
    bool is_hidden_detail(std::uint32_t object, const Camera& camera, const SightStart& sight, State& state,
                          CullCounters& counters) const {
        if (most_ == 0 || !options_.detail)
            return false;
        const Box3f& box = scene_.data().bounds[object];
        Vec3d centre = to_double(box).centre();
        std::size_t before = state.list.size();
        std::uint32_t useful = state.useful;
        for (std::uint32_t polygon : detail_sets_.at(centre, camera.orthographic ? -camera.forward : camera.eye - centre))
            if (is_usable(polygon, sight, state) && state.list.size() < before + kDetailOccluders)
                state.list.push_back(polygon);
        // Boxes of objects are numbered behind those of nodes.
        Entry entry{static_cast<std::uint32_t>(tree_.nodes.size()) + object, static_cast<std::uint32_t>(before),
                    static_cast<std::uint32_t>(state.list.size() - before)};
        Entry below{0, 0, 0};
        bool hidden = is_hidden(entry, box, below, state, counters);
        counters.hidden_by_planes += hidden;
        state.list.resize(before);
        state.useful = useful; // these occluders are not of the set
        return hidden;
    }

    double margin(const Viewpoint& eye) const { return 1e-9 * (eye.weight * extent_ + length(eye.at)); }

    /// From the cache, or formed and kept. Which side of a double-sided occluder the box must be on depends on the eye.
    const Relation& relation(std::uint32_t number, const Box3f& box, std::uint32_t occluder, State& state,
                             CullCounters& counters) const {
        static const Relation impossible;
        const OccluderPolygon& polygon = scene_.data().occluders.polygons[occluder];
        bool front = is_in_front(polygon, state.viewpoint);
        // Most pairs end here, at the price of one plane; they are not worth a place in the cache.
        if (!is_behind(box, polygon, front ? 1 : -1, 1e-9 * extent_))
            return impossible;
        bool known = false;
        Relation& found = state.cache.find(relation_key(number, occluder, front), known);
        ++(known ? counters.relations_cached : counters.relations_made);
        if (!known)
            form_relation(scene_.data().occluders, polygon, to_double(box), 1e-9 * extent_, found);
        return found;
    }

    CullScene scene_;
    PublishedPlanesOptions options_;
    OccluderChoice choice_;
    const Pvs* pvs_;
    std::uint32_t most_;
    KdTree tree_;
    std::vector<Box3f> boxes_; ///< per node: what it holds of its objects' boxes
    OccluderSets sets_, detail_sets_;
    SpaceCells cells_;                        ///< where sets_ is empty: of what maker_ makes
    std::unique_ptr<OccluderSetMaker> maker_;
    double extent_ = 1;
    std::uint64_t serial_;
};

} // namespace

Result<CullerPointer> make_published_planes(const CullScene& scene, const CullerOptions& options) {
    if (options.published.leaf_objects == 0 || options.published.cache_bytes < (1u << 16))
        return Status(ErrorCode::usage, "planes-published wants leaves of at least 1 object and a cache of at least 65536 bytes");
    return CullerPointer(std::make_unique<PublishedPlanes>(scene, options));
}

} // namespace antumbra
