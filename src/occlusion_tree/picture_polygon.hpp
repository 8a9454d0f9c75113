// Convex polygons of the picture (cones of directions) and cutting them by lines.
#pragma once

#include "occlusion_tree/sight.hpp"

#include <algorithm>
#include <array>

namespace antumbra {

struct Corner {
    Direction at;
    LineRef edge;      ///< from this corner to the next; the polygon is on its positive side
    bool flagged = false; ///< the edge lies in a plane of the tree (Bittner, Havran, Slavik 1998, section 6.1)
};

/// Corners in the order in which edges have the polygon on their positive side. A polygon of the picture spans less
/// than half of all directions. Fixed room: cuts that would not fit are undecided.
struct PicturePolygon {
    static constexpr int kMost = 40;
    int count = 0;
    std::array<Corner, kMost> corners;

    PicturePolygon() = default;
    PicturePolygon(const PicturePolygon& other) { *this = other; }
    /// Copies the corners that are used.
    PicturePolygon& operator=(const PicturePolygon& other) {
        count = other.count;
        std::copy_n(other.corners.begin(), count, corners.begin());
        return *this;
    }
    void push(const Corner& corner) { corners[static_cast<std::size_t>(count++)] = corner; }
    Corner& operator[](int i) { return corners[static_cast<std::size_t>(i)]; }
    const Corner& operator[](int i) const { return corners[static_cast<std::size_t>(i)]; }
};

/// Where a polygon lies: only strict sides count, so that a polygon that touches a line is wholly on one side.
enum class Place : std::uint8_t { inside, outside, both, undecided };

/// Sides of the corners, and from them the place of the polygon. If the polygon is on one side, edges that lie in
/// `line` become `line` and are flagged.
Place locate(const Sight& sight, LineRef line, PicturePolygon& polygon, signed char* sides);

/// The parts of a polygon of Place::both. Either part may be nullptr. New edges are `line`, flagged. False if there is
/// no room. `polygon` is neither of the parts.
bool cut(const Sight& sight, LineRef line, const PicturePolygon& polygon, const signed char* sides,
         PicturePolygon* inside, PicturePolygon* outside);

} // namespace antumbra
