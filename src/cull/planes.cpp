// Supporting planes in their modern form (docs/methods/planes.md): the viewpoint is fixed for a frame, so the planes
// of one occluder serve all boxes; eight boxes are tested at a time; the occluder that hid a node last frame is
// tried first; occluders whose shadow a node does not touch are not tried below it.
#include "cull/joined_shadows.hpp"
#include "cull/methods.hpp"
#include "cull/result_bits.hpp"
#include "cull/shadow.hpp"
#include "cull/view_planes.hpp"

#include <algorithm>
#include <string>

namespace antumbra {
namespace {

constexpr std::uint32_t kMostOccluders = 64; ///< bits of a word
constexpr std::uint32_t kSpare = 4;          ///< candidates per occluder that is used
constexpr std::uint32_t kStepsPerFrame = 64;   ///< nodes of the occluder tree that a frame opens
constexpr std::uint32_t kStepsAtOnce = 4096;   ///< at first and after a jump, in view only
constexpr std::uint32_t kStepsFromThere = 256; ///< per frame, until all around is searched from there
constexpr std::uint16_t kIdle = 120;           ///< frames that an occluder may hide nothing; then it makes room
constexpr std::uint16_t kRest = 48;            ///< frames until it is tried again
constexpr std::uint16_t kTrial = 4;            ///< frames of a trial: in these each box is once put to several shadows together
constexpr double kJump = 0.02;               ///< of the scene's size: who moves farther starts afresh
constexpr double kStep = 0.002;              ///< who moves less keeps the occluders found
constexpr std::uint32_t kJoinEvery = 4;        ///< frames in which a box is put once to several shadows together
constexpr int kJoinTries = 8;                  ///< shadows that others are joined to
constexpr std::uint8_t kNoSlot = 0xFF;
constexpr std::uint32_t kNoGroup = 0xFFFFFFFFu;

struct Entry {
    std::uint32_t node, planes;
    std::uint64_t relevant; ///< occluders whose shadow the node may touch
};

struct State final : ViewState::Storage {
    OccluderSearch search, first_search; ///< all around; and in view alone, where the viewer has just come
    bool fresh = true;
    bool partial = false;                  ///< the search all around from here is still under way
    std::uint16_t frame = 0;
    std::vector<std::uint16_t> hid;        ///< per group: the frame in which it last hid something,
    std::vector<std::uint16_t> tried;      ///< and in which its trial began
    PvsCursor cell;                        ///< what the cell of the eye sees
    Vec3d searched_from;                   ///< where the search under way began
    std::vector<std::uint32_t> candidates; ///< groups in view, best first
    std::vector<Shadow> shadows;
    std::vector<std::uint32_t> slot_group;
    std::vector<std::uint8_t> slot_of;     ///< per group
    std::vector<std::uint32_t> last;       ///< per child of every wide node: the group that hid it
    std::vector<std::uint32_t> joined;     ///< the same, the first of several that hid it together
    std::vector<Entry> stack;
};

class Planes final : public Culler {
  public:
    Planes(const CullScene& scene, const CullerOptions& options, BoxKernel boxes, ShadowKernel shadows)
        : scene_(scene), pvs_(options.pvs), choice_(options.occluder_choice), occluders_(options.occluders), box_kernel_(boxes), shadow_kernel_(shadows),
          size_(scene.data().tree_box.empty() ? 1 : length(to_double(scene.data().tree_box.max) - to_double(scene.data().tree_box.min))),
          serial_(new_culler_serial()) {}
    std::string_view name() const override { return "planes"; }
    Guarantee guarantee() const override { return Guarantee::conservative; }

    void cull(const View& view, ViewState& view_state, CullResult& result) const override {
        const CullScene::Data& scene = scene_.data();
        begin_result(scene, result);
        if (const char* problem = problem_of(view))
            return mark_everything(scene, result, problem);
        if (occluders_ == 0)
            result.reason = "no occluders allowed: frustum only";
        else if (scene.groups.groups.empty())
            result.reason = "the scene has no occluders: frustum only";
        if (!scene.wide.empty()) {
            auto& state = view_state.storage<State>(serial_);
            Camera camera = camera_of(view);
            FrustumPlanes planes = frustum_planes(camera, scene.tree_box);
            choose(camera, planes, state);
            cast(camera, state, result.counters);
            walk(planes, state, result);
        }
        finish_result(result);
    }

