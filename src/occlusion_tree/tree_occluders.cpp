#include "occlusion_tree/tree_occluders.hpp"

#include "geometry/predicates.hpp"

#include <algorithm>
#include <numeric>

namespace antumbra {
namespace {

constexpr int kCandidates = 4; ///< splitting planes that are compared

int dominant_axis(const Vec3d& n) {
    Vec3d a{std::abs(n.x), std::abs(n.y), std::abs(n.z)};
    return a.x >= a.y && a.x >= a.z ? 0 : a.y >= a.z ? 1 : 2;
}

class Preparation {
  public:
    Preparation(const OccluderSet& set, TreeOccluders& result) : set_(set), result_(result) {}

    void run() {
        for (const Vec3f& v : set_.vertices)
            result_.vertices.push_back(to_double(v));
        result_.polygons.resize(set_.polygons.size());
        own_plane_.resize(set_.polygons.size());
        for (std::uint32_t p = 0; p < set_.polygons.size(); ++p)
            result_.polygons[p].usable = prepare(p);
        share_planes();
    }

  private:
    const Vec3d& at(std::uint32_t vertex) const { return result_.vertices[vertex]; }

    /// Exactly flat, with left turns only, straight corners left out.
    bool prepare(std::uint32_t index) {
        const OccluderPolygon& source = set_.polygons[index];
        TreeOccluders::Polygon& polygon = result_.polygons[index];
        polygon.double_sided = source.double_sided;
        polygon.first = static_cast<std::uint32_t>(result_.corners.size());
        int axis = dominant_axis(source.normal);
        int turn = source.normal[axis] > 0 ? 1 : -1;
        std::span<const std::uint32_t> loop = set_.loop(source);
        for (std::size_t i = 0; i < loop.size(); ++i) {
            std::uint32_t before = loop[i == 0 ? loop.size() - 1 : i - 1], after = loop[i + 1 == loop.size() ? 0 : i + 1];
            if (!in_exact_range(at(loop[i])))
                return false;
            int turns = orient2d(at(before), at(loop[i]), at(after), axis);
            if (turns == -turn)
                return false;
            if (turns != 0)
                result_.corners.push_back(loop[i]);
        }
        polygon.count = static_cast<std::uint32_t>(result_.corners.size()) - polygon.first;
        if (polygon.count < 3 || polygon.count + 8 > std::uint32_t(PicturePolygon::kMost))
            return false;
        const std::uint32_t* corner = result_.corners.data() + polygon.first;
        std::array<std::uint32_t, 3> plane{};
        double largest = -1;
        for (std::uint32_t i = 1; i + 1 < polygon.count; ++i) {
            double area = length(cross(at(corner[i]) - at(corner[0]), at(corner[i + 1]) - at(corner[0])));
            if (area > largest) {
                largest = area;
                plane = {corner[0], corner[i], corner[i + 1]};
            }
        }
        for (std::uint32_t i = 0; i < polygon.count; ++i)
            if (orient3d(at(plane[0]), at(plane[1]), at(plane[2]), at(corner[i])) != 0)
                return false;
        own_plane_[index] = plane;
        return true;
    }

    /// Polygons in the same plane, whichever way they face, get one number.
    void share_planes() {
        struct Key {
            std::array<std::int64_t, 4> rounded;
            std::uint32_t polygon;
        };
        double size = 1e-300;
        for (const Vec3d& v : result_.vertices)
            size = std::max({size, std::abs(v.x), std::abs(v.y), std::abs(v.z)});
        std::vector<Key> keys;
        for (std::uint32_t p = 0; p < set_.polygons.size(); ++p) {
            if (!result_.polygons[p].usable)
                continue;
            const OccluderPolygon& source = set_.polygons[p];
            double turn = source.normal[dominant_axis(source.normal)] > 0 ? 0x1p16 : -0x1p16;
            auto rounded = [](double value) { return static_cast<std::int64_t>(std::floor(value + 0.5)); };
            keys.push_back({{rounded(source.normal.x * turn), rounded(source.normal.y * turn),
                             rounded(source.normal.z * turn), rounded(source.offset / size * turn)},
                            p});
        }
        std::sort(keys.begin(), keys.end(), [](const Key& a, const Key& b) {
            return a.rounded != b.rounded ? a.rounded < b.rounded : a.polygon < b.polygon;
        });
        for (std::size_t i = 0; i < keys.size(); ++i) {
            TreeOccluders::Polygon& polygon = result_.polygons[keys[i].polygon];
            const std::array<std::uint32_t, 3>& own = own_plane_[keys[i].polygon];
            bool shared = i > 0 && keys[i].rounded == keys[i - 1].rounded;
            for (std::uint32_t v : own)
                shared = shared && orient3d(at(result_.planes.back()[0]), at(result_.planes.back()[1]),
                                            at(result_.planes.back()[2]), at(v)) == 0;
            if (!shared)
                result_.planes.push_back(own);
            polygon.plane = static_cast<std::uint32_t>(result_.planes.size() - 1);
            const std::array<std::uint32_t, 3>& first = result_.planes.back();
            polygon.along_plane = dot(cross(at(first[1]) - at(first[0]), at(first[2]) - at(first[0])),
                                      set_.polygons[keys[i].polygon].normal) > 0;
        }
    }

