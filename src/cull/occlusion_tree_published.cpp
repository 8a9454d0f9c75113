// Occlusion trees as Bittner, Havran and Slavik published them in 1998: a kd-tree of objects, occluders of the largest
// area-angle among the visible leaves of the last frame, an occlusion tree of them each frame, a node cost below which
// nodes are drawn without a test, and marks that save tests of nodes that stay visible in part.
#include "cull/methods.hpp"
#include "cull/occluder_interest.hpp"
#include "cull/result_bits.hpp"
#include "cull/shadow.hpp"
#include "cull/view_planes.hpp"
#include "occlusion_tree/tree_occluders.hpp"
#include "tree/kd_tree.hpp"

#include <algorithm>
#include <numeric>
#include <string>

namespace antumbra {
namespace {

constexpr std::uint32_t kMostOccluders = 256;
constexpr std::uint32_t kMostPotential = 1u << 15; ///< the largest polygons of the scene
constexpr double kStepsOfReach = 100;              ///< lambda of the paper
constexpr double kLeastReach = 0.25;               ///< of the scene's size: for those who hardly move
constexpr double kJump = 0.02;                     ///< of the scene's size: last frame's leaves say nothing
constexpr double kTurn = 0.7;                      ///< cosine of a turn that is a jump, too

enum class TreeMethod : std::uint8_t { f, fse, fme, fmc };

struct Entry {
    std::uint32_t node, parent;
    std::uint8_t planes; ///< of the frustum that the cell may cross
    bool visible;        ///< known to be wholly visible
};

struct State final : ViewState::Storage {
    State(const TreeOccluders& occluders, std::size_t nodes, std::size_t potential, std::uint32_t most)
        : tree({.nodes = 64 * most + 1024, .lines = 64 * most + 4096, .fragments = 16 * most + 256}),
          builder(occluders, most), marked(nodes), seen(potential) {
        leaves.reserve(nodes);
        stack.reserve(2 * kMaxKdDepth + 2);
        candidates.reserve(potential);
        chosen.reserve(most);
        usable.reserve(most);
    }
    OcclusionTree tree;
    TreeBuilder builder;
    std::vector<unsigned char> marked;  ///< per node of the kd-tree
    std::vector<std::uint32_t> leaves;  ///< visible in the last frame
    std::vector<Entry> stack;
    std::vector<std::uint32_t> seen;    ///< per potential occluder: the last choice that met it
    std::uint32_t choice = 0;
    std::vector<std::pair<double, std::uint32_t>> candidates;
    std::vector<std::uint32_t> chosen, usable;
    OccluderInterest interest;
    bool fresh = true;
    Vec3d eye, forward;
    double longest_step = 0;
};

class PublishedTree final : public Culler {
  public:
    PublishedTree(const CullScene& scene, const CullerOptions& options, TreeMethod method, std::string_view name)
        : scene_(scene), options_(options.tree), pvs_(options.pvs), choice_(options.occluder_choice), most_(options.occluders), method_(method), name_(name),
          serial_(new_culler_serial()) {
        const CullScene::Data& data = scene.data();
        KdTreeOptions kd;
        kd.leaf_items = 1;
        kd.most_copies = 8; // walls and floors are in many cells
        kd_ = build_kd_tree(data.bounds, data.order, kd);
        sum_costs();
        if (method != TreeMethod::f) {
            occluders_ = TreeOccluders::build(data.occluders);
            find_potential_occluders();
        }
        if (!data.tree_box.empty())
            size_ = std::max(1e-30, length(to_double(data.tree_box.max) - to_double(data.tree_box.min)));
    }
    std::string_view name() const override { return name_; }
    Guarantee guarantee() const override { return Guarantee::conservative; }

    void cull(const View& view, ViewState& view_state, CullResult& result) const override {
        const CullScene::Data& scene = scene_.data();
        begin_result(scene, result);
        if (const char* problem = problem_of(view))
            return mark_everything(scene, result, problem);
        bool occlusion = method_ != TreeMethod::f;
        // Shadow planes meet in a viewpoint; parallel lines of sight have none.
        if (occlusion && view.projection == Projection::orthographic)
            result.reason = "occlusion trees as published know no orthographic views: frustum only";
        else if (occlusion && most_ == 0)
            result.reason = "no occluders allowed: frustum only";
        else if (occlusion && potential_.empty())
            result.reason = "the scene has no occluders: frustum only";
        occlusion = occlusion && *result.reason == 0;
        if (!kd_.nodes.empty()) {
            auto& state = view_state.storage<State>(serial_, occluders_, kd_.nodes.size(), potential_.size(),
                                                    method_ == TreeMethod::f ? 0 : most_);
            Camera camera = camera_of(view);
            FrustumPlanes planes = frustum_planes(camera, scene.tree_box);
            if (occlusion)
                prepare(camera, planes, state, result.counters);
            walk(camera, planes, occlusion, state, result);
            if (occlusion)
                choose(camera, state);
        }
        finish_result(result);
    }

