// Occlusion trees in their modern form (docs/methods/occlusion_tree.md). `planes` decides what single occluders hide.
// Of what it leaves the tree hides what occluders hide together: one exact query per box, begun where the box around it
// came down to, with the point that was seen last time tried first.
#include "cull/methods.hpp"
#include "cull/result_bits.hpp"
#include "cull/tree_choice.hpp"
#include "cull/view_planes.hpp"
#include "occlusion_tree/tree_occluders.hpp"

#include <algorithm>
#include <array>
#include <string>

namespace antumbra {
namespace {

constexpr std::uint32_t kMostOccluders = 512;
constexpr std::uint32_t kMostPlanes = 64;        ///< occluders of the stage before
constexpr int kClasses = 24;                     ///< nodes by the logarithm of what is left below
constexpr double kForget = 0.9;                  ///< what a frame's counts keep of the frames before
constexpr double kQuery = 8;                     ///< what a test costs besides the planes it puts the box to, in planes
constexpr std::uint32_t kProbeFrames = 8, kProbeShare = 4; ///< where tests do not pay: each so-manieth, to see if they do now

/// What tests of nodes of one size have cost and brought, fading. Counts of planes, not times: the same views give the
/// same decisions on every machine.
struct Experience {
    double tests = 0, hidden = 0, planes = 0;
};

struct Entry {
    std::uint32_t node;
    OcclusionTree::Reach reach; ///< where its children start
};

struct Candidate {
    double distance;
    std::uint32_t polygon;
};

struct State final : ViewState::Storage {
    State(const CullScene::Data& scene, const TreeOccluders& occluders, const TreeChoice& choices, std::uint32_t most)
        : tree({.nodes = 48 * most + 1024, .lines = 48 * most + 4096, .fragments = 12 * most + 256}), builder(occluders, most),
          seen(scene.wide.size() * kWidth, Vec3f{NAN, NAN, NAN}), left((scene.order.size() + 63) / 64), wanted(occluders.polygons.size()),
          choice(choices, most), hidden_last(scene.always_visible.size()) {
        stack.reserve(scene.stack_bound);
        order.reserve(2 * std::size_t(most));
        sorted.reserve(2 * std::size_t(most));
    }
    ViewState planes;
    OcclusionTree tree;
    TreeBuilder builder;
    std::vector<Vec3f> seen;          ///< per child of every wide node: a point of it that was unblocked
    std::vector<std::uint64_t> left;  ///< by place in CullScene::Data::order: reported by planes, not hidden yet
    std::vector<std::uint32_t> wanted; ///< per polygon: the last frame that chose it
    std::uint32_t frame = 0;
    std::vector<Candidate> order;     ///< chosen polygons, nearest first; kept as the start for the next frame's order
    std::vector<std::uint32_t> sorted;
    TreeChoice::Memory choice;
    OccluderInterest interest;
    std::vector<std::uint64_t> hidden_last; ///< by object: hidden by the tree when it last looked
    std::vector<Entry> stack;
    Experience experience[kClasses];
};

class ModernTree final : public Culler {
  public:
    ModernTree(const CullScene& scene, const CullerOptions& options, CullerPointer planes)
        : scene_(scene), planes_(std::move(planes)), most_(options.occluders), options_(options.tree), pvs_(options.pvs), occluder_choice_(options.occluder_choice),
          serial_(new_culler_serial()) {
        const CullScene::Data& data = scene.data();
        occluders_ = TreeOccluders::build(data.occluders);
        place_.assign(data.object_count(), 0);
        for (std::uint32_t i = 0; i < data.order.size(); ++i)
            place_[data.order[i]] = i;
        for (std::uint32_t triangles : data.triangles)
            mean_triangles_ += double(triangles) / double(data.triangles.size());
        choice_ = TreeChoice::build(data, occluders_);
        if (!data.tree_box.empty())
            size_ = std::max(1e-30, length(to_double(data.tree_box.max) - to_double(data.tree_box.min)));
    }
    std::string_view name() const override { return "tree"; }
    Guarantee guarantee() const override { return Guarantee::conservative; }

    void cull(const View& view, ViewState& view_state, CullResult& result) const override {
        const CullScene::Data& scene = scene_.data();
        auto& state = view_state.storage<State>(serial_, scene, occluders_, choice_, most_);
        planes_->cull(view, state.planes, result);
        // Parallel lines of sight meet nowhere: planes alone.
        if (result.everything || *result.reason || view.projection == Projection::orthographic || scene.wide.empty())
            return;
        Camera camera = camera_of(view);
        ++state.frame;
        // Where single occluders hide nearly all that is hidden the tree rests, but for a probe now and then.
        bool rests = cost(state.experience[0]) >= chance(state.experience[0]) * (options_.object_worth + mean_triangles_);
        if (rests && state.frame % kProbeFrames != 0)
            return;
        state.interest.look(scene, occluder_choice_, pvs_, camera);
        choice_.choose(scene, camera, result.visible, state.hidden_last, state.interest, most_, state.choice);
        result.counters.occluders_used = grow(camera, state, result.counters);
        walk(rests, state, result);
        finish_result(result);
    }

