#include "cull/relations.hpp"

#include "cull/tangent_table.hpp"

#include <bit>

namespace antumbra {

bool is_behind(const Box3f& box, const OccluderPolygon& polygon, double side, double margin) {
    double nearest = polygon.offset * side;
    for (int axis = 0; axis < 3; ++axis) {
        double n = polygon.normal[axis] * side;
        nearest += n * (n > 0 ? box.max[axis] : box.min[axis]);
    }
    return nearest < -margin;
}

void form_relation(const OccluderSet& set, const OccluderPolygon& polygon, const Box3d& box, double margin,
                   Relation& relation) {
    relation.possible = false;
    relation.edges = polygon.count;
    std::span<const std::uint32_t> loop = set.loop(polygon);
    for (std::uint32_t edge = 0; edge < polygon.count; ++edge) {
        Vec3d a = to_double(set.vertices[loop[edge]]);
        Vec3d along = to_double(set.vertices[loop[(edge + 1) % polygon.count]]) - a;
        Tangents tangents = find_tangents(box, a, along);
        if (!tangents.valid)
            return;
        bool has_supporting = false, has_separating = false;
        for (int corner : {int(tangents.first), int(tangents.second)}) {
            Vec3d reach = box.corner(corner) - a, normal = cross(along, reach);
            double size = length(normal);
            // Planes whose direction is uncertain by more than the margin of the test decide nothing.
            if (!(size > 1e-5 * length(along) * length(reach)))
                return;
            RelationPlane plane{normal / size, 0};
            plane.offset = -dot(plane.normal, a);
            double there = plane.at(polygon.centre);
            if (std::abs(there) < margin)
                return;
            if (there < 0)
                plane = {-plane.normal, -plane.offset};
            bool same_side = plane.at(box.centre()) > 0;
            (same_side ? relation.supporting : relation.separating)[edge] = plane;
            (same_side ? has_supporting : has_separating) = true;
        }
        if (!has_supporting || !has_separating)
            return;
    }
    relation.possible = true;
}

Occlusion classify(const Relation& relation, const Viewpoint& eye, double margin) {
    if (!relation.possible)
        return Occlusion::none;
    bool full = true;
    for (std::uint32_t edge = 0; edge < relation.edges && full; ++edge)
        full = relation.supporting[edge].at(eye) > margin;
    if (full)
        return Occlusion::full;
    for (std::uint32_t edge = 0; edge < relation.edges; ++edge)
        if (relation.separating[edge].at(eye) < -margin)
            return Occlusion::none;
    return Occlusion::partial;
}

void RelationCache::reset(std::uint64_t bytes) {
    std::uint64_t sets = std::bit_floor(std::max<std::uint64_t>(bytes / (sizeof(Relation) * kWays), 2));
    entries_.assign(static_cast<std::size_t>(sets * kWays), {});
    shift_ = 64 - std::countr_zero(sets);
    frame_ = 0;
}

Relation& RelationCache::find(std::uint64_t key, bool& known) {
    Relation* set = entries_.data() + ((key * 0x9E3779B97F4A7C15u) >> shift_) * kWays;
    Relation* oldest = set;
    for (std::size_t way = 0; way < kWays; ++way) {
        if (set[way].key == key) {
            known = true;
            set[way].last_used = frame_;
            return set[way];
        }
        if (frame_ - set[way].last_used > frame_ - oldest->last_used)
            oldest = set + way;
    }
    known = false;
    oldest->key = key;
    oldest->last_used = frame_;
    return *oldest;
}

} // namespace antumbra