  private:
    // -- once per scene -----------------------------------------------------------------------------------------------

    /// The cost of a node: triangles of the objects in it, each counted once.
    void sum_costs() {
        cost_.resize(kd_.nodes.size());
        if (!kd_.nodes.empty())
            objects_below(0);
    }
    std::vector<std::uint32_t> objects_below(std::uint32_t node) {
        std::vector<std::uint32_t> objects;
        if (kd_.nodes[node].leaf()) {
            auto first = kd_.items.begin() + kd_.nodes[node].first;
            objects.assign(first, first + kd_.nodes[node].count);
        } else {
            std::vector<std::uint32_t> left = objects_below(node + 1), right = objects_below(kd_.nodes[node].right);
            std::set_union(left.begin(), left.end(), right.begin(), right.end(), std::back_inserter(objects));
        }
        const std::vector<std::uint32_t>& triangles = scene_.data().triangles;
        for (std::uint32_t object : objects)
            cost_[node] += triangles.empty() ? options_.minimum_cost : triangles[object];
        return objects;
    }

    /// Potential occluders by the leaves that their boxes touch.
    void find_potential_occluders() {
        const OccluderSet& set = scene_.data().occluders;
        for (std::uint32_t p = 0; p < set.polygons.size(); ++p)
            if (occluders_.polygons[p].usable)
                potential_.push_back(p);
        std::sort(potential_.begin(), potential_.end(), [&](std::uint32_t a, std::uint32_t b) {
            return set.polygons[a].area != set.polygons[b].area ? set.polygons[a].area > set.polygons[b].area : a < b;
        });
        potential_.resize(std::min<std::size_t>(potential_.size(), kMostPotential));
        std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs; // leaf, potential occluder
        std::vector<std::uint32_t> stack;
        for (std::uint32_t i = 0; i < potential_.size() && !kd_.nodes.empty(); ++i) {
            Box3f box;
            for (std::uint32_t v : set.loop(set.polygons[potential_[i]]))
                box.extend(set.vertices[v]);
            stack.assign(1, 0);
            while (!stack.empty()) {
                std::uint32_t node = stack.back();
                stack.pop_back();
                if (!kd_.nodes[node].cell.overlaps(box))
                    continue;
                if (kd_.nodes[node].leaf()) {
                    pairs.push_back({node, i});
                } else {
                    stack.push_back(kd_.nodes[node].right);
                    stack.push_back(node + 1);
                }
            }
        }
        std::sort(pairs.begin(), pairs.end());
        first_potential_.assign(kd_.nodes.size() + 1, 0);
        for (auto [leaf, i] : pairs) {
            ++first_potential_[leaf + 1];
            leaf_potential_.push_back(i);
        }
        std::partial_sum(first_potential_.begin(), first_potential_.end(), first_potential_.begin());
    }

    // -- occluders of a frame -----------------------------------------------------------------------------------------

    /// The occlusion tree of this frame, from the occluders that the last frame's visible leaves offered. At first and
    /// after a jump the leaves in the frustum stand for them.
    void prepare(const Camera& camera, const FrustumPlanes& planes, State& state, CullCounters& counters) const {
        double step = length(camera.eye - state.eye);
        bool jumped = state.fresh || !(step <= kJump * size_) || dot(camera.forward, state.forward) < kTurn;
        if (jumped) {
            std::fill(state.marked.begin(), state.marked.end(), 0);
            find_leaves_in_view(planes, state);
            state.eye = camera.eye;
            choose(camera, state);
        } else {
            state.longest_step = std::max(state.longest_step, step);
        }
        state.fresh = false;
        state.eye = camera.eye;
        state.forward = camera.forward;
        SightStart sight = sight_start(camera, scene_.data().tree_box);
        Box3d start = near_box(camera);
        start.extend(camera.eye);
        state.usable.clear();
        for (std::uint32_t occluder : state.chosen)
            if (is_usable(occluder, sight, start))
                state.usable.push_back(occluder);
        state.tree.begin(camera.eye, size_, method_ == TreeMethod::fse ? TreeForm::plain : TreeForm::modified,
                         options_.extra_nodes ? ExtraNodes::at_sharp_angles : ExtraNodes::none);
        counters.occluders_used = state.builder.insert(state.tree, state.usable, TreeBuilder::Order::binary_space_partition);
        counters.tree_nodes = state.tree.node_count();
        counters.tree_fragments = state.tree.fragment_count();
        counters.budget_spent = state.tree.ran_out();
    }

