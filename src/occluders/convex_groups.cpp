#include "occluders/convex_groups.hpp"

#include "base/bytes.hpp"
#include "tree/bvh_overlaps.hpp"

#include <algorithm>
#include <numeric>
#include <string>

namespace antumbra {
namespace {

constexpr double kCoplanar = 1 - 1e-6; ///< cosine between normals
constexpr std::uint32_t kMostCorners = 8; ///< of a member: more planes cost more than they are worth

constexpr double kMostShell = 2; ///< volume of a solid's shell over its own: else many a viewer cannot use the solid

/// The inner solids that are boxes, found by what they hold.
class InnerSolids {
  public:
    explicit InnerSolids(const OccluderSet& set) {
        std::vector<Box3f> boxes(set.solids.size());
        std::vector<double> area(set.solids.size(), 0);
        for (const OccluderPolygon& polygon : set.polygons)
            if (polygon.synthetic) {
                area[polygon.solid] += polygon.area;
                for (std::uint32_t v : set.loop(polygon))
                    boxes[polygon.solid].extend(set.vertices[v]);
            }
        for (std::size_t s = 0; s < boxes.size(); ++s) {
            if (boxes[s].empty() || set.solids[s].shell.empty() || set.solids[s].is_restricted())
                continue;
            Vec3d size = to_double(boxes[s]).size(), shell = to_double(set.solids[s].shell).size();
            double surface = 2 * (size.x * size.y + size.y * size.z + size.z * size.x);
            // Only a box has the whole surface of its bounds.
            if (std::abs(area[s] - surface) <= 1e-9 * surface &&
                shell.x * shell.y * shell.z <= kMostShell * size.x * size.y * size.z)
                boxes_.push_back(boxes[s]);
        }
        tree_ = build_bvh(boxes_, {.leaf_size = 4});
    }

    bool holds(const Box3f& box) const {
        return find_in_bvh(tree_, [&](const Box3f& node) { return is_within(box, node); },
                           [&](std::uint32_t b) { return is_within(box, boxes_[b]); });
    }

  private:
    static bool is_within(const Box3f& inner, const Box3f& outer) {
        for (int axis = 0; axis < 3; ++axis)
            if (!(inner.min[axis] >= outer.min[axis] && inner.max[axis] <= outer.max[axis]))
                return false;
        return true;
    }

    std::vector<Box3f> boxes_;
    Bvh tree_;
};

class Grower {
  public:
    explicit Grower(const OccluderSet& set) : set_(set), solids_(set), taken_(set.polygons.size(), 0) {}

    ConvexGroups run(std::uint32_t most_groups) {
        std::vector<std::uint32_t> order(set_.polygons.size());
        std::iota(order.begin(), order.end(), 0u);
        std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
            double left = set_.polygons[a].area, right = set_.polygons[b].area;
            return left != right ? left > right : a < b;
        });
        ConvexGroups result;
        for (std::uint32_t seed : order) {
            if (!set_.polygons[seed].synthetic && solids_.holds(bounds_of(seed)))
                continue; // what it hides the solid hides; it may still join others
            if (taken_[seed] || set_.polygons[seed].count > 4 * kMostCorners)
                continue;
            if (result.groups.size() >= most_groups)
                break;
            grow(seed, result);
        }
        std::sort(result.groups.begin(), result.groups.end(), [](const auto& a, const auto& b) {
            return a.area != b.area ? a.area > b.area : a.first < b.first;
        });
        return result;
    }

  private:
    Box3f bounds_of(std::uint32_t polygon) const {
        Box3f box;
        for (std::uint32_t v : set_.loop(set_.polygons[polygon]))
            box.extend(set_.vertices[v]);
        return box;
    }

    void grow(std::uint32_t seed, ConvexGroups& result) {
        std::vector<std::uint32_t> members{seed};
        taken_[seed] = 1;
        for (std::size_t at = 0; at < members.size(); ++at) {
            const OccluderPolygon& polygon = set_.polygons[members[at]];
            for (std::uint32_t i = 0; i < polygon.count; ++i) {
                std::uint32_t neighbour = set_.neighbours[polygon.first + i];
                if (neighbour & kSameDirection || neighbour == kNoPolygon || taken_[neighbour])
                    continue;
                if (members.size() < ConvexGroups::kMostMembers && fits(members, neighbour)) {
                    taken_[neighbour] = 1;
                    members.push_back(neighbour);
                }
            }
        }
        ConvexGroups::Group group;
        group.first = static_cast<std::uint32_t>(result.members.size());
        group.count = static_cast<std::uint32_t>(members.size());
        measure_group(set_, members, group);
        result.members.insert(result.members.end(), members.begin(), members.end());
        result.groups.push_back(group);
    }

