// A baked potentially visible set within the view frustum. The boxes of a cell's objects are gathered when the view
// enters it; each frame tests only those, eight at a time, without a tree.
//
// Which cells: nothing nearer than the near plane is drawn, so a wall between the eye and the near plane hides
// nothing. Every line of sight of the picture starts on the near rectangle, hence the sets of all cells that this
// rectangle touches are united (mostly that is one cell). It also serves orthographic views.
#include "cull/box_kernels.hpp"
#include "cull/methods.hpp"
#include "cull/result_bits.hpp"

#include <array>
#include <string>

namespace antumbra {
namespace {

struct Pack {
    float min[3][kWidth];
    float max[3][kWidth];
    std::uint32_t object[kWidth];
    std::uint32_t used = 0;
};

/// The cells low..high (inclusive, per axis); `known` is false where no answer is baked.
struct CellRange {
    std::array<std::uint32_t, 3> low{}, high{};
    bool known = false;
    bool operator==(const CellRange&) const = default;
};

struct State final : ViewState::Storage {
    bool fresh = true;
    CellRange range;
    bool everything = false;
    std::vector<std::uint64_t> visible, row;
    std::vector<Pack> packs;
    std::uint32_t listed = 0; ///< objects in the packs
    PvsCursor cursor;         ///< of a view tree
};

constexpr std::uint32_t kMostCells = 64; ///< a near rectangle over more cells than that sees everything

class PvsCuller final : public Culler {
  public:
    PvsCuller(const CullScene& scene, const Pvs& pvs, BoxKernel kernel)
        : scene_(scene), pvs_(pvs), kernel_(kernel), serial_(new_culler_serial()) {}
    std::string_view name() const override { return "pvs"; }

    /// What a cell sees, cut by one view, is at best a superset of what the view sees.
    Guarantee guarantee() const override {
        bool safe = pvs_.guarantee() == Guarantee::exact || pvs_.guarantee() == Guarantee::conservative;
        return safe ? Guarantee::conservative : Guarantee::approximate;
    }

    void cull(const View& view, ViewState& view_state, CullResult& result) const override {
        const CullScene::Data& scene = scene_.data();
        begin_result(scene, result);
        if (const char* problem = problem_of(view))
            return mark_everything(scene, result, problem);
        State& state = view_state.storage<State>(serial_);
        Camera camera = camera_of(view);
        bool changed = pvs_.tree().nodes.empty() ? ask_grid(camera, state) : ask_tree(camera, state);
        if (changed || state.fresh)
            gather(state);
        state.fresh = false;
        if (state.everything)
            result.reason = "no baked answer for this eye: frustum only";
        test(frustum_planes(camera, scene.tree_box), state, result);
        finish_result(result);
    }

  private:
    /// Whether the answer may differ from the last one.
    bool ask_grid(const Camera& camera, State& state) const {
        CellRange range = cells_of(camera);
        if (!state.fresh && range == state.range)
            return false;
        state.range = range;
        unite(state);
        return true;
    }

    bool ask_tree(const Camera& camera, State& state) const {
        Box3d local = near_box(camera);
        ViewRange range;
        range.eyes = {local.min + scene_.data().origin, local.max + scene_.data().origin};
        if (!camera.orthographic) {
            // A hair wider than the picture: the camera's own rounding must not turn a leaf away.
            double slack = 1 + 1e-9 + 4 * camera.turn;
            range.all_directions = false;
            Vec3d right = camera.right * (camera.half_width * slack), up = camera.up * (camera.half_height * slack);
            range.corners = {camera.forward - right - up, camera.forward + right - up, camera.forward + right + up,
                             camera.forward - right + up};
        }
        bool changed = pvs_.query_range(range, state.cursor);
        if (changed || state.fresh) {
            state.everything = state.cursor.everything;
            state.visible = state.cursor.visible;
        }
        return changed;
    }

