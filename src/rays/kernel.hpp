// The inner loops of the tracer, one set of entry points per instruction set. All sets give the same bits: a
// hit is decided per (ray, triangle) by the operations written down in kernel.inl, in that order; the tree
// only prunes.
#pragma once

#include "rays/caster.hpp"
#include "rays/prepared_ray.hpp"
#include "rays/triangle_tree.hpp"

namespace antumbra::rays {

/// Receives hits. `front`: the ray comes from the counter-clockwise side.
struct HitSink {
    void (*add)(void* self, double t, std::uint32_t triangle, bool front, bool double_sided) = nullptr;
    void* self = nullptr;
};

struct Kernel {
    const char* name;
    /// rays::prepare().
    bool (*prepare)(const Ray& ray, double scene_size, PreparedRay& prepared);
    /// The nearest triangle drawn towards each ray, with t in units of the ray's own direction.
    void (*first_hits)(const TreeView& tree, double scene_size, std::span<const Ray> rays,
                       std::span<Hit> hits);
    /// The nearest triangle drawn towards the ray, if nearer than best.t or tied with a lower index.
    void (*nearest)(const TreeView& tree, const PreparedRay& ray, Hit& best);
    /// The same, and reports every candidate that improved `best` or tied with it.
    void (*nearest_ties)(const TreeView& tree, const PreparedRay& ray, Hit& best, const HitSink& sink);
    /// Reports every drawn triangle with t <= limit.
    void (*all)(const TreeView& tree, const PreparedRay& ray, double limit, const HitSink& sink);
    /// The nearest triangle from whatever side, reported like nearest_ties.
    void (*surface)(const TreeView& tree, const PreparedRay& ray, Hit& best, const HitSink& sink);
};

const Kernel& scalar_kernel();
/// Null where the machine or the compiler's target lacks it.
const Kernel* avx2_kernel();
const Kernel* avx512_kernel();

/// The fastest one that this machine can run.
const Kernel& best_kernel();

} // namespace antumbra::rays