    bool is_behind(const OccluderPolygon& plane, const OccluderPolygon& polygon) const {
        double tolerance = 1e-5 * std::sqrt(plane.area + polygon.area);
        for (std::uint32_t v : set_.loop(polygon))
            if (dot(plane.normal, to_double(set_.vertices[v])) + plane.offset > tolerance)
                return false;
        return true;
    }

    /// All corners of `polygon` on the inner side of all edges of `other` that the two do not share.
    bool is_convex_with(const OccluderPolygon& other, std::uint32_t index, const OccluderPolygon& polygon) const {
        std::span<const std::uint32_t> loop = set_.loop(other);
        double tolerance = 1e-5 * (other.area + polygon.area);
        for (std::uint32_t i = 0; i < other.count; ++i) {
            if (set_.neighbours[other.first + i] == index)
                continue;
            Vec3d a = to_double(set_.vertices[loop[i]]), b = to_double(set_.vertices[loop[(i + 1) % other.count]]);
            Vec3d inward = cross(other.normal, b - a);
            for (std::uint32_t v : set_.loop(polygon))
                if (dot(inward, to_double(set_.vertices[v]) - a) < -tolerance)
                    return false;
        }
        return true;
    }

    bool fits(const std::vector<std::uint32_t>& members, std::uint32_t candidate) const {
        const OccluderPolygon& polygon = set_.polygons[candidate];
        if (polygon.count > kMostCorners)
            return false;
        for (std::uint32_t member : members) {
            const OccluderPolygon& other = set_.polygons[member];
            if (other.synthetic != polygon.synthetic || !is_behind(other, polygon) || !is_behind(polygon, other))
                return false;
            if (dot(other.normal, polygon.normal) > kCoplanar &&
                !(is_convex_with(other, candidate, polygon) && is_convex_with(polygon, member, other)))
                return false;
        }
        return true;
    }

    const OccluderSet& set_;
    InnerSolids solids_;
    std::vector<char> taken_;
};

} // namespace

void measure_group(const OccluderSet& set, std::span<const std::uint32_t> members, ConvexGroups::Group& group) {
    double weight = 0;
    group.centre = {};
    for (std::uint32_t member : members) {
        const OccluderPolygon& polygon = set.polygons[member];
        weight += polygon.area;
        group.centre += polygon.centre * polygon.area;
        for (std::uint32_t v : set.loop(polygon))
            group.box.extend(set.vertices[v]);
    }
    group.centre = weight > 0 ? group.centre / weight : set.polygons[members[0]].centre;
    Vec3d size = to_double(group.box.max) - to_double(group.box.min);
    double faces[3] = {size.x * size.y, size.y * size.z, size.z * size.x};
    // A viewer sees at most the two or three sides of the box, and no more than there is.
    group.area = std::min(weight, faces[0] + faces[1] + faces[2]);
}

ConvexGroups find_convex_groups(const OccluderSet& set, std::uint32_t most_groups) {
    return Grower(set).run(most_groups);
}

std::vector<std::byte> encode_groups(const ConvexGroups& groups) {
    ByteWriter out;
    out.u32(static_cast<std::uint32_t>(groups.groups.size()));
    for (const ConvexGroups::Group& group : groups.groups) {
        out.u32(group.count);
        for (std::uint32_t i = 0; i < group.count; ++i)
            out.u32(groups.members[group.first + i]);
    }
    return std::move(out.bytes);
}

Result<ConvexGroups> decode_groups(std::span<const std::byte> bytes, const OccluderSet& set) {
    auto corrupt = [](const char* what) {
        return Status(ErrorCode::corrupt, std::string("chunk 'OGRP': ") + what + "; the file is damaged, prepare it again");
    };
    ConvexGroups groups;
    // Every group takes eight bytes at least.
    if (bytes.size() < 4 || bytes.size() % 4 != 0 || load_u32(bytes, 0) > bytes.size() / 8)
        return corrupt("its size is wrong");
    std::size_t at = 4;
    groups.groups.resize(load_u32(bytes, 0));
    for (ConvexGroups::Group& group : groups.groups) {
        if (at == bytes.size())
            return corrupt("it ends too early");
        group.first = static_cast<std::uint32_t>(groups.members.size());
        group.count = load_u32(bytes, at);
        at += 4;
        if (group.count == 0 || group.count > ConvexGroups::kMostMembers || group.count > (bytes.size() - at) / 4)
            return corrupt("a group has no members or too many");
        for (std::uint32_t i = 0; i < group.count; ++i, at += 4) {
            groups.members.push_back(load_u32(bytes, at));
            if (groups.members.back() >= set.polygons.size())
                return corrupt("a group has a polygon that does not exist");
        }
        measure_group(set, {groups.members.data() + group.first, group.count}, group);
    }
    if (at != bytes.size())
        return corrupt("its size is wrong");
    return groups;
}

} // namespace antumbra