  private:
    /// Keeps the list of candidates current: a bounded part of a search per frame, more of it at first and after jumps.
    void choose(const Camera& camera, const FrustumPlanes& planes, State& state) const {
        const CullScene::Data& scene = scene_.data();
        std::uint32_t wanted = occluders_ * kSpare;
        auto score_of = [&](std::uint32_t group) { return score(group, camera, state); };
        bool search_all = !(length(camera.eye - state.searched_from) <= kJump * size_);
        if (state.fresh) {
            state.fresh = false;
            state.slot_of.assign(scene.groups.groups.size(), kNoSlot);
            state.last.assign(scene.wide.size() * kWidth, kNoGroup);
            state.joined.assign(scene.wide.size() * kWidth, kNoGroup);
            state.hid.assign(scene.groups.groups.size(), 0);
            state.tried.assign(scene.groups.groups.size(), 0);
            state.frame = kIdle + kRest; // nobody has been tried
            state.candidates.reserve(wanted);
            state.shadows.reserve(kMostOccluders);
            state.slot_group.reserve(kMostOccluders);
            state.stack.reserve(scene.stack_bound);
            search_all = true;
        }
        if (pvs_)
            (void)pvs_->query(camera.eye + scene.origin, state.cell);
        ++state.frame;
#ifndef ANTUMBRA_SHIPPED_METHODS_ONLY // no lists are read there
        if (choice_ == OccluderChoice::first_hit && !scene.first_hit_sets.empty() && !camera.orthographic)
            return take(scene.first_hit_sets.at(camera.eye, camera.forward), planes, state);
#endif
        bool moved = length(camera.eye - state.searched_from) > kStep * size_;
        if (search_all || (moved && !state.search.running())) {
            state.search.begin(scene.occluder_tree, camera.eye, wanted);
            state.searched_from = camera.eye;
        }
        if (search_all) {
            state.first_search.begin(scene.occluder_tree, camera.eye, occluders_ + occluders_ / 4);
            state.first_search.advance(scene.occluder_tree, kStepsAtOnce, score_of,
                                       [&](const Box3f& box) { return is_in_view(box, planes); });
        }
        state.partial = search_all || (state.partial && state.search.running());
        if (state.search.running() && !search_all)
            state.search.advance(scene.occluder_tree, state.partial ? kStepsFromThere : kStepsPerFrame, score_of);
        // What was found from elsewhere is of no use; better few that fit.
        const std::vector<std::uint32_t>& found =
            state.partial ? state.first_search.found_so_far() : state.search.found();
        take(found, planes, state);
    }

    /// Candidates in the order of what they promise.
    void take(std::span<const std::uint32_t> found, const FrustumPlanes& planes, State& state) const {
        const CullScene::Data& scene = scene_.data();
        state.candidates.clear();
        for (std::uint32_t group : found) {
            if (state.candidates.size() >= occluders_ + occluders_ / 4)
                break;
            if (is_worth_a_try(group, state) && is_in_view(scene.groups.groups[group].box, planes))
                state.candidates.push_back(group);
        }
    }

    /// What the cell of the eye does not see hides nothing that others do not hide.
    float score(std::uint32_t group, const Camera& camera, const State& state) const {
        const CullScene::Data& scene = scene_.data();
        const ConvexGroups::Group& candidate = scene.groups.groups[group];
        const OccluderPolygon& polygon = scene.occluders.polygons[scene.groups.members[candidate.first]];
        if (pvs_ && !state.cell.everything && !polygon.synthetic && polygon.object < scene.object_count() &&
            !(state.cell.visible[polygon.object / 64] >> (polygon.object % 64) & 1))
            return 0;
        if (choice_ == OccluderChoice::projected_size && !camera.orthographic)
            return area_angle_bound(static_cast<float>(candidate.area), candidate.box,
                                    Vec3f{float(camera.eye.x), float(camera.eye.y), float(camera.eye.z)});
        return static_cast<float>(area_angle(candidate, camera));
    }

    /// Occluders that have hidden nothing for a while, or nothing that others did not hide first, rest.
    static bool is_worth_a_try(std::uint32_t group, State& state) {
        auto since_trial = static_cast<std::uint16_t>(state.frame - state.tried[group]);
        auto since_hiding = static_cast<std::uint16_t>(state.frame - state.hid[group]);
        if (since_hiding <= kIdle || since_trial < kTrial)
            return true;
        if (since_trial <= kRest + group % 16) // not all on the same frame
            return false;
        state.tried[group] = state.frame;
        return true;
    }

