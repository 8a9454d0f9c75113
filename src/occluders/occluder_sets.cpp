#include "occluders/occluder_sets.hpp"

#include <algorithm>
#include <numeric>
#include <string>

namespace antumbra {
namespace {

struct Scored {
    double score;
    std::uint32_t polygon;
    bool operator<(const Scored& other) const { return score != other.score ? score > other.score : polygon < other.polygon; }
};

std::array<Vec3d, OccluderSets::kDirections> make_directions() {
    std::array<Vec3d, OccluderSets::kDirections> list;
    for (int axis = 0; axis < 3; ++axis)
        for (int side = 0; side < 2; ++side)
            list[static_cast<std::size_t>(2 * axis + side)][axis] = side ? 1 : -1;
    double s = std::sqrt(1.0 / 3);
    for (std::size_t corner = 0; corner < 8; ++corner)
        list[6 + corner] = {corner & 1 ? s : -s, corner & 2 ? s : -s, corner & 4 ? s : -s};
    return list;
}

std::vector<std::uint32_t> largest(const OccluderSet& set, const OccluderSetsOptions& options) {
    std::vector<std::uint32_t> polygons;
    for (std::uint32_t p = 0; p < set.polygons.size(); ++p)
        if (set.polygons[p].count <= options.most_corners && !set.polygons[p].synthetic)
            polygons.push_back(p);
    std::stable_sort(polygons.begin(), polygons.end(), [&](std::uint32_t a, std::uint32_t b) {
        return set.polygons[a].area > set.polygons[b].area;
    });
    polygons.resize(std::min<std::size_t>(polygons.size(), options.most_polygons));
    return polygons;
}

} // namespace

const std::array<Vec3d, OccluderSets::kDirections>& OccluderSets::directions() {
    static const std::array<Vec3d, kDirections> ways = make_directions();
    return ways;
}

std::array<std::uint32_t, 3> OccluderSets::cut(const Box3f& space, std::uint32_t leaves) {
    // Halving the longest side again and again is a balanced kd-tree over empty space, that is, a grid.
    std::array<std::uint32_t, 3> count{1, 1, 1};
    Vec3d cell = to_double(space).size();
    for (std::uint32_t have = 1; have < leaves; have *= 2) {
        int axis = cell.x >= cell.y && cell.x >= cell.z ? 0 : cell.y >= cell.z ? 1 : 2;
        count[static_cast<std::size_t>(axis)] *= 2;
        cell[axis] /= 2;
    }
    return count;
}

OccluderSets OccluderSets::of_members(const Box3f& space, const std::array<std::uint32_t, 3>& count,
                                      const std::vector<std::vector<std::uint32_t>>& members) {
    OccluderSets sets;
    sets.space_ = to_double(space);
    sets.count_ = count;
    for (const std::vector<std::uint32_t>& list : members) {
        sets.first_.push_back(static_cast<std::uint32_t>(sets.polygons_.size()));
        sets.polygons_.insert(sets.polygons_.end(), list.begin(), list.end());
    }
    sets.first_.push_back(static_cast<std::uint32_t>(sets.polygons_.size()));
    return sets;
}

OccluderSets OccluderSets::build(const OccluderSet& set, const Box3f& space, const OccluderSetsOptions& options) {
    OccluderSets sets;
    if (space.empty())
        return sets;
    sets.space_ = to_double(space);
    sets.count_ = cut(space, options.leaves);
    Vec3d cell = sets.space_.size();
    for (int axis = 0; axis < 3; ++axis)
        cell[axis] /= sets.count_[static_cast<std::size_t>(axis)];
    std::vector<std::uint32_t> polygons = largest(set, options);
    const std::array<Vec3d, kDirections>& ways = directions();
    std::vector<Scored> scored[kDirections];
    for (std::uint32_t k = 0; k < sets.count_[2]; ++k)
        for (std::uint32_t j = 0; j < sets.count_[1]; ++j)
            for (std::uint32_t i = 0; i < sets.count_[0]; ++i) {
                Vec3d middle = sets.space_.min + Vec3d{cell.x * (i + 0.5), cell.y * (j + 0.5), cell.z * (k + 0.5)};
                for (std::uint32_t p : polygons) {
                    const OccluderPolygon& polygon = set.polygons[p];
                    Vec3d sight = polygon.centre - middle;
                    double squared = dot(sight, sight) + 0.05 * polygon.area;
                    for (std::size_t d = 0; d < kDirections; ++d) {
                        double facing = -dot(polygon.normal, ways[d]);
                        if (options.shown == OccluderSetsOptions::Shown::backs)
                            facing = -facing;
                        if (polygon.double_sided)
                            facing = std::abs(facing);
                        // Behind the viewer nothing hides; large polygons may begin behind and reach ahead.
                        if (facing > 0.05 && dot(sight, ways[d]) > -std::sqrt(polygon.area))
                            scored[d].push_back({polygon.area * facing / squared, p});
                    }
                }
                for (std::vector<Scored>& list : scored) {
                    sets.first_.push_back(static_cast<std::uint32_t>(sets.polygons_.size()));
                    std::size_t keep = std::min<std::size_t>(options.per_set, list.size());
                    std::partial_sort(list.begin(), list.begin() + static_cast<std::ptrdiff_t>(keep), list.end());
                    for (std::size_t n = 0; n < keep; ++n)
                        sets.polygons_.push_back(list[n].polygon);
                    list.clear();
                }
            }
    sets.first_.push_back(static_cast<std::uint32_t>(sets.polygons_.size()));
    return sets;
}

std::span<const std::uint32_t> OccluderSets::at(const Vec3d& place, const Vec3d& direction) const {
    if (first_.empty())
        return {};
    std::size_t index = 0;
    for (int axis = 2; axis >= 0; --axis) {
        auto count = count_[static_cast<std::size_t>(axis)];
        double share = (place[axis] - space_.min[axis]) / (space_.max[axis] - space_.min[axis]);
        double cell = std::clamp(share * count, 0.0, count - 1.0); // NaN becomes 0
        index = index * count + static_cast<std::size_t>(cell > 0 ? cell : 0);
    }
    const std::array<Vec3d, kDirections>& ways = directions();
    std::size_t best = 0;
    for (std::size_t d = 1; d < kDirections; ++d)
        if (dot(ways[d], direction) > dot(ways[best], direction))
            best = d;
    std::size_t set = index * kDirections + best;
    return {polygons_.data() + first_[set], first_[set + 1] - first_[set]};
}

void OccluderSets::encode(ByteWriter& out) const {
    for (const Vec3d& corner : {space_.min, space_.max})
        for (int axis = 0; axis < 3; ++axis)
            out.f64(corner[axis]);
    for (std::uint32_t count : count_)
        out.u32(count);
    out.u32(static_cast<std::uint32_t>(polygons_.size()));
    for (std::size_t set = 0; set + 1 < first_.size(); ++set)
        out.u32(first_[set + 1]);
    for (std::uint32_t polygon : polygons_)
        out.u32(polygon);
}

Result<OccluderSets> OccluderSets::decode(std::span<const std::byte> bytes, std::size_t& at, std::size_t items) {
    auto corrupt = [](const char* what) {
        return Status(ErrorCode::corrupt, std::string("chunk 'OSET': ") + what + "; the file is damaged, prepare it again");
    };
    constexpr std::size_t kHeader = 6 * 8 + 4 * 4;
    if (bytes.size() - at < kHeader)
        return corrupt("it is too short");
    OccluderSets sets;
    for (int axis = 0; axis < 3; ++axis) {
        sets.space_.min[axis] = load_f64(bytes, at + 8 * std::size_t(axis));
        sets.space_.max[axis] = load_f64(bytes, at + 24 + 8 * std::size_t(axis));
    }
    std::uint64_t leaves = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        sets.count_[axis] = load_u32(bytes, at + 48 + 4 * axis);
        if (sets.count_[axis] == 0 || sets.count_[axis] > bytes.size() || leaves > bytes.size())
            return corrupt("it has no leaves or too many");
        leaves *= sets.count_[axis];
    }
    std::uint64_t members = load_u32(bytes, at + 60), lists = leaves * kDirections;
    at += kHeader;
    if (leaves > bytes.size() || lists + members > (bytes.size() - at) / 4)
        return corrupt("it has no leaves or too many");
    if (!is_finite(sets.space_.min) || !is_finite(sets.space_.max) || sets.space_.empty())
        return corrupt("its space is empty or not finite");
    sets.first_.assign(1, 0);
    for (std::uint64_t list = 0; list < lists; ++list, at += 4) {
        std::uint32_t end = load_u32(bytes, at);
        if (end < sets.first_.back() || end > members)
            return corrupt("the ends of its sets are out of order");
        sets.first_.push_back(end);
    }
    if (sets.first_.back() != members)
        return corrupt("the ends of its sets are out of order");
    for (std::uint64_t i = 0; i < members; ++i, at += 4) {
        sets.polygons_.push_back(load_u32(bytes, at));
        if (sets.polygons_.back() >= items)
            return corrupt("a set has a member that does not exist");
    }
    return sets;
}

} // namespace antumbra
