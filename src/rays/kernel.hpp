// The inner loops of the tracer, one set of entry points per instruction set. All sets give the same bits: a hit
// is decided per (ray, triangle) by the operations written down in kernel.inl, in that order; the tree only prunes.
#pragma once

#include "rays/caster.hpp"
#include "tree/bvh.hpp"

namespace antumbra::rays {

inline constexpr int kLanes = 4; ///< triangles in a block
inline constexpr int kWidth = 8; ///< children of a node
using Node = WideNode<kWidth>;   ///< `first` and `count` of a leaf are in blocks

/// Triangles side by side. Corners are sorted by position, so that t does not depend on the order in a file.
struct alignas(16) Block {
    float corner[3][3][kLanes];      ///< [corner][axis]; unused lanes hold one point three times, which is never hit
    std::uint32_t triangle[kLanes];
    std::uint8_t flipped = 0;        ///< bit per lane: sorting turned the winding around
    std::uint8_t double_sided = 0;   ///< bit per lane
};

struct TreeView {
    const Node* nodes = nullptr; ///< null: nothing to hit
    const Block* blocks = nullptr;
};

/// A ray prepared once for all its tests. The direction is scaled by a power of two such that its largest
/// component lies in [1, 2); `t` here is in units of that direction.
struct PreparedRay {
    double origin[3], direction[3];
    double inverse[3];       ///< 1 / direction, at most 2^64 in size
    double shear_x, shear_y, shear_z;
    double margin;           ///< by which boxes grow: see prepare()
    int axis_x, axis_y, axis_z; ///< cyclic; z is the direction's largest component
    bool against;            ///< direction[axis_z] < 0
    float near_origin[3], far_origin[3]; ///< for the planes of a box met first and last: the origin, rounded and
                                         ///< moved by twice the margin so that boxes grow
    float near_inverse[3], far_inverse[3];
    int near_row[3], far_row[3]; ///< rows of WideNode::bounds
};

/// Receives hits. `front`: the ray comes from the counter-clockwise side.
struct HitSink {
    void (*add)(void* self, double t, std::uint32_t triangle, bool front, bool double_sided) = nullptr;
    void* self = nullptr;
};

struct Kernel {
    const char* name;
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

/// The fastest one that this machine can run.
const Kernel& best_kernel();

} // namespace antumbra::rays
