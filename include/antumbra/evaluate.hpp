// Truth and measurement: is what a .pvs or a culler reports right, and what does it save?
//
// Truth is an item buffer traced in strict doubles; a pixel that would convict a method is judged again by exact
// arithmetic before it counts. Coordinates in results are world coordinates.
#pragma once

#include <antumbra/cull.hpp>
#include <antumbra/job.hpp>
#include <antumbra/pvs.hpp>
#include <antumbra/scene.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace antumbra {

/// ErrorCode::mismatch unless `pvs` was baked from exactly this scene. The message says whether another scene was
/// baked, or this one before its geometry, flags or sides changed.
Status check_belongs(const Scene& scene, const Pvs& pvs);

// -- verify: a .pvs against the truth ------------------------------------------------------------------------------

struct VerifyOptions {
    std::uint32_t samples = 200;  ///< viewpoints
    std::uint32_t face_size = 64; ///< a viewpoint sees six square pictures of that many pixels squared
    std::uint64_t seed = 1;
    std::uint32_t worst = 20;     ///< longest list of the worst
};

/// An object that was seen from a viewpoint and is not in the answer for it.
struct FalseInvisible {
    Vec3d eye;
    std::int64_t cell = -1;
    std::uint32_t object = 0;
    std::uint64_t pixels = 0; ///< confirmed ones
};

struct VerifyResult {
    std::uint64_t viewpoints = 0;
    std::uint64_t in_matter = 0; ///< random points that were no viewpoints and were drawn again
    std::uint64_t pixels = 0;    ///< rays of all viewpoints together
    /// Totals over the viewpoints. A false invisible pixel is one whose ray exact arithmetic has confirmed.
    std::uint64_t false_invisible_objects = 0, false_invisible_pixels = 0;
    /// Pixels against the file that exact arithmetic did not confirm: lines that graze an edge (measure zero), and
    /// lines that are blocked after all (the double-precision tracer rounded).
    std::uint64_t grazing_pixels = 0, unconfirmed_pixels = 0;
    /// Reported, but in no pixel of the viewpoint. Holds objects that only other viewpoints of the cell see and
    /// those smaller than a pixel, so that even an exact file has some.
    std::uint64_t false_visible_objects = 0;
    std::uint64_t reported_objects = 0, seen_objects = 0;
    std::vector<FalseInvisible> worst; ///< most pixels first
};

/// Random viewpoints, uniform over the baked cells, each with a full panorama. Needs check_belongs(). The result is
/// a function of the arguments alone. ErrorCode::usage if no baked cell holds a viewpoint.
Result<VerifyResult> verify(const Scene& scene, const Pvs& pvs, const VerifyOptions& options = {},
                            const Job& job = {});

/// May `guarantee` lose pixels? False for exact and conservative.
bool may_lose_pixels(Guarantee guarantee);

} // namespace antumbra
