#include "occluders/occluder_sets.hpp"

#include "base/random.hpp"
#include "occluders/choose.hpp"

#include <algorithm>
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

/// Scores of polygons in one cell, by direction.
class CellScorer {
  public:
    CellScorer(const OccluderSet& set, const ConvexGroups& singles, const OccluderTree& tree, const OccluderSetsOptions& options)
        : set_(set), singles_(singles), tree_(tree), options_(options), of_(set.polygons.size(), 0) {}

    void run(std::uint32_t leaf, const Box3d& box, std::vector<std::uint32_t>* sets) {
        entries_.clear();
        Random random(leaf, 0x6f736574);
        for (std::uint32_t v = 0; v < options_.viewpoints; ++v) {
            Vec3d eye = box.centre();
            for (int axis = 0; axis < 3 && v > 0; ++axis)
                eye[axis] = random.uniform(box.min[axis], box.max[axis]);
            look_from(leaf, eye);
        }
        std::vector<Scored> list;
        for (std::size_t d = 0; d < OccluderSets::kDirections; ++d) {
            list.clear();
            for (const Entry& entry : entries_)
                if (entry.score[d] > 0)
                    list.push_back({entry.score[d], entry.polygon});
            std::size_t keep = std::min<std::size_t>(options_.per_set, list.size());
            std::partial_sort(list.begin(), list.begin() + static_cast<std::ptrdiff_t>(keep), list.end());
            for (std::size_t n = 0; n < keep; ++n)
                sets[d].push_back(list[n].polygon);
        }
        for (const Entry& entry : entries_)
            of_[entry.polygon] = 0;
    }

  private:
    struct Entry {
        std::uint32_t polygon = 0;
        std::array<double, OccluderSets::kDirections> score{};
    };

    void look_from(std::uint32_t leaf, const Vec3d& eye) {
        search_.begin(tree_, eye, options_.candidates);
        Vec3f at{static_cast<float>(eye.x), static_cast<float>(eye.y), static_cast<float>(eye.z)};
        search_.advance(tree_, ~std::uint32_t(0), [&](std::uint32_t single) {
            const OccluderPolygon& polygon = set_.polygons[singles_.members[single]];
            double height = dot(polygon.normal, eye) + polygon.offset;
            bool shown = (height > 0) == (options_.shown == OccluderSetsOptions::Shown::fronts);
            if (!(shown || polygon.double_sided) || (polygon.synthetic && !set_.solids[polygon.solid].serves({eye, eye})) ||
                (options_.is_seen && !polygon.synthetic && !options_.is_seen(leaf, polygon.object)))
                return 0.0f;
            return area_angle_bound(static_cast<float>(polygon.area), singles_.groups[single].box, at);
        });
        for (std::uint32_t single : search_.found_so_far())
            add(singles_.members[single], eye);
    }

    void add(std::uint32_t index, const Vec3d& eye) {
        const OccluderPolygon& polygon = set_.polygons[index];
        if (of_[index] == 0) {
            entries_.push_back({index, {}});
            of_[index] = static_cast<std::uint32_t>(entries_.size());
        }
        Entry& entry = entries_[of_[index] - 1];
        Vec3d sight = polygon.centre - eye;
        double squared = dot(sight, sight) + 0.05 * polygon.area;
        for (std::size_t d = 0; d < OccluderSets::kDirections; ++d) {
            const Vec3d& way = OccluderSets::directions()[d];
            double facing = std::abs(dot(polygon.normal, way));
            // Behind the viewer nothing hides; large polygons may begin behind and reach ahead.
            if (facing > 0.05 && dot(sight, way) > -std::sqrt(polygon.area))
                entry.score[d] += polygon.area * facing / squared;
        }
    }

    const OccluderSet& set_;
    const ConvexGroups& singles_;
    const OccluderTree& tree_;
    const OccluderSetsOptions& options_;
    OccluderSearch search_;
    std::vector<Entry> entries_;
    std::vector<std::uint32_t> of_; ///< per polygon: its entry, counted from 1; 0: none
};

