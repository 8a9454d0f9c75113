// The frames in which a mesh has most of its surface along the axes.
#pragma once

#include "occluder_finding/closed_objects.hpp"

#include <antumbra/math.hpp>

#include <vector>

namespace antumbra {

/// Three directions at right angles.
struct Frame {
    Vec3d axis[3]{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

    Vec3d to_frame(const Vec3d& p) const { return {dot(axis[0], p), dot(axis[1], p), dot(axis[2], p)}; }
    Vec3d from_frame(const Vec3d& p) const { return axis[0] * p.x + axis[1] * p.y + axis[2] * p.z; }
};

inline Vec3d to_vector(const grid::Point& p) { return {double(p[0]), double(p[1]), double(p[2])}; }
inline grid::Point to_grid(const Vec3d& p) { return {std::llround(p.x), std::llround(p.y), std::llround(p.z)}; }

/// The frame of most area, if it is another one than the grid's and holds a fifth more of the area; else none. Only a
/// proposal. O(triangles).
std::vector<Frame> oriented_frames(const GridMesh& mesh);

/// The mesh in the frame, relative to `origin`, rounded to whole steps; coordinates that differ by a few steps, as those of one
/// wall do after rounding, become one.
GridMesh turned(const GridMesh& mesh, const Frame& frame, const Vec3d& origin);

} // namespace antumbra
