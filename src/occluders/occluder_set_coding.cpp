// Chunk OSET: families of occluder sets as bytes and back. Byte layout: docs/format.md, section 6.
#include "occluders/occluder_sets.hpp"

#include <algorithm>
#include <string>

namespace antumbra {
namespace {

constexpr std::size_t kHeaderBytes = 6 * 8 + 4;
constexpr std::size_t kMostMembers = std::size_t(1) << 26; ///< of all sets together: few bytes can name many

Status corrupt(const char* what) {
    return {ErrorCode::corrupt, std::string("chunk 'OSET': ") + what + "; the file is damaged, prepare it again"};
}


/// A polygon that is in some sets of a cell: in those of which directions.
struct Member {
    std::uint32_t item = 0;
    std::uint32_t directions = 0; ///< a bit each
};

/// How a member of the cell before stands in a cell: two bits each.
enum Change : unsigned { kGone = 0, kSame = 1, kOtherDirections = 2 };

void put_space(ByteWriter& out, const Box3d& space, const ByteWriter& coded) {
    for (const Vec3d& corner : {space.min, space.max})
        for (int axis = 0; axis < 3; ++axis)
            out.f64(corner[axis]);
    out.u32(static_cast<std::uint32_t>(coded.bytes.size()));
    out.raw(coded.bytes);
    out.align(4);
}

/// The coded bytes of a family at `at`, which moves behind it.
Result<std::span<const std::byte>> take_space(std::span<const std::byte> bytes, std::size_t& at, Box3d& space) {
    if (bytes.size() - at < kHeaderBytes)
        return corrupt("it is too short");
    for (int axis = 0; axis < 3; ++axis) {
        space.min[axis] = load_f64(bytes, at + 8 * std::size_t(axis));
        space.max[axis] = load_f64(bytes, at + 24 + 8 * std::size_t(axis));
    }
    std::size_t size = load_u32(bytes, at + 48);
    at += kHeaderBytes;
    if (size > bytes.size() - at || (size + 3) / 4 * 4 > bytes.size() - at)
        return corrupt("a family ends too early");
    if (!is_finite(space.min) || !is_finite(space.max) || space.empty())
        return corrupt("its space is empty or not finite");
    std::span<const std::byte> coded = bytes.subspan(at, size);
    at += (size + 3) / 4 * 4;
    return coded;
}

/// Reads cells one after the other, each as what has changed since the one before.
class ChangesReader {
  public:
    ChangesReader(std::span<const std::byte> bytes, std::size_t& at, std::size_t items) : bytes_(bytes), at_(at), items_(items) {}

    /// False for bytes that encode_changes() cannot have written.
    bool next() {
        before_.swap(members_);
        members_.clear();
        std::size_t flags = at_;
        if ((before_.size() + 3) / 4 > bytes_.size() - at_)
            return false;
        at_ += (before_.size() + 3) / 4;
        for (std::size_t i = 0; i < before_.size(); ++i) {
            unsigned change = std::to_integer<unsigned>(bytes_[flags + i / 4]) >> (2 * (i % 4)) & 3;
            if (change > kOtherDirections)
                return false;
            if (change == kOtherDirections && !directions(before_[i].directions))
                return false;
            if (change != kGone)
                members_.push_back(before_[i]);
        }
        std::uint64_t count = 0, distance = 0, item = 0;
        if (!read_varint(bytes_, at_, count) || count > bytes_.size() - at_)
            return false;
        auto old = static_cast<std::ptrdiff_t>(members_.size());
        for (; count > 0; --count, ++item) {
            Member member;
            if (!read_varint(bytes_, at_, distance) || (item += distance) >= items_ || !directions(member.directions))
                return false;
            member.item = static_cast<std::uint32_t>(item);
            members_.push_back(member);
        }
        auto less = [](const Member& a, const Member& b) { return a.item < b.item; };
        std::inplace_merge(members_.begin(), members_.begin() + old, members_.end(), less);
        return std::adjacent_find(members_.begin(), members_.end(),
                                  [](const Member& a, const Member& b) { return a.item == b.item; }) == members_.end();
    }
    const std::vector<Member>& members() const { return members_; }

  private:
    bool directions(std::uint32_t& bits) {
        if (bytes_.size() - at_ < 2)
            return false;
        bits = load_u16(bytes_, at_);
        at_ += 2;
        return bits != 0 && bits < 1u << OccluderSets::kDirections;
    }

