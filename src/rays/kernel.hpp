// The inner loops of the tracer, one set of entry points per instruction set. All sets give the same bits: a
// hit is decided per (ray, triangle) by the operations written down in kernel.inl, in that order; the tree
// only prunes.
#pragma once

#include "rays/caster.hpp"
#include "rays/prepared_ray.hpp"
#include "rays/triangle_tree.hpp"

namespace antumbra::rays {

inline constexpr int kPacket = 16; ///< most rays that walk together
inline constexpr int kBatch = 16;  ///< most rays in a call

/// Receives hits of the ray with that index. `front`: it comes from the counter-clockwise side.
struct HitSink {
    void (*add)(void* self, int ray, double t, std::uint32_t triangle, bool front,
                bool double_sided) = nullptr;
    void* self = nullptr;
};

/// Rays that run alike should be neighbours in a batch: they share their walk. It never changes an answer.
struct Kernel {
    const char* name;
    /// rays::prepare().
    bool (*prepare)(const Ray& ray, double scene_size, PreparedRay& prepared);
    /// The nearest triangle drawn towards each of any number of rays, with t in units of the ray's own
    /// direction.
    void (*first_hits)(const TreeView& tree, double scene_size, std::span<const Ray> rays,
                       std::span<Hit> hits);
    /// Of at most kBatch rays, reports every drawn triangle with t <= the ray's limit that is met on the way;
    /// each lowers the limit to its t. So the nearest and all that tie with it are reported, and some others.
    void (*nearest)(const TreeView& tree, const PreparedRay* rays, int count, double* limits,
                    const HitSink& sink);
    /// Reports every drawn triangle with t <= the ray's limit.
    void (*all)(const TreeView& tree, const PreparedRay* rays, int count, double* limits,
                const HitSink& sink);
    /// Like `nearest`, from whatever side.
    void (*surface)(const TreeView& tree, const PreparedRay* rays, int count, double* limits,
                    const HitSink& sink);
};

const Kernel& scalar_kernel();
/// Null where the machine or the compiler's target lacks it.
const Kernel* avx2_kernel();
const Kernel* avx512_kernel();

/// The fastest one that this machine can run.
const Kernel& best_kernel();

} // namespace antumbra::rays
