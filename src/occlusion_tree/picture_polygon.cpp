#include "occlusion_tree/picture_polygon.hpp"

namespace antumbra {

Place locate(const Sight& sight, LineRef line, PicturePolygon& polygon, signed char* sides) {
    bool positive = false, negative = false, touches = false;
    for (int i = 0; i < polygon.count; ++i) {
        int side = sight.side(line, polygon[i].at);
        if (side == kUndecided)
            return Place::undecided;
        sides[i] = static_cast<signed char>(side);
        positive |= side > 0;
        negative |= side < 0;
        touches |= side == 0;
    }
    if (positive && negative)
        return Place::both;
    if (!positive && !negative)
        return Place::undecided; // a polygon without extent: cannot be, but hides nothing
    if (touches)
        for (int i = 0; i < polygon.count; ++i)
            if (sides[i] == 0 && sides[i + 1 == polygon.count ? 0 : i + 1] == 0) {
                polygon[i].edge = positive ? line : -line;
                polygon[i].flagged = true;
            }
    return positive ? Place::inside : Place::outside;
}

bool cut(const Sight& sight, LineRef line, const PicturePolygon& polygon, const signed char* sides,
         PicturePolygon* inside, PicturePolygon* outside) {
    if (polygon.count + 2 > PicturePolygon::kMost)
        return false;
    if (inside)
        inside->count = 0;
    if (outside)
        outside->count = 0;
    for (int i = 0; i < polygon.count; ++i) {
        const Corner& corner = polygon[i];
        int here = sides[i], next = sides[i + 1 == polygon.count ? 0 : i + 1];
        // From a corner on the line each part goes on along the line where the polygon leaves it.
        if (inside && here >= 0)
            inside->push(here == 0 && next < 0 ? Corner{corner.at, line, true} : corner);
        if (outside && here <= 0)
            outside->push(here == 0 && next > 0 ? Corner{corner.at, -line, true} : corner);
        if (here * next < 0) {
            Direction x = sight.crossing(corner.edge, line, here < 0);
            bool rising = here < 0;
            if (inside)
                inside->push(rising ? Corner{x, corner.edge, corner.flagged} : Corner{x, line, true});
            if (outside)
                outside->push(rising ? Corner{x, -line, true} : Corner{x, corner.edge, corner.flagged});
        }
    }
    return true;
}

} // namespace antumbra