  private:
    // -- occluders ----------------------------------------------------------------------------------------------------

    /// Around the picture, by a little more than what rounding can do: boxes need to be hidden only as far as they are in view.
    std::array<Vec3d, 4> window_of(const Camera& camera) const {
        double distance = std::max(size_, length(camera.eye));
        double rounding = (1e-13 + 4 * camera.turn) *
                          (1 + camera.half_width * camera.half_width + camera.half_height * camera.half_height);
        Vec3d right = camera.right * (camera.half_width * (1 + 1e-6) + rounding);
        Vec3d up = camera.up * (camera.half_height * (1 + 1e-6) + rounding);
        auto at = [&](double x, double y) { return camera.eye + (camera.forward + right * x + up * y) * distance; };
        return {at(-1, 1), at(1, 1), at(1, -1), at(-1, -1)};
    }

    /// The tree of this frame. The last frame's order, which is nearly right, is mended by insertion: a view that
    /// moves little sorts in linear time. Any order gives a right tree; one from near to far gives a small one.
    std::uint32_t grow(const Camera& camera, State& state, CullCounters& counters) const {
        const OccluderSet& set = scene_.data().occluders;
        for (std::uint32_t polygon : state.choice.chosen)
            state.wanted[polygon] = 2 * state.frame;
        std::size_t kept = 0;
        for (const Candidate& old : state.order)
            if (state.wanted[old.polygon] == 2 * state.frame) {
                state.wanted[old.polygon] = 2 * state.frame + 1;
                state.order[kept++] = old;
            }
        state.order.resize(kept);
        for (std::uint32_t polygon : state.choice.chosen)
            if (state.wanted[polygon] == 2 * state.frame)
                state.order.push_back({0, polygon});
        for (Candidate& one : state.order) {
            Vec3d way = set.polygons[one.polygon].centre - camera.eye;
            one.distance = dot(way, way);
        }
        for (std::size_t i = 1; i < state.order.size(); ++i) {
            Candidate one = state.order[i];
            std::size_t at = i;
            for (; at > 0 && (state.order[at - 1].distance > one.distance ||
                              (state.order[at - 1].distance == one.distance && state.order[at - 1].polygon > one.polygon));
                 --at)
                state.order[at] = state.order[at - 1];
            state.order[at] = one;
        }
        state.sorted.clear();
        for (const Candidate& one : state.order)
            state.sorted.push_back(one.polygon);
        state.tree.begin(camera.eye, size_, TreeForm::modified);
        state.tree.look_through(window_of(camera));
        std::uint32_t used = state.builder.insert(state.tree, state.sorted, TreeBuilder::Order::as_given);
        counters.tree_nodes = state.tree.node_count();
        counters.tree_fragments = state.tree.fragment_count();
        counters.budget_spent = state.tree.ran_out();
        return used;
    }

    // -- the walk over what planes has left -----------------------------------------------------------------------------

    static std::uint64_t bits_from(std::uint32_t first, std::uint32_t count, std::size_t word) {
        std::uint32_t low = static_cast<std::uint32_t>(word * 64);
        std::uint64_t mask = ~std::uint64_t(0);
        if (first > low)
            mask &= ~std::uint64_t(0) << (first - low);
        if (first + count < low + 64)
            mask &= (std::uint64_t(1) << (first + count - low)) - 1;
        return mask;
    }
    static std::uint32_t count_left(const State& state, std::uint32_t first, std::uint32_t count) {
        std::uint32_t sum = 0;
        for (std::size_t word = first / 64; word <= (first + count - 1) / 64; ++word)
            sum += static_cast<std::uint32_t>(std::popcount(state.left[word] & bits_from(first, count, word)));
        return sum;
    }
    static void clear_left(State& state, std::uint32_t first, std::uint32_t count) {
        for (std::size_t word = first / 64; word <= (first + count - 1) / 64; ++word)
            state.left[word] &= ~bits_from(first, count, word);
    }

    // The paper's minimum cost, found automatically: a test is made if it is expected to cost less than it saves.

    static double chance(const Experience& e) { return (e.hidden + 1) / (e.tests + 2); }
    static double cost(const Experience& e) { return kQuery + (e.planes + 32) / (e.tests + 1); }

    /// A node saves the tests of what is left below.
    static bool node_pays(const Experience& node, const Experience& object, std::uint32_t left) {
        return cost(node) < chance(node) * left * cost(object);
    }
    /// An object saves its drawing.
    bool object_pays(const Experience& object, std::uint32_t index) const {
        const std::vector<std::uint32_t>& triangles = scene_.data().triangles;
        if (!triangles.empty() && triangles[index] < options_.minimum_object_cost)
            return false;
        return cost(object) < chance(object) * (options_.object_worth + (triangles.empty() ? 0 : triangles[index]));
    }

