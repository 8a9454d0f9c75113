// The judge behind prove(): random frames, and one method at one frame.
#pragma once

#include "base/random.hpp"
#include "evaluate/item_buffer.hpp"

#include <antumbra/evaluate.hpp>

#include <vector>

namespace antumbra {

/// Frame `frame` of the proof with that seed. Every kProofBurst frames begin somewhere else; within a burst the viewer
/// moves. The aspect is width / height. A pure function of the arguments.
inline constexpr std::uint64_t kProofBurst = 8;
View proof_view(const Tracer& tracer, std::uint64_t seed, std::uint64_t frame, double aspect);

/// The truth of one frame.
class ProofFrame {
  public:
    ProofFrame(const Tracer& tracer, const View& view, std::uint64_t frame, const ProofOptions& options,
               const Job& job);

    const std::vector<std::uint64_t>& seen() const { return seen_; }
    /// Adds to `method` what `reported` shows of it; what `in_frustum` lacks is not judged. Objects lost for certain go
    /// to `losses`.
    void judge(const std::vector<std::uint64_t>& in_frustum, const std::vector<std::uint64_t>& reported,
               ProofMethod& method, std::vector<ProofLoss>& losses) const;

  private:
    struct Counts {
        std::uint64_t confirmed = 0, grazing = 0, unconfirmed = 0;
    };
    /// Lines through random points of hidden objects: they find what slips between pixels.
    void aim(const std::vector<std::uint64_t>& hidden, ProofMethod& method, std::vector<LostPixels>& lost) const;

    const Tracer& tracer_;
    View view_;
    std::uint64_t frame_;
    const ProofOptions& options_;
    PixelRays rays_;
    ItemBuffer buffer_;
    std::vector<std::uint64_t> seen_;
};

} // namespace antumbra
