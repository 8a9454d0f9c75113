// View-frustum culling, eight boxes at a time over the wide tree.
#include "cull/box_kernels.hpp"
#include "cull/methods.hpp"
#include "cull/result_bits.hpp"

namespace antumbra {
namespace {

struct Entry {
    std::uint32_t node, planes;
};

struct State final : ViewState::Storage {
    std::vector<Entry> stack;
};

class Frustum final : public Culler {
  public:
    Frustum(const CullScene& scene, BoxKernel kernel)
        : scene_(scene), kernel_(kernel), serial_(new_culler_serial()) {}
    std::string_view name() const override { return "frustum"; }
    Guarantee guarantee() const override { return Guarantee::conservative; }

    void cull(const View& view, ViewState& state, CullResult& result) const override {
        const CullScene::Data& scene = scene_.data();
        begin_result(scene, result);
        if (const char* problem = problem_of(view))
            return mark_everything(scene, result, problem);
        if (!scene.wide.empty())
            walk(frustum_planes(camera_of(view), scene.tree_box), state.storage<State>(serial_).stack, result);
        finish_result(result);
    }

  private:
    void walk(const FrustumPlanes& planes, std::vector<Entry>& stack, CullResult& result) const {
        const CullScene::Data& scene = scene_.data();
        stack.clear();
        stack.reserve(scene.stack_bound);
        stack.push_back({0, planes.mask()});
        BoxVerdicts verdicts;
        while (!stack.empty()) {
            Entry entry = stack.back();
            stack.pop_back();
            const CullNode& node = scene.wide[entry.node];
            kernel_({node.min, node.max}, planes, entry.planes, verdicts);
            std::uint32_t inside = node.mask() & ~verdicts.outside;
            ++result.counters.nodes_visited;
            result.counters.boxes_tested += node.used;
            result.counters.outside_frustum += static_cast<std::uint32_t>(std::popcount(node.mask() & ~inside));
            for (std::uint32_t rest = inside; rest; rest &= rest - 1) {
                int slot = std::countr_zero(rest);
                std::uint32_t child = node.child[slot];
                if (child & kObjectChild)
                    mark_visible(result, child & ~kObjectChild);
                else if (verdicts.crossing[slot])
                    stack.push_back({child, verdicts.crossing[slot]});
                else
                    for (std::uint32_t i = node.first[slot]; i < node.first[slot] + node.count[slot]; ++i)
                        mark_visible(result, scene.order[i]);
            }
        }
    }

    CullScene scene_;
    BoxKernel kernel_;
    std::uint64_t serial_;
};

} // namespace

Result<CullerPointer> make_frustum(const CullScene& scene, const CullerOptions& options) {
    BoxKernel kernel = box_kernel(options.instruction_set);
    if (!kernel)
        return Status(ErrorCode::unsupported, "this processor lacks the instruction set that was asked for; use automatic");
    return CullerPointer(std::make_unique<Frustum>(scene, kernel));
}

} // namespace antumbra