    void walk(bool probe, State& state, CullResult& result) const {
        const CullScene::Data& scene = scene_.data();
        CullCounters& counters = result.counters;
        std::fill(state.left.begin(), state.left.end(), 0);
        for (std::size_t word = 0; word < result.visible.size(); ++word)
            for (std::uint64_t rest = result.visible[word] & ~scene.always_visible[word]; rest; rest &= rest - 1) {
                std::uint32_t at = place_[word * 64 + static_cast<std::size_t>(std::countr_zero(rest))];
                state.left[at / 64] |= std::uint64_t(1) << (at % 64);
            }
        Experience now[kClasses];
        state.stack.clear();
        if (state.tree.fragment_count() > 0)
            state.stack.push_back({0, state.tree.whole_picture()});
        while (!state.stack.empty()) {
            Entry entry = state.stack.back();
            state.stack.pop_back();
            state.tree.release(entry.reach);
            const CullNode& node = scene.wide[entry.node];
            ++counters.nodes_visited;
            for (std::uint32_t slot = 0; slot < node.used; ++slot) {
                std::uint32_t left = count_left(state, node.first[slot], node.count[slot]);
                if (left == 0)
                    continue;
                bool object = node.child[slot] & kObjectChild;
                auto size = object ? 0 : std::min(kClasses - 1, static_cast<int>(std::bit_width(left)));
                Box3d box = to_double(node.box(static_cast<int>(slot)));
                OcclusionTree::Reach reach = object ? entry.reach : state.tree.narrow(box, entry.reach);
                bool test = object ? object_pays(state.experience[0], node.child[slot] & ~kObjectChild) ||
                                         (probe && (node.child[slot] + state.frame / kProbeFrames) % kProbeShare == 0)
                                   : node_pays(state.experience[size], state.experience[0], left);
                counters.tests_saved += !test;
                if (test && is_hidden(box, reach, object, state.seen[std::size_t(entry.node) * kWidth + slot], state, now[size],
                                      counters.tree_queries)) {
                    ++counters.hidden_by_tree;
                    clear_left(state, node.first[slot], node.count[slot]);
                } else if (!object) {
                    state.stack.push_back({node.child[slot], reach});
                }
                counters.tree_tests += test;
            }
        }
        for (int c = 0; c < kClasses; ++c) {
            state.experience[c].tests = kForget * state.experience[c].tests + now[c].tests;
            state.experience[c].hidden = kForget * state.experience[c].hidden + now[c].hidden;
            state.experience[c].planes = kForget * state.experience[c].planes + now[c].planes;
        }
        counters.tree_planes_tested = state.tree.planes_tested();
        take_left(state, result);
    }

    /// `reach`: where to start, and then where boxes within may start.
    bool is_hidden(const Box3d& box, OcclusionTree::Reach& reach, bool object, Vec3f& seen, State& state, Experience& now,
                   std::uint64_t& queries) const {
        std::uint64_t before = state.tree.planes_tested();
        bool hidden = false;
        if (!(box.contains(to_double(seen)) && state.tree.is_seen(to_double(seen), reach))) {
            Vec3d point{NAN, NAN, NAN};
            bool keeps = !object && options_.start == TreeStart::reached_leaves;
            hidden = state.tree.hides(box, OcclusionTree::Reach(reach), &point, keeps ? &reach : nullptr);
            ++queries;
            seen = {static_cast<float>(point.x), static_cast<float>(point.y), static_cast<float>(point.z)};
        }
        now.tests += 1;
        now.hidden += hidden;
        now.planes += double(state.tree.planes_tested() - before);
        return hidden;
    }

    void take_left(State& state, CullResult& result) const {
        const CullScene::Data& scene = scene_.data();
        state.hidden_last = result.visible;
        std::copy(scene.always_visible.begin(), scene.always_visible.end(), result.visible.begin());
        for (std::size_t word = 0; word < state.left.size(); ++word)
            for (std::uint64_t rest = state.left[word]; rest; rest &= rest - 1)
                mark_visible(result, scene.order[word * 64 + static_cast<std::size_t>(std::countr_zero(rest))]);
        for (std::size_t word = 0; word < state.hidden_last.size(); ++word)
            state.hidden_last[word] &= ~result.visible[word];
    }

    CullScene scene_;
    CullerPointer planes_;
    std::uint32_t most_;
    OcclusionTreeOptions options_;
    const Pvs* pvs_;
    OccluderChoice occluder_choice_;
    double size_ = 1, mean_triangles_ = 0;
    std::uint64_t serial_;
    TreeOccluders occluders_;
    TreeChoice choice_;
    std::vector<std::uint32_t> place_; ///< of an object in CullScene::Data::order
};

} // namespace

Result<CullerPointer> make_tree(const CullScene& scene, const CullerOptions& options) {
    if (options.occluders > kMostOccluders)
        return Status(ErrorCode::usage, std::to_string(options.occluders) + " occluders are more than tree takes; use at most 512");
    CullerOptions stage = options;
    stage.occluders = std::min(options.occluders, kMostPlanes);
    Result<CullerPointer> planes = make_planes(scene, stage);
    if (!planes)
        return planes.status();
    return CullerPointer(std::make_unique<ModernTree>(scene, options, std::move(*planes)));
}

} // namespace antumbra
