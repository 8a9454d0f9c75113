// View-frustum culling as most programs do it: one box at a time, depth first over a binary tree, planes that a
// node lies wholly inside of are not tested below it. It is the common denominator of every ratio that the project
// publishes: do not make it faster.
#include "cull/methods.hpp"
#include "cull/result_bits.hpp"
#include "cull/view_planes.hpp"

namespace antumbra {
namespace {

struct Entry {
    std::uint32_t node, planes;
};

struct State final : ViewState::Storage {
    std::vector<Entry> stack;
};

class FrustumScalar final : public Culler {
  public:
    explicit FrustumScalar(const CullScene& scene) : scene_(scene), serial_(new_culler_serial()) {}
    std::string_view name() const override { return "frustum-scalar"; }
    Guarantee guarantee() const override { return Guarantee::conservative; }

    void cull(const View& view, ViewState& state, CullResult& result) const override {
        const CullScene::Data& scene = scene_.data();
        begin_result(scene, result);
        if (const char* problem = problem_of(view))
            return mark_everything(scene, result, problem);
        if (!scene.binary.empty())
            walk(frustum_planes(camera_of(view), scene.tree_box), state.storage<State>(serial_).stack, result);
        finish_result(result);
    }

  private:
    /// Bits of the planes that the box may cross; kOutside if it is certainly beyond one.
    static constexpr std::uint32_t kOutside = ~std::uint32_t(0);
    static std::uint32_t test(const Box3f& box, const FrustumPlanes& planes, std::uint32_t active) {
        std::uint32_t crossing = 0;
        for (int i = 0; i < planes.count; ++i) {
            if (!(active >> i & 1))
                continue;
            const float* n = planes.normal[i];
            float far_sum = n[0] * (n[0] >= 0 ? box.max.x : box.min.x) + n[1] * (n[1] >= 0 ? box.max.y : box.min.y) +
                            n[2] * (n[2] >= 0 ? box.max.z : box.min.z);
            if (far_sum + planes.offset[i] < 0)
                return kOutside;
            float near_sum = n[0] * (n[0] >= 0 ? box.min.x : box.max.x) + n[1] * (n[1] >= 0 ? box.min.y : box.max.y) +
                             n[2] * (n[2] >= 0 ? box.min.z : box.max.z);
            if (near_sum + planes.inside[i] < 0)
                crossing |= 1u << i;
        }
        return crossing;
    }

    void walk(const FrustumPlanes& planes, std::vector<Entry>& stack, CullResult& result) const {
        const CullScene::Data& scene = scene_.data();
        stack.clear();
        stack.reserve(scene.stack_bound);
        stack.push_back({0, planes.mask()});
        while (!stack.empty()) {
            Entry entry = stack.back();
            stack.pop_back();
            const BinaryNode& node = scene.binary[entry.node];
            ++result.counters.boxes_tested;
            std::uint32_t crossing = test(node.box, planes, entry.planes);
            if (crossing == kOutside) {
                ++result.counters.outside_frustum;
            } else if (crossing == 0 || node.right == 0) {
                for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
                    mark_visible(result, scene.order[i]);
            } else {
                ++result.counters.nodes_visited;
                stack.push_back({node.right, crossing});
                stack.push_back({entry.node + 1, crossing});
            }
        }
    }

    CullScene scene_;
    std::uint64_t serial_;
};

} // namespace

CullerPointer make_frustum_scalar(const CullScene& scene) { return std::make_unique<FrustumScalar>(scene); }

} // namespace antumbra