    std::span<const std::byte> bytes_;
    std::size_t& at_;
    std::size_t items_;
    std::vector<Member> members_, before_;
};

void put_changes(ByteWriter& out, const std::vector<Member>& before, const std::vector<Member>& now) {
    std::vector<std::uint8_t> changes((before.size() + 3) / 4, 0);
    ByteWriter directions, added;
    std::uint32_t added_count = 0, next = 0;
    std::size_t i = 0;
    for (const Member& member : now) {
        while (i < before.size() && before[i].item < member.item)
            ++i;
        if (i < before.size() && before[i].item == member.item) {
            bool same = before[i].directions == member.directions;
            changes[i / 4] = static_cast<std::uint8_t>(changes[i / 4] | (same ? kSame : kOtherDirections) << (2 * (i % 4)));
            if (!same)
                directions.u16(static_cast<std::uint16_t>(member.directions));
            continue;
        }
        added.varint(member.item - next);
        added.u16(static_cast<std::uint16_t>(member.directions));
        next = member.item + 1;
        ++added_count;
    }
    for (std::uint8_t four : changes)
        out.u8(four);
    out.raw(directions.bytes);
    out.varint(added_count);
    out.raw(added.bytes);
}

} // namespace

// Sets of neighbouring cells are much the same, and so are those of neighbouring directions: a cell names what is new, with
// its directions, and what of the cell before is gone.
void OccluderSets::encode_changes(ByteWriter& out) const {
    ByteWriter coded;
    cells_.encode(coded);
    std::vector<Member> before, now;
    for (std::size_t leaf = 0; leaf < cells_.leaves; ++leaf) {
        now.clear();
        for (std::size_t d = 0; d < kDirections; ++d)
            for (std::uint32_t item : of_leaf(leaf, d))
                now.push_back({item, 1u << d});
        std::sort(now.begin(), now.end(), [](const Member& a, const Member& b) { return a.item < b.item; });
        std::size_t kept = 0;
        for (std::size_t i = 0; i < now.size(); ++i) {
            if (kept > 0 && now[kept - 1].item == now[i].item)
                now[kept - 1].directions |= now[i].directions;
            else
                now[kept++] = now[i];
        }
        now.resize(kept);
        put_changes(coded, before, now);
        before = now;
    }
    put_space(out, cells_.bounds, coded);
}

Result<OccluderSets> OccluderSets::decode_changes(std::span<const std::byte> bytes, std::size_t& at, std::size_t items) {
    Box3d space;
    Result<std::span<const std::byte>> coded = take_space(bytes, at, space);
    if (!coded)
        return coded.status();
    OccluderSets sets;
    std::size_t place = 0;
    sets.cells_ = SpaceCells::decode(*coded, place, space);
    if (sets.cells_.nodes.empty())
        return corrupt("its cells are no tree");
    sets.first_.assign(1, 0);
    ChangesReader reader(*coded, place, items);
    for (std::uint32_t leaf = 0; leaf < sets.cells_.leaves; ++leaf) {
        if (!reader.next())
            return corrupt("a cell's changes contradict the cell before, or name what does not exist");
        for (std::size_t d = 0; d < kDirections; ++d) {
            for (const Member& member : reader.members())
                if (member.directions >> d & 1)
                    sets.polygons_.push_back(member.item);
            sets.first_.push_back(static_cast<std::uint32_t>(sets.polygons_.size()));
        }
        if (sets.polygons_.size() > kMostMembers)
            return corrupt("its sets have more than 67 million members");
    }
    if (place != coded->size())
        return corrupt("its size is wrong");
    return sets;
}

// Members of one cell's sets are much the same in neighbouring directions: each cell lists them once, sorted, and its
// sets refer to that list, by bytes if it has no more than 256.
void OccluderSets::encode(ByteWriter& out) const {
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
    put_space(out, cells_.bounds, coded);
}

Result<OccluderSets> OccluderSets::decode(std::span<const std::byte> bytes, std::size_t& at, std::size_t items) {
    Box3d space;
    Result<std::span<const std::byte>> taken = take_space(bytes, at, space);
    if (!taken)
        return taken.status();
    std::span<const std::byte> coded = *taken;
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