    /// Area-angle (Coorg, Teller 1997, "dynamic occluder selection"): area times cosine over squared distance, summed
    /// over the members that show the viewer their fronts, or, if that is more, those that show a double-sided back:
    /// cast_shadow() takes one of the two.
    double area_angle(const ConvexGroups::Group& group, const Camera& camera) const {
        const CullScene::Data& scene = scene_.data();
        double sum = 0, of_backs = 0;
        for (std::uint32_t m = group.first; m < group.first + group.count; ++m) {
            const OccluderPolygon& polygon = scene.occluders.polygons[scene.groups.members[m]];
            double towards, squared;
            if (camera.orthographic) {
                towards = -dot(polygon.normal, camera.forward);
                squared = 1;
            } else {
                Vec3d sight = polygon.centre - camera.eye;
                squared = dot(sight, sight) + 0.05 * polygon.area;
                towards = -dot(polygon.normal, sight) / std::sqrt(squared);
            }
            if (towards > 0)
                sum += polygon.area * towards / squared;
            else if (polygon.double_sided)
                of_backs -= polygon.area * towards / squared;
        }
        return std::max(sum, of_backs);
    }

    /// Shadows of the best candidates, best first: its place is an occluder's slot, and bit, in this frame.
    void cast(const Camera& camera, State& state, CullCounters& counters) const {
        const CullScene::Data& scene = scene_.data();
        for (std::uint32_t group : state.slot_group)
            state.slot_of[group] = kNoSlot;
        state.shadows.clear();
        state.slot_group.clear();
        Box3d start = near_box(camera);
        start.extend(camera.eye);
        SightStart sight = sight_start(camera, scene.tree_box);
        for (std::uint32_t candidate : state.candidates) {
            if (state.shadows.size() >= occluders_)
                break;
            const ConvexGroups::Group& group = scene.groups.groups[candidate];
            std::span<const std::uint32_t> members(scene.groups.members.data() + group.first, group.count);
            const OccluderPolygon& first = scene.occluders.polygons[members[0]];
            if (first.synthetic && !scene.occluders.solids[first.solid].serves(start))
                continue;
            state.shadows.emplace_back();
            if (!cast_shadow(scene.occluders, members, sight, state.shadows.back())) {
                state.shadows.pop_back();
                continue;
            }
            state.slot_of[candidate] = static_cast<std::uint8_t>(state.slot_group.size());
            state.slot_group.push_back(candidate);
        }
        counters.occluders_used = state.shadows.size();
    }

    void walk(const FrustumPlanes& planes, State& state, CullResult& result) const {
        const CullScene::Data& scene = scene_.data();
        std::uint64_t all = state.shadows.size() == 64 ? ~std::uint64_t(0)
                                                       : (std::uint64_t(1) << state.shadows.size()) - 1;
        state.stack.clear();
        state.stack.push_back({0, planes.mask(), all});
        BoxVerdicts verdicts;
        std::uint64_t relevant[kWidth];
        while (!state.stack.empty()) {
            Entry entry = state.stack.back();
            state.stack.pop_back();
            const CullNode& node = scene.wide[entry.node];
            box_kernel_({node.min, node.max}, planes, entry.planes, verdicts);
            std::uint32_t alive = node.mask() & ~verdicts.outside;
            ++result.counters.nodes_visited;
            result.counters.boxes_tested += node.used;
            result.counters.outside_frustum += count_bits(node.mask() & ~alive);
            if (entry.relevant)
                alive = hide(node, entry, alive, relevant, state, result.counters);
            for (std::uint32_t rest = alive; rest; rest &= rest - 1) {
                int slot = std::countr_zero(rest);
                std::uint32_t child = node.child[slot];
                std::uint64_t occluders = entry.relevant ? relevant[slot] : 0;
                if ((occluders & (occluders - 1)) && is_hidden_by_several(entry.node, slot, occluders, planes, verdicts.crossing[slot], state)) {
                    ++result.counters.hidden_by_planes;
                    continue;
                }
                if (child & kObjectChild)
                    mark_visible(result, child & ~kObjectChild);
                else if (verdicts.crossing[slot] || occluders)
                    state.stack.push_back({child, verdicts.crossing[slot], occluders});
                else
                    for (std::uint32_t i = node.first[slot]; i < node.first[slot] + node.count[slot]; ++i)
                        mark_visible(result, scene.order[i]);
            }
        }
    }