    CellRange cells_of(const Camera& camera) const {
        Box3d local = near_box(camera);
        Box3d box{local.min + scene_.data().origin, local.max + scene_.data().origin};
        std::int64_t low = pvs_.grid().find(box.min), high = pvs_.grid().find(box.max);
        if (low < 0 || high < 0)
            return {};
        CellRange range;
        range.known = true;
        std::uint64_t cells = 1;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            std::uint32_t count = pvs_.grid().count[axis];
            range.low[axis] = static_cast<std::uint32_t>(low % count);
            range.high[axis] = static_cast<std::uint32_t>(high % count);
            low /= count;
            high /= count;
            cells *= range.high[axis] - range.low[axis] + 1;
        }
        return cells <= kMostCells ? range : CellRange{};
    }

    /// The union of the rows of state.range.
    void unite(State& state) const {
        state.visible.assign(pvs_.words_per_row(), 0);
        state.row.resize(pvs_.words_per_row());
        state.everything = !state.range.known;
        const CellRange& range = state.range;
        for (std::uint32_t k = range.low[2]; k <= range.high[2]; ++k)
            for (std::uint32_t j = range.low[1]; j <= range.high[1]; ++j)
                for (std::uint32_t i = range.low[0]; i <= range.high[0] && !state.everything; ++i) {
                    const std::array<std::uint32_t, 3>& count = pvs_.grid().count;
                    std::uint32_t row = pvs_.cell_row(i + count[0] * (j + std::uint64_t(count[1]) * k));
                    if (row == kCellNotBaked || row == kCellSolid) {
                        state.everything = true;
                        continue;
                    }
                    pvs_.decode_row(row, state.row);
                    for (std::size_t word = 0; word < state.row.size(); ++word)
                        state.visible[word] |= state.row[word];
                }
    }

    /// In the order of the tree, so that the boxes of a pack are neighbours.
    void gather(State& state) const {
        const CullScene::Data& scene = scene_.data();
        state.packs.reserve((scene.order.size() + kWidth - 1) / kWidth);
        state.packs.clear();
        state.listed = 0;
        for (std::uint32_t object : scene.order) {
            if (!state.everything && !(state.visible[object / 64] >> (object % 64) & 1))
                continue;
            ++state.listed;
            if (state.packs.empty() || state.packs.back().used == kWidth)
                state.packs.push_back({});
            Pack& pack = state.packs.back();
            // The first box fills all lanes, so that unused ones hold numbers that are harmless.
            for (std::uint32_t lane = pack.used; lane < (pack.used ? pack.used + 1 : kWidth); ++lane)
                for (int axis = 0; axis < 3; ++axis) {
                    pack.min[axis][lane] = scene.bounds[object].min[axis];
                    pack.max[axis][lane] = scene.bounds[object].max[axis];
                }
            pack.object[pack.used++] = object;
        }
    }

    void test(const FrustumPlanes& planes, const State& state, CullResult& result) const {
        BoxVerdicts verdicts;
        for (const Pack& pack : state.packs) {
            kernel_({pack.min, pack.max}, planes, planes.mask(), verdicts);
            std::uint32_t mask = (1u << pack.used) - 1;
            for (std::uint32_t rest = mask & ~verdicts.outside; rest; rest &= rest - 1)
                mark_visible(result, pack.object[std::countr_zero(rest)]);
            result.counters.outside_frustum += static_cast<std::uint32_t>(std::popcount(mask & verdicts.outside));
        }
        result.counters.boxes_tested = state.listed;
        result.counters.hidden_by_pvs = scene_.data().order.size() - state.listed;
    }

    CullScene scene_;
    const Pvs& pvs_;
    BoxKernel kernel_;
    std::uint64_t serial_;
};

} // namespace

Result<CullerPointer> make_pvs(const CullScene& scene, const CullerOptions& options) {
    if (!options.pvs)
        return Status(ErrorCode::usage, "the method 'pvs' needs a baked .pvs file");
    BoxKernel kernel = box_kernel(options.instruction_set);
    if (!kernel)
        return Status(ErrorCode::unsupported, "this processor lacks the instruction set that was asked for; use automatic");
    return CullerPointer(std::make_unique<PvsCuller>(scene, *options.pvs, kernel));
}

} // namespace antumbra
