#include "cull/methods.hpp"
#include "cull/result_bits.hpp"

namespace antumbra {
namespace {

class None final : public Culler {
  public:
    explicit None(const CullScene& scene) : scene_(scene) {}
    std::string_view name() const override { return "none"; }
    Guarantee guarantee() const override { return Guarantee::conservative; }
    void cull(const View& view, ViewState&, CullResult& result) const override {
        begin_result(scene_.data(), result);
        const char* problem = problem_of(view);
        mark_everything(scene_.data(), result, problem ? problem : "the method culls nothing");
    }

  private:
    CullScene scene_;
};

} // namespace

CullerPointer make_none(const CullScene& scene) { return std::make_unique<None>(scene); }

} // namespace antumbra
