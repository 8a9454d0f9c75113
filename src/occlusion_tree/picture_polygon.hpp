// Convex polygons of the picture (cones of directions) and cutting them by lines.
#pragma once

#include "occlusion_tree/sight.hpp"

namespace antumbra {

/// Corners in the order in which edges have the polygon on their positive side. A polygon of the picture spans less
/// than half of all directions. Fixed room: cuts that would not fit are undecided. The numbers of the corners lie in lanes,
/// so that kernels take several at a time (side_kernels.hpp).
struct PicturePolygon {
    static constexpr int kMost = 40;
    alignas(64) double x[kMost];
    double y[kMost], z[kMost];
    double error[kMost], size[kMost];
    struct Facts {
        std::uint32_t point;
        LineRef first, second; ///< of Direction
        LineRef edge;          ///< from this corner to the next; the polygon is on its positive side
        bool flagged;          ///< the edge lies in a plane of the tree (Bittner, Havran, Slavik 1998, section 6.1)
    } facts[kMost];
    int count = 0;

    PicturePolygon() = default;
    PicturePolygon(const PicturePolygon& other) { *this = other; }
    /// Copies the corners that are used.
    PicturePolygon& operator=(const PicturePolygon& other) {
        count = 0;
        for (int i = 0; i < other.count; ++i)
            push_from(other, i);
        return *this;
    }
    void push(const Direction& at, LineRef edge, bool flagged) {
        x[count] = at.d.x;
        y[count] = at.d.y;
        z[count] = at.d.z;
        error[count] = at.error;
        size[count] = at.size;
        facts[count++] = {at.point, at.first, at.second, edge, flagged};
    }
    void push_from(const PicturePolygon& other, int i) {
        x[count] = other.x[i];
        y[count] = other.y[i];
        z[count] = other.z[i];
        error[count] = other.error[i];
        size[count] = other.size[i];
        facts[count++] = other.facts[i];
    }
    /// The same corner, where another edge begins.
    void push_from(const PicturePolygon& other, int i, LineRef edge) {
        push_from(other, i);
        facts[count - 1].edge = edge;
        facts[count - 1].flagged = true;
    }
    Direction at(int i) const {
        return {{x[i], y[i], z[i]}, error[i], size[i], facts[i].point, facts[i].first, facts[i].second};
    }
    std::uint32_t point(int i) const { return facts[i].point; }
    LineRef edge(int i) const { return facts[i].edge; }
    bool flagged(int i) const { return facts[i].flagged; }
};

/// Where a polygon lies: only strict sides count, so that a polygon that touches a line is wholly on one side.
enum class Place : std::uint8_t { inside, outside, both, undecided };

/// The place of a polygon and, if it is on both sides, the sides of its corners. If the polygon is on one side, edges that lie in
/// `line` become `line` and are flagged.
Place locate(const Sight& sight, LineRef line, PicturePolygon& polygon, signed char* sides);

/// The parts of a polygon of Place::both. Either part may be nullptr. New edges are `line`, flagged. False if there is
/// no room. `polygon` is neither of the parts.
bool cut(const Sight& sight, LineRef line, const PicturePolygon& polygon, const signed char* sides,
         PicturePolygon* inside, PicturePolygon* outside);

} // namespace antumbra
