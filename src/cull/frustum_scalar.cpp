// View-frustum culling at its plainest: one box at a time, depth first over a binary tree, every box against every
// plane until one rejects it. It is the common denominator of every ratio that the project publishes: do not make it
// faster.
#include "cull/methods.hpp"
#include "cull/result_bits.hpp"
#include "cull/view_planes.hpp"

namespace antumbra {
namespace {

struct State final : ViewState::Storage {
    std::vector<std::uint32_t> stack;
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

    void walk(const FrustumPlanes& planes, std::vector<std::uint32_t>& stack, CullResult& result) const {
        const CullScene::Data& scene = scene_.data();
        stack.clear();
        stack.reserve(scene.stack_bound);
        stack.push_back(0);
        while (!stack.empty()) {
            std::uint32_t index = stack.back();
            stack.pop_back();
            const BinaryNode& node = scene.binary[index];
            ++result.counters.boxes_tested;
            if (is_outside(node.box, planes)) {
                ++result.counters.outside_frustum;
            } else if (node.right == 0) {
                mark_visible(result, scene.order[node.first]);
            } else {
                ++result.counters.nodes_visited;
                stack.push_back(node.right);
                stack.push_back(index + 1);
            }
        }
    }

    CullScene scene_;
    std::uint64_t serial_;
};

} // namespace

CullerPointer make_frustum_scalar(const CullScene& scene) { return std::make_unique<FrustumScalar>(scene); }

} // namespace antumbra