    const OccluderSet& set_;
    TreeOccluders& result_;
    std::vector<std::array<std::uint32_t, 3>> own_plane_;
};

} // namespace

TreeOccluders TreeOccluders::build(const OccluderSet& set) {
    TreeOccluders result;
    Preparation(set, result).run();
    return result;
}

TreeBuilder::TreeBuilder(const TreeOccluders& occluders, std::uint32_t most)
    : occluders_(occluders), vertex_stamp_(occluders.vertices.size()), vertex_point_(occluders.vertices.size()),
      plane_stamp_(occluders.planes.size()), plane_index_(occluders.planes.size()), items_(2 * std::size_t(most) + 64),
      in_front_(items_.size()) {
    // A chain of partitions, each one item shorter than the one before, is the worst that can be.
    segments_.reserve(items_.size() * (items_.size() + 1) / 2 + 1);
    loop_.reserve(PicturePolygon::kMost);
}

/// A picture of the polygon as the eye sees it, if it shows a side that blocks.
bool TreeBuilder::add_item(OcclusionTree& tree, std::uint32_t occluder) {
    const TreeOccluders::Polygon& polygon = occluders_.polygons[occluder];
    if (!polygon.usable || item_count_ == items_.size())
        return false;
    Sight& sight = tree.sight();
    const std::array<std::uint32_t, 3>& corners = occluders_.planes[polygon.plane];
    const Vec3d &a = occluders_.vertices[corners[0]], &b = occluders_.vertices[corners[1]], &c = occluders_.vertices[corners[2]];
    bool before = sight.is_in_front(a, b, c);
    if (!before && !sight.is_in_front(a, c, b))
        return false;
    bool shows_front = before == polygon.along_plane;
    if (!shows_front && !polygon.double_sided)
        return false;
    auto point = [&](std::uint32_t vertex) {
        if (vertex_stamp_[vertex] != stamp_) {
            vertex_stamp_[vertex] = stamp_;
            vertex_point_[vertex] = sight.add_point(occluders_.vertices[vertex]);
        }
        return vertex_point_[vertex];
    };
    if (plane_stamp_[polygon.plane] != stamp_) {
        plane_stamp_[polygon.plane] = stamp_;
        plane_index_[polygon.plane] = before ? sight.add_plane(point(corners[0]), point(corners[1]), point(corners[2]))
                                             : sight.add_plane(point(corners[0]), point(corners[2]), point(corners[1]));
    }
    loop_.clear();
    for (std::uint32_t i = 0; i < polygon.count; ++i)
        loop_.push_back(point(occluders_.corners[polygon.first + (shows_front ? i : polygon.count - 1 - i)]));
    Item& item = items_[item_count_];
    item.plane = plane_index_[polygon.plane];
    item.occluder = occluder;
    item.whole = true;
    if (!tree.picture_of(loop_, item.picture))
        return false;
    ++item_count_;
    return true;
}

std::uint32_t TreeBuilder::insert(OcclusionTree& tree, std::span<const std::uint32_t> chosen, Order order) {
    ++stamp_;
    item_count_ = 0;
    segments_.clear();
    for (std::uint32_t occluder : chosen)
        if (add_item(tree, occluder))
            segments_.push_back(static_cast<std::uint32_t>(item_count_ - 1));
    auto count = static_cast<std::uint32_t>(item_count_);
    if (order == Order::binary_space_partition)
        insert_front_to_back(tree, 0);
    else
        for (std::uint32_t i = 0; i < count; ++i)
            tree.insert(items_[i].picture, items_[i].plane, items_[i].occluder);
    return count;
}

/// Of an item to the plane of a splitter: bit 0: some of it in front, bit 1: some behind; 0: in the plane. `sides`: 1
/// for corners behind.
int TreeBuilder::place(OcclusionTree& tree, const Item& item, std::uint32_t splitter, signed char* sides) const {
    if (item.plane == splitter)
        return 0;
    Sight& sight = tree.sight();
    Sight::Mark mark = sight.mark();
    LineRef farther{};
    bool has_line = false;
    int place = 0;
    for (int i = 0; i < item.picture.count; ++i) {
        const Direction at = item.picture.at(i);
        int side = 0;
        if (item.whole) {
            side = sight.behind(splitter, at.point);
        } else {
            if (!has_line)
                farther = sight.add_meeting(item.plane, splitter);
            has_line = true;
            side = sight.side(farther, at);
            if (side == kUndecided) // only an order: any will do
                side = 0;
        }
        sides[i] = static_cast<signed char>(side);
        place |= side < 0 ? 1 : side > 0 ? 2 : 0;
    }
    sight.forget(mark);
    return place;
}

/// As place(), where doubles decide; corners that they leave open do not count.
int TreeBuilder::rough_place(OcclusionTree& tree, const Item& item, std::uint32_t splitter) const {
    if (item.plane == splitter)
        return 0;
    Sight& sight = tree.sight();
    Sight::Mark mark = sight.mark();
    SideMasks farther = sight.certain_sides(sight.add_meeting(item.plane, splitter), item.picture);
    sight.forget(mark);
    return (farther.negative ? 1 : 0) | (farther.positive ? 2 : 0);
}

/// The candidate among the items segments_[first ..] that splits the fewest others.
std::uint32_t TreeBuilder::best_splitter(OcclusionTree& tree, std::uint32_t first) {
    auto count = static_cast<std::uint32_t>(segments_.size()) - first;
    std::uint32_t best = first, fewest = 0xFFFFFFFFu;
    for (int c = 0; c < kCandidates && fewest > 0; ++c) {
        std::uint32_t candidate = first + count * static_cast<std::uint32_t>(c) / kCandidates;
        std::uint32_t splits = 0;
        for (std::uint32_t i = first; i < first + count && splits < fewest; ++i)
            splits += rough_place(tree, items_[segments_[i]], items_[segments_[candidate]].plane) == 3;
        if (splits < fewest) {
            fewest = splits;
            best = candidate;
        }
    }
    return best;
}

/// Cuts an item by the plane of a splitter: the part in front becomes a new item. False if there is no room.
bool TreeBuilder::split(OcclusionTree& tree, std::uint32_t item, std::uint32_t splitter, const signed char* sides) {
    if (item_count_ == items_.size())
        return false;
    Item& front = items_[item_count_];
    LineRef farther = tree.sight().add_meeting(items_[item].plane, splitter);
    if (!cut(tree.sight(), farther, items_[item].picture, sides, &part_, &front.picture))
        return false;
    for (PicturePolygon* piece : {&part_, &front.picture}) // no plane of the tree holds the new edges
        for (int c = 0; c < piece->count; ++c)
            piece->facts[c].flagged = false;
    front.plane = items_[item].plane;
    front.occluder = items_[item].occluder;
    items_[item].picture = part_;
    items_[item].whole = front.whole = false;
    ++item_count_;
    return true;
}

/// Takes the items segments_[first ..] off the stack: those in front of a splitter, the splitter, those behind it. An
/// item that cannot be split stays whole: the tree is right in any order.
void TreeBuilder::insert_front_to_back(OcclusionTree& tree, std::uint32_t first) {
    auto end = static_cast<std::uint32_t>(segments_.size());
    if (end == first)
        return;
    std::uint32_t splitter = segments_[end - first == 1 ? first : best_splitter(tree, first)];
    std::uint32_t plane = items_[splitter].plane;
    signed char sides[PicturePolygon::kMost];
    auto new_items = static_cast<std::uint32_t>(item_count_);
    for (std::uint32_t i = first; i < end; ++i) {
        std::uint32_t item = segments_[i];
        if (item == splitter)
            continue;
        int where = place(tree, items_[item], plane, sides);
        if (where == 3)
            split(tree, item, plane, sides);
        in_front_[item] = where == 1;
    }
    auto new_end = static_cast<std::uint32_t>(item_count_);
    for (std::uint32_t i = first; i < end; ++i)
        if (std::uint32_t item = segments_[i]; item != splitter && !in_front_[item])
            segments_.push_back(item);
    auto behind_end = static_cast<std::uint32_t>(segments_.size());
    for (std::uint32_t i = first; i < end; ++i)
        if (std::uint32_t item = segments_[i]; item != splitter && in_front_[item])
            segments_.push_back(item);
    for (std::uint32_t item = new_items; item < new_end; ++item)
        segments_.push_back(item);
    insert_front_to_back(tree, behind_end);
    tree.insert(items_[splitter].picture, plane, items_[splitter].occluder);
    insert_front_to_back(tree, end);
    segments_.resize(first);
}

} // namespace antumbra
