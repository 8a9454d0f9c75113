#include "occluders/occluder_sets.hpp"

#include "base/random.hpp"
#include "occluders/choose.hpp"

#include <algorithm>

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

/// Every polygon that may be a member as a group of its own, for best-first search.
ConvexGroups single_polygons(const OccluderSet& set, const OccluderSetsOptions& options) {
    ConvexGroups groups;
    for (std::uint32_t p = 0; p < set.polygons.size(); ++p) {
        if (set.polygons[p].count > options.most_corners)
            continue;
        ConvexGroups::Group group;
        group.first = static_cast<std::uint32_t>(groups.members.size());
        group.count = 1;
        measure_group(set, {&p, 1}, group);
        group.area = set.polygons[p].area;
        groups.members.push_back(p);
        groups.groups.push_back(group);
    }
    return groups;
}

} // namespace

const std::array<Vec3d, OccluderSets::kDirections>& OccluderSets::directions() {
    static const std::array<Vec3d, kDirections> ways = make_directions();
    return ways;
}

OccluderSets OccluderSets::of_members(const SpaceCells& cells, const std::vector<std::vector<std::uint32_t>>& members) {
    OccluderSets sets;
    sets.cells_ = cells;
    for (const std::vector<std::uint32_t>& list : members) {
        sets.first_.push_back(static_cast<std::uint32_t>(sets.polygons_.size()));
        sets.polygons_.insert(sets.polygons_.end(), list.begin(), list.end());
    }
    sets.first_.push_back(static_cast<std::uint32_t>(sets.polygons_.size()));
    return sets;
}

OccluderSetMaker::OccluderSetMaker(const OccluderSet& set, const SpaceCells& cells, const OccluderSetsOptions& options)
    : set_(set), options_(options), boxes_(cells.boxes()), singles_(single_polygons(set, options)),
      tree_(build_occluder_tree(singles_)) {}

OccluderSetMaker::Memory::Memory(const OccluderSetMaker& owner) : entry_of_(owner.set_.polygons.size(), 0) {}

void OccluderSetMaker::make(std::uint32_t leaf, Memory& memory, std::span<std::vector<std::uint32_t>> sets) const {
    memory.entries_.clear();
    Random random(leaf, 0x6f736574);
    for (std::uint32_t v = 0; v < options_.viewpoints; ++v) {
        Vec3d eye = boxes_[leaf].centre();
        for (int axis = 0; axis < 3 && v > 0; ++axis)
            eye[axis] = random.uniform(boxes_[leaf].min[axis], boxes_[leaf].max[axis]);
        look_from(leaf, eye, memory);
    }
    std::vector<Scored> list;
    for (std::size_t d = 0; d < OccluderSets::kDirections; ++d) {
        list.clear();
        sets[d].clear();
        for (const Memory::Entry& entry : memory.entries_)
            if (entry.score[d] > 0)
                list.push_back({entry.score[d], entry.polygon});
        std::size_t keep = std::min<std::size_t>(options_.per_set, list.size());
        std::partial_sort(list.begin(), list.begin() + static_cast<std::ptrdiff_t>(keep), list.end());
        for (std::size_t n = 0; n < keep; ++n)
            sets[d].push_back(list[n].polygon);
        if (options_.order == OccluderSetsOptions::Order::by_number)
            std::sort(sets[d].begin(), sets[d].end());
    }
    for (const Memory::Entry& entry : memory.entries_)
        memory.entry_of_[entry.polygon] = 0;
}

void OccluderSetMaker::look_from(std::uint32_t leaf, const Vec3d& eye, Memory& memory) const {
    memory.search_.begin(tree_, eye, options_.candidates);
    Vec3f at{static_cast<float>(eye.x), static_cast<float>(eye.y), static_cast<float>(eye.z)};
    memory.search_.advance(tree_, ~std::uint32_t(0), [&](std::uint32_t single) {
        const OccluderPolygon& polygon = set_.polygons[singles_.members[single]];
        double height = dot(polygon.normal, eye) + polygon.offset;
        bool shown = (height > 0) == (options_.shown == OccluderSetsOptions::Shown::fronts);
        if (!(shown || polygon.double_sided) || (polygon.synthetic && !set_.solids[polygon.solid].serves({eye, eye})) ||
            (options_.is_seen && !polygon.synthetic && !options_.is_seen(leaf, polygon.object)))
            return 0.0f;
        return area_angle_bound(static_cast<float>(polygon.area), singles_.groups[single].box, at);
    });
    for (std::uint32_t single : memory.search_.found_so_far())
        add(singles_.members[single], eye, memory);
}

void OccluderSetMaker::add(std::uint32_t index, const Vec3d& eye, Memory& memory) const {
    const OccluderPolygon& polygon = set_.polygons[index];
    std::uint32_t& number = memory.entry_of_[index];
    if (number == 0) {
        memory.entries_.push_back({index, {}});
        number = static_cast<std::uint32_t>(memory.entries_.size());
    }
    Memory::Entry& entry = memory.entries_[number - 1];
    Vec3d sight = polygon.centre - eye;
    double squared = dot(sight, sight) + 0.05 * polygon.area;
    for (std::size_t d = 0; d < OccluderSets::kDirections; ++d) {
        const Vec3d& way = OccluderSets::directions()[d];
        double facing = std::abs(dot(polygon.normal, way));
        // Behind the viewer nothing hides; large polygons may begin behind and reach ahead.
        if (facing > 0.05 && dot(sight, way) > -std::sqrt(polygon.area))
            entry.score[d] += polygon.area * (options_.measure == OccluderSetsOptions::Measure::area_angle ? facing : 1) / squared;
    }
}

OccluderSets OccluderSets::build(const OccluderSet& set, const SpaceCells& cells, const OccluderSetsOptions& options) {
    if (cells.nodes.empty())
        return {};
    std::vector<std::vector<std::uint32_t>> members(std::size_t(cells.leaves) * kDirections);
    OccluderSetMaker maker(set, cells, options);
    OccluderSetMaker::Memory memory(maker);
    for (std::uint32_t leaf = 0; leaf < cells.leaves; ++leaf)
        maker.make(leaf, memory, std::span(members).subspan(leaf * kDirections, kDirections));
    return of_members(cells, members);
}

std::size_t OccluderSets::direction_of(const Vec3d& direction) {
    const std::array<Vec3d, kDirections>& ways = directions();
    std::size_t best = 0;
    for (std::size_t d = 1; d < kDirections; ++d)
        if (dot(ways[d], direction) > dot(ways[best], direction))
            best = d;
    return best;
}

std::span<const std::uint32_t> OccluderSets::at(const Vec3d& place, const Vec3d& direction) const {
    if (first_.empty())
        return {};
    return of_leaf(cells_.find(place), direction_of(direction));
}

} // namespace antumbra
