// Truth from one viewpoint: what each pixel sees, by rays in strict doubles. Shares no code with any rasteriser.
#pragma once

#include "evaluate/pixel_rays.hpp"
#include "rays/arbiter.hpp"

#include <antumbra/job.hpp>

#include <span>
#include <vector>

namespace antumbra {

/// Where in its pixel a ray goes.
enum class PixelSampling : std::uint8_t {
    centre,   ///< through the middle, as a rasteriser samples
    jittered, ///< at a random point of the pixel, so that no ray runs along a wall that was built on the axes
};

struct ItemOptions {
    PixelSampling sampling = PixelSampling::centre;
    std::uint64_t seed = 1, stream = 0; ///< of the jitter
};

/// Per pixel the *set* of objects that its ray sees: all that tie at the first occluding hit, and every see-through
/// surface in front of it.
class ItemBuffer {
  public:
    /// A pure function of the arguments, whatever job.threads. One ray a pixel. Ended early by job.cancelled(), the
    /// buffer is of no use.
    static ItemBuffer render(const Tracer& tracer, const PixelRays& rays, const ItemOptions& options = {},
                             const Job& job = {});

    std::uint32_t width() const { return rays_.width(); }
    std::uint32_t height() const { return rays_.height(); }
    /// One triangle of each object that pixel (x, y) sees, by object.
    std::span<const std::uint32_t> seen(std::uint32_t x, std::uint32_t y) const {
        std::size_t pixel = std::size_t(y) * width() + x;
        return std::span(triangles_).subspan(begin_[pixel], begin_[pixel + 1] - begin_[pixel]);
    }
    /// The ray that was traced for the pixel.
    Ray ray(std::uint32_t x, std::uint32_t y) const;

  private:
    explicit ItemBuffer(const PixelRays& rays, const ItemOptions& options) : rays_(rays), options_(options) {}
    PixelRays rays_;
    ItemOptions options_;
    std::vector<std::uint64_t> begin_; ///< pixels + 1 offsets into triangles_
    std::vector<std::uint32_t> triangles_;
};

/// Sets the bit of every object that some pixel sees.
void mark_seen(const Scene& scene, const ItemBuffer& buffer, std::span<std::uint64_t> bits);

/// What became of the pixels that see an object which was reported hidden, once exact arithmetic had judged each.
struct LostPixels {
    std::uint32_t object = 0;
    std::uint64_t confirmed = 0;   ///< an unblocked line, and so are all lines close to it: lost for certain
    std::uint64_t grazing = 0;     ///< touches an edge or a vertex: measure zero, proves nothing
    std::uint64_t unconfirmed = 0; ///< the tracer says seen, exact arithmetic says blocked: the tracer rounded
    std::uint32_t x = 0, y = 0;    ///< the first confirmed pixel, else the first of any kind
};

/// Judges every pixel that sees an object whose bit is not set in `reported` (bit o%64 of word o/64). By object.
std::vector<LostPixels> find_lost_pixels(const Scene& scene, const Arbiter& arbiter, const ItemBuffer& buffer,
                                         std::span<const std::uint64_t> reported);

inline bool has_bit(std::span<const std::uint64_t> bits, std::uint32_t index) {
    return bits[index / 64] >> (index % 64) & 1;
}
inline void set_bit(std::span<std::uint64_t> bits, std::uint32_t index) {
    bits[index / 64] |= std::uint64_t(1) << (index % 64);
}

} // namespace antumbra
