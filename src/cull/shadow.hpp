// The shadow of an occluder from one viewpoint: half-spaces that together hold nothing but what it hides.
//
// A box is inside all supporting planes of an occluder, as seen from the box's side in Coorg and Teller's test, exactly
// when it lies inside the planes through the viewpoint and the occluder's edges and behind the occluder; with the
// viewpoint fixed, the latter planes serve every box. For a group of polygons the planes of edges between two
// members that both face the viewpoint are left out, and a box must lie behind every member.
//
// Why that is sound for any group: suppose a direction within all remaining edge planes missed all members. Walk in
// the picture from it straight to a point inside a member; where the walk first enters the union it crosses an edge
// that has no member on its other side, from outside to inside; so the direction lay outside of that edge's plane.
#pragma once

#include "cull/box_kernels.hpp"
#include "cull/scene_data.hpp"
#include "geometry/camera.hpp"

namespace antumbra {

inline constexpr int kMostShadowPlanes = 24;

/// Half-spaces in float, padded for the boxes of a domain. A point is inside where normal . p + certainly > 0 for
/// all planes, and certainly outside where normal . p + possibly < 0 for one.
struct Shadow {
    int count = 0;
    float normal[kMostShadowPlanes][3];
    float certainly[kMostShadowPlanes], possibly[kMostShadowPlanes];
};

/// Where lines of sight start, in all that shadows need of it.
struct SightStart {
    Camera camera;
    double near_depth = 0;   ///< the near plane, or just above zero
    Vec3d corners[5];        ///< of the near rectangle, and the eye (in orthographic views the first corner again)
    Box3f domain;            ///< around all boxes that will be tested
};
SightStart sight_start(const Camera& camera, const Box3f& domain);

/// The shadow of the members that face the viewer. Members that may reach in front of the near plane within the
/// picture are clipped there. False if there is no shadow, or if it would take too many planes.
bool cast_shadow(const OccluderSet& set, std::span<const std::uint32_t> members, const SightStart& start,
                 Shadow& shadow);

/// Does everything between the viewer and the near plane lie certainly in front of the polygon (its front for side 1,
/// its back for -1)? Then no part of the polygon that a line of sight meets is left undrawn.
bool is_beyond_near(const OccluderPolygon& polygon, int side, const SightStart& start);

/// 1: the polygon certainly shows its front, -1: certainly its back and blocks there too, 0: neither.
int facing(const OccluderPolygon& polygon, const Camera& camera);

struct ShadowVerdicts {
    std::uint32_t hidden = 0;  ///< bit per box: certainly inside the shadow
    std::uint32_t outside = 0; ///< bit per box: certainly outside, with everything in it
};

/// Eight boxes against one shadow; lanes not in `alive` are not looked at (their bits are meaningless). All kernels
/// agree on the lanes of `alive`.
using ShadowKernel = ShadowVerdicts (*)(const EightBoxes& boxes, const Shadow& shadow, std::uint32_t alive);
ShadowVerdicts test_shadow_scalar(const EightBoxes& boxes, const Shadow& shadow, std::uint32_t alive);
ShadowKernel shadow_kernel(InstructionSet instruction_set);

} // namespace antumbra