    /// Shows a side that blocks, with nothing of it nearer than the near plane, from outside of its solid.
    bool is_usable(std::uint32_t occluder, const SightStart& sight, const Box3d& start) const {
        const OccluderSet& set = scene_.data().occluders;
        const OccluderPolygon& polygon = set.polygons[occluder];
        int side = facing(polygon, sight.camera);
        if (side == 0 || !is_beyond_near(polygon, side, sight))
            return false;
        return !polygon.synthetic || set.solids[polygon.solid].serves(start);
    }

    void find_leaves_in_view(const FrustumPlanes& planes, State& state) const {
        state.leaves.clear();
        state.stack.clear();
        state.stack.push_back({0, 0, static_cast<std::uint8_t>(planes.mask()), true});
        while (!state.stack.empty()) {
            Entry entry = state.stack.back();
            state.stack.pop_back();
            const KdNode& node = kd_.nodes[entry.node];
            if (!is_in_view(node.cell, planes, entry.planes))
                continue;
            if (node.leaf()) {
                state.leaves.push_back(entry.node);
                continue;
            }
            state.stack.push_back({node.right, 0, entry.planes, true});
            state.stack.push_back({entry.node + 1, 0, entry.planes, true});
        }
    }

    /// "Dynamic occluder selection" (section 3): the largest area-angles among the visible leaves within reach.
    void choose(const Camera& camera, State& state) const {
        const OccluderSet& set = scene_.data().occluders;
        double reach = options_.reach > 0 ? options_.reach
                       : state.longest_step > 0 ? std::max(kStepsOfReach * state.longest_step, kLeastReach * size_)
                                                : std::numeric_limits<double>::infinity();
        ++state.choice;
        state.interest.look(scene_.data(), choice_, pvs_, camera);
        state.candidates.clear();
        for (std::uint32_t leaf : state.leaves) {
            if (length(to_double(kd_.nodes[leaf].cell).centre() - camera.eye) > reach)
                continue;
            for (std::uint32_t at = first_potential_[leaf]; at < first_potential_[leaf + 1]; ++at) {
                std::uint32_t i = leaf_potential_[at];
                if (state.seen[i] == state.choice)
                    continue;
                state.seen[i] = state.choice;
                double measure = promise(potential_[i], set.polygons[potential_[i]], camera, state.interest);
                if (measure > 0)
                    state.candidates.push_back({-measure, potential_[i]});
            }
        }
        std::size_t count = std::min<std::size_t>(most_, state.candidates.size());
        std::partial_sort(state.candidates.begin(), state.candidates.begin() + static_cast<std::ptrdiff_t>(count),
                          state.candidates.end());
        state.chosen.clear();
        for (std::size_t i = 0; i < count; ++i)
            state.chosen.push_back(state.candidates[i].second);
    }

    /// As a rule -A (N . V) / |D|^2 with N turned to the eye; 0 for sides that do not block.
    double promise(std::uint32_t index, const OccluderPolygon& polygon, const Camera& camera, const OccluderInterest& interest) const {
        int side = facing(polygon, camera);
        if (side == 0)
            return 0;
        Vec3d away = polygon.centre - camera.eye;
        double squared = dot(away, away);
        Vec3d along = options_.area_angle == AreaAngle::viewing_direction ? camera.forward : away / std::sqrt(squared);
        return interest.promise(index, polygon, polygon.area, -side * dot(polygon.normal, along), squared);
    }

    // -- the walk -----------------------------------------------------------------------------------------------------

    /// Clears the bits of planes that the box is wholly inside of.
    static bool is_in_view(const Box3f& box, const FrustumPlanes& planes, std::uint8_t& active) {
        for (int i = 0; i < planes.count; ++i) {
            if (!(active >> i & 1))
                continue;
            const float* n = planes.normal[i];
            float far_sum = n[0] * (n[0] >= 0 ? box.max.x : box.min.x) + n[1] * (n[1] >= 0 ? box.max.y : box.min.y) +
                            n[2] * (n[2] >= 0 ? box.max.z : box.min.z);
            if (far_sum + planes.offset[i] < 0)
                return false;
            float near_sum = n[0] * (n[0] >= 0 ? box.min.x : box.max.x) + n[1] * (n[1] >= 0 ? box.min.y : box.max.y) +
                             n[2] * (n[2] >= 0 ? box.min.z : box.max.z);
            if (near_sum + planes.inside[i] >= 0)
                active = static_cast<std::uint8_t>(active & ~(1u << i));
        }
        return true;
    }

