// Embree behind the caster's interface: a fast proposer in floats.
//
// Its answers depend on the instruction set (Embree picks its kernels, with or without FMA, at run time) and
// on float rounding, and rays may leak through edges (its own tests tolerate 2e-5). So no bit that is stored
// and no verdict may come from it: whatever it proposes has to be confirmed by the Tracer or the Arbiter.
#pragma once

#include "rays/caster.hpp"

#include <antumbra/job.hpp>
#include <antumbra/scene.hpp>

#include <memory>

namespace antumbra {

/// Keeps a reference to the scene: the scene must outlive it. Immutable and thread-safe once built.
class EmbreeCaster final : public FirstHitCaster {
  public:
    /// Builds a robust-mode hierarchy of the occluding triangles. ErrorCode::limit without memory for it,
    /// ErrorCode::internal when Embree refuses otherwise.
    static Result<EmbreeCaster> build(const Scene& scene, const Job& job = {});
    ~EmbreeCaster() override;
    EmbreeCaster(EmbreeCaster&&) noexcept;
    EmbreeCaster& operator=(EmbreeCaster&&) noexcept;

    /// Origins and directions are rounded to float. Of tied triangles any one is given. Denormals are flushed
    /// to zero within the call only.
    void first_hits(std::span<const Ray> rays, std::span<Hit> hits) const override;

  private:
    struct Implementation;
    explicit EmbreeCaster(std::unique_ptr<Implementation> implementation);
    std::unique_ptr<Implementation> implementation_;
};

} // namespace antumbra