Status corrupt(const char* what) {
    return {ErrorCode::corrupt, std::string("chunk 'OSET': ") + what + "; the file is damaged, prepare it again"};
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

OccluderSets OccluderSets::build(const OccluderSet& set, const SpaceCells& cells, const OccluderSetsOptions& options) {
    if (cells.nodes.empty())
        return {};
    ConvexGroups singles = single_polygons(set, options);
    OccluderTree tree = build_occluder_tree(singles);
    std::vector<Box3d> boxes = cells.boxes();
    std::vector<std::vector<std::uint32_t>> members(boxes.size() * kDirections);
    CellScorer scorer(set, singles, tree, options);
    for (std::uint32_t leaf = 0; leaf < boxes.size(); ++leaf)
        scorer.run(leaf, boxes[leaf], members.data() + leaf * kDirections);
    return of_members(cells, members);
}

std::span<const std::uint32_t> OccluderSets::at(const Vec3d& place, const Vec3d& direction) const {
    if (first_.empty())
        return {};
    const std::array<Vec3d, kDirections>& ways = directions();
    std::size_t best = 0;
    for (std::size_t d = 1; d < kDirections; ++d)
        if (dot(ways[d], direction) > dot(ways[best], direction))
            best = d;
    std::size_t set = cells_.find(place) * kDirections + best;
    return {polygons_.data() + first_[set], first_[set + 1] - first_[set]};
}

// Members of one cell's sets are much the same in neighbouring directions: each cell lists them once, sorted, and its
// sets refer to that list, by bytes if it has no more than 256.
void OccluderSets::encode(ByteWriter& out) const {
    for (const Vec3d& corner : {cells_.bounds.min, cells_.bounds.max})
        for (int axis = 0; axis < 3; ++axis)
            out.f64(corner[axis]);
    ByteWriter coded;
    cells_.encode(coded);
    std::vector<std::uint32_t> list;
    for (std::size_t leaf = 0; leaf < cells_.leaves; ++leaf) {
        const std::uint32_t* ends = first_.data() + leaf * kDirections;
        list.assign(polygons_.begin() + ends[0], polygons_.begin() + ends[kDirections]);
        std::sort(list.begin(), list.end());
        list.erase(std::unique(list.begin(), list.end()), list.end());
        coded.varint(list.size());
        std::uint32_t next = 0;
        for (std::uint32_t member : list) {
            coded.varint(member - next);
            next = member + 1;
        }
        for (std::size_t d = 0; d < kDirections; ++d) {
            coded.varint(ends[d + 1] - ends[d]);
            for (std::uint32_t i = ends[d]; i < ends[d + 1]; ++i) {
                auto place = std::lower_bound(list.begin(), list.end(), polygons_[i]) - list.begin();
                if (list.size() <= 256)
                    coded.u8(static_cast<std::uint8_t>(place));
                else
                    coded.varint(static_cast<std::uint64_t>(place));
            }
        }
    }
    out.u32(static_cast<std::uint32_t>(coded.bytes.size()));
    out.raw(coded.bytes);
    out.align(4);
}

Result<OccluderSets> OccluderSets::decode(std::span<const std::byte> bytes, std::size_t& at, std::size_t items) {
    constexpr std::size_t kHeader = 6 * 8 + 4;
    if (bytes.size() - at < kHeader)
        return corrupt("it is too short");
    Box3d space;
    for (int axis = 0; axis < 3; ++axis) {
        space.min[axis] = load_f64(bytes, at + 8 * std::size_t(axis));
        space.max[axis] = load_f64(bytes, at + 24 + 8 * std::size_t(axis));
    }
    std::size_t size = load_u32(bytes, at + 48);
    at += kHeader;
    if (size > bytes.size() - at || (size + 3) / 4 * 4 > bytes.size() - at)
        return corrupt("a family ends too early");
    if (!is_finite(space.min) || !is_finite(space.max) || space.empty())
        return corrupt("its space is empty or not finite");
    std::span<const std::byte> coded = bytes.subspan(at, size);
    at += (size + 3) / 4 * 4;
    OccluderSets sets;
    std::size_t place = 0;
    sets.cells_ = SpaceCells::decode(coded, place, space);
    if (sets.cells_.nodes.empty())
        return corrupt("its cells are no tree");
    sets.first_.assign(1, 0);
    std::vector<std::uint32_t> list;
    std::uint64_t value = 0;
    for (std::uint32_t leaf = 0; leaf < sets.cells_.leaves; ++leaf) {
        list.clear();
        if (!read_varint(coded, place, value) || value > coded.size() - place)
            return corrupt("a cell's list ends too early");
        std::uint64_t next = 0;
        for (std::uint64_t left = value; left > 0; --left, ++next) {
            if (!read_varint(coded, place, value) || (next += value) >= items)
                return corrupt("a cell's list has a member that does not exist");
            list.push_back(static_cast<std::uint32_t>(next));
        }
        for (std::size_t d = 0; d < kDirections; ++d) {
            if (!read_varint(coded, place, value) || value > coded.size() - place)
                return corrupt("a set ends too early");
            for (std::uint64_t left = value; left > 0; --left) {
                if (list.size() <= 256) {
                    value = place < coded.size() ? std::to_integer<std::uint64_t>(coded[place++]) : items;
                } else if (!read_varint(coded, place, value)) {
                    value = items;
                }
                if (value >= list.size())
                    return corrupt("a set has a member that its cell does not list");
                sets.polygons_.push_back(list[std::size_t(value)]);
            }
            sets.first_.push_back(static_cast<std::uint32_t>(sets.polygons_.size()));
        }
    }
    if (place != coded.size())
        return corrupt("its size is wrong");
    return sets;
}

Result<OccluderSets> OccluderSets::decode_grid(std::span<const std::byte> bytes, std::size_t& at, std::size_t items) {
    constexpr std::size_t kHeader = 6 * 8 + 4 * 4;
    if (bytes.size() - at < kHeader)
        return corrupt("it is too short");
    OccluderSets sets;
    Box3d space;
    std::array<std::uint32_t, 3> count{};
    for (int axis = 0; axis < 3; ++axis) {
        space.min[axis] = load_f64(bytes, at + 8 * std::size_t(axis));
        space.max[axis] = load_f64(bytes, at + 24 + 8 * std::size_t(axis));
    }
    std::uint64_t leaves = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        count[axis] = load_u32(bytes, at + 48 + 4 * axis);
        if (count[axis] == 0 || count[axis] > bytes.size() || leaves > bytes.size())
            return corrupt("it has no leaves or too many");
        leaves *= count[axis];
    }
    std::uint64_t members = load_u32(bytes, at + 60), lists = leaves * kDirections;
    at += kHeader;
    if (leaves > bytes.size() || lists + members > (bytes.size() - at) / 4)
        return corrupt("it has no leaves or too many");
    if (!is_finite(space.min) || !is_finite(space.max) || space.empty())
        return corrupt("its space is empty or not finite");
    sets.cells_ = SpaceCells::of_grid(space, count);
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