    Visibility visibility_of(const Box3f& box, State& state) const {
        switch (method_) {
        case TreeMethod::fse: return state.tree.visibility_by_faces(to_double(box));
        case TreeMethod::fme: return state.tree.visibility_unsplit(to_double(box), LeafTest::pyramid, inner_);
        case TreeMethod::fmc: return state.tree.visibility_unsplit(to_double(box), LeafTest::conservative, inner_);
        case TreeMethod::f: break;
        }
        return Visibility::full;
    }

    /// Section 5.3, with the marks of 5.4.
    void walk(const Camera&, const FrustumPlanes& planes, bool occlusion, State& state, CullResult& result) const {
        CullCounters& counters = result.counters;
        state.leaves.clear();
        state.stack.clear();
        state.stack.push_back({0, 0, static_cast<std::uint8_t>(planes.mask()), !occlusion});
        while (!state.stack.empty()) {
            Entry entry = state.stack.back();
            state.stack.pop_back();
            const KdNode& node = kd_.nodes[entry.node];
            ++counters.boxes_tested;
            if (!is_in_view(node.cell, planes, entry.planes)) {
                ++counters.outside_frustum;
                state.marked[entry.parent] = 0;
                continue;
            }
            bool cheap = cost_[entry.node] < options_.minimum_cost;
            if (!entry.visible && !cheap && !state.marked[entry.node]) {
                ++counters.tree_tests;
                Visibility visibility = visibility_of(node.cell, state);
                if (visibility != Visibility::partial)
                    state.marked[entry.parent] = 0;
                if (visibility == Visibility::invisible) {
                    ++counters.hidden_by_tree;
                    continue;
                }
                entry.visible = visibility == Visibility::full;
                if (visibility == Visibility::partial && !node.leaf() && options_.retest == Retest::when_unmarked)
                    state.marked[entry.node] = 1;
            } else if (!entry.visible) {
                ++counters.tests_saved;
                entry.visible = cheap;
            }
            if (node.leaf()) {
                state.leaves.push_back(entry.node);
                for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
                    mark_visible(result, kd_.items[i]);
            } else {
                ++counters.nodes_visited;
                state.stack.push_back({node.right, entry.node, entry.planes, entry.visible});
                state.stack.push_back({entry.node + 1, entry.node, entry.planes, entry.visible});
            }
        }
        counters.tree_planes_tested = occlusion ? state.tree.planes_tested() : 0;
    }

    CullScene scene_;
    OcclusionTreeOptions options_;
    const Pvs* pvs_;
    OccluderChoice choice_;
    std::uint32_t most_;
    InnerTest inner_ = options_.inner_tests ? InnerTest::region : InnerTest::none;
    TreeMethod method_;
    std::string_view name_;
    double size_ = 1;
    std::uint64_t serial_;
    KdTree kd_;
    std::vector<std::uint64_t> cost_; ///< per node
    TreeOccluders occluders_;
    std::vector<std::uint32_t> potential_; ///< polygons, largest first
    std::vector<std::uint32_t> first_potential_, leaf_potential_; ///< per node of the kd-tree: indices into potential_
};

Result<CullerPointer> make(const CullScene& scene, const CullerOptions& options, TreeMethod method, std::string_view name) {
    if (options.occluders > kMostOccluders && method != TreeMethod::f)
        return Status(ErrorCode::usage, std::to_string(options.occluders) + " occluders are more than " + std::string(name) +
                                            " takes; use at most 256");
    return CullerPointer(std::make_unique<PublishedTree>(scene, options, method, name));
}

} // namespace

Result<CullerPointer> make_tree_f(const CullScene& scene, const CullerOptions& options) {
    return make(scene, options, TreeMethod::f, "tree-f");
}
Result<CullerPointer> make_tree_fse(const CullScene& scene, const CullerOptions& options) {
    return make(scene, options, TreeMethod::fse, "tree-fse");
}
Result<CullerPointer> make_tree_fme(const CullScene& scene, const CullerOptions& options) {
    return make(scene, options, TreeMethod::fme, "tree-fme");
}
Result<CullerPointer> make_tree_fmc(const CullScene& scene, const CullerOptions& options) {
    return make(scene, options, TreeMethod::fmc, "tree-fmc");
}

} // namespace antumbra
