#include "occlusion_tree/picture_polygon.hpp"

#include "occlusion_tree/side_kernels.hpp"

namespace antumbra {

Place locate(const Sight& sight, LineRef line, PicturePolygon& polygon, signed char* sides) {
    SideMasks certain = sight.certain_sides(line, polygon);
    std::uint64_t all = (std::uint64_t(1) << polygon.count) - 1;
    if (certain.positive == all || certain.negative == all)
        return certain.positive == all ? Place::inside : Place::outside;
    bool positive = false, negative = false, touches = false;
    for (int i = 0; i < polygon.count; ++i) {
        int side = certain.positive >> i & 1 ? 1 : certain.negative >> i & 1 ? -1 : sight.unfiltered_side(line, polygon.at(i));
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
                polygon.facts[i].edge = positive ? line : -line;
                polygon.facts[i].flagged = true;
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
        int here = sides[i], next = sides[i + 1 == polygon.count ? 0 : i + 1];
        // From a corner on the line each part goes on along the line where the polygon leaves it.
        if (inside && here >= 0)
            here == 0 && next < 0 ? inside->push_from(polygon, i, line) : inside->push_from(polygon, i);
        if (outside && here <= 0)
            here == 0 && next > 0 ? outside->push_from(polygon, i, -line) : outside->push_from(polygon, i);
        if (here * next < 0) {
            bool rising = here < 0, flagged = polygon.flagged(i);
            LineRef edge = polygon.edge(i);
            Direction x = sight.crossing(edge, line, rising);
            if (inside)
                rising ? inside->push(x, edge, flagged) : inside->push(x, line, true);
            if (outside)
                rising ? outside->push(x, -line, true) : outside->push(x, edge, flagged);
        }
    }
    return true;
}

} // namespace antumbra