    /// Returns the children that are in no shadow, and fills which shadows each of them touches.
    std::uint32_t hide(const CullNode& node, const Entry& entry, std::uint32_t alive, std::uint64_t* relevant,
                       State& state, CullCounters& counters) const {
        std::uint32_t* last = state.last.data() + std::size_t(entry.node) * kWidth;
        std::uint64_t first = 0;
        for (std::uint32_t rest = alive; rest; rest &= rest - 1) {
            int slot = std::countr_zero(rest);
            relevant[slot] = 0;
            if (last[slot] != kNoGroup && state.slot_of[last[slot]] != kNoSlot)
                first |= std::uint64_t(1) << state.slot_of[last[slot]];
        }
        first &= entry.relevant;
        auto test = [&](std::uint64_t occluders, std::uint64_t& counter) {
            for (std::uint64_t rest = occluders; rest && alive; rest &= rest - 1) {
                int occluder = std::countr_zero(rest);
                ++counters.shadow_tests;
                ShadowVerdicts verdicts =
                    shadow_kernel_({node.min, node.max}, state.shadows[std::size_t(occluder)], alive);
                std::uint64_t bit = std::uint64_t(1) << occluder;
                for (std::uint32_t touched = alive & ~verdicts.outside; touched; touched &= touched - 1)
                    relevant[std::countr_zero(touched)] |= bit;
                if (!verdicts.hidden)
                    continue;
                std::uint32_t group = state.slot_group[std::size_t(occluder)];
                for (std::uint32_t hidden = verdicts.hidden; hidden; hidden &= hidden - 1)
                    last[std::countr_zero(hidden)] = group;
                state.hid[group] = state.frame;
                counter += count_bits(verdicts.hidden);
                alive &= ~verdicts.hidden;
            }
        };
        test(first, counters.hidden_by_last);
        test(entry.relevant & ~first, counters.hidden_by_planes);
        return alive;
    }

    /// What no shadow holds alone: every so-manieth frame, and always who was hidden like that the last time.
    bool is_hidden_by_several(std::uint32_t index, int slot, std::uint64_t relevant, const FrustumPlanes& view, std::uint32_t crossing,
                              State& state) const {
        std::uint32_t place = index * kWidth + static_cast<std::uint32_t>(slot), group = state.joined[place];
        int preferred = group == kNoGroup || state.slot_of[group] == kNoSlot || !(relevant >> state.slot_of[group] & 1) ? -1 : state.slot_of[group];
        if (group == kNoGroup && (place + state.frame) % kJoinEvery != 0)
            return false;
        JoinedShadows joined = find_joined_shadows(scene_.data().wide[index].box(slot), state.shadows, relevant, preferred, kJoinTries, view, crossing);
        state.joined[place] = joined.first < 0 ? kNoGroup : state.slot_group[std::size_t(joined.first)];
        for (; joined.used; joined.used &= joined.used - 1)
            state.hid[state.slot_group[std::size_t(std::countr_zero(joined.used))]] = state.frame;
        return joined.first >= 0;
    }

    CullScene scene_;
    const Pvs* pvs_;
    OccluderChoice choice_;
    std::uint32_t occluders_;
    BoxKernel box_kernel_;
    ShadowKernel shadow_kernel_;
    double size_; ///< of the scene
    std::uint64_t serial_;
};

} // namespace

Result<CullerPointer> make_planes(const CullScene& scene, const CullerOptions& options) {
    if (options.occluders > kMostOccluders)
        return Status(ErrorCode::usage, std::to_string(options.occluders) + " occluders are more than planes takes; use at most 64");
    BoxKernel boxes = box_kernel(options.instruction_set);
    ShadowKernel shadows = shadow_kernel(options.instruction_set);
    if (!boxes || !shadows)
        return Status(ErrorCode::unsupported, "this processor lacks the instruction set that was asked for; use automatic");
    return CullerPointer(std::make_unique<Planes>(scene, options, boxes, shadows));
}

} // namespace antumbra
