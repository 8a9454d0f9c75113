// What an opened file answers. Everything here trusts what open() has proved.
#include <antumbra/pvs.hpp>

#include "pvs/cluster_triangles.hpp"
#include "pvs/coding_references.hpp"
#include "pvs/count_bits.hpp"
#include "pvs/format.hpp"
#include "pvs/grid.hpp"
#include "pvs/row_coding.hpp"

#include <algorithm>
#include <bit>

namespace antumbra {
namespace {

/// The one writer of "unknown": all objects, no bit beyond.
void mark_visible(std::span<std::uint64_t> words, std::size_t objects) {
    std::fill(words.begin(), words.end(), ~std::uint64_t(0));
    if (objects % 64 != 0 && !words.empty())
        words.back() = (std::uint64_t(1) << (objects % 64)) - 1;
}

/// Row of cells without an answer of their own.
constexpr std::uint32_t kEverything = kCellNotBaked;

// Values of PvsCursor::cell that are no cell.
constexpr std::int64_t kOutside = -1, kNoneYet = -2, kSeveral = -3;

/// Normals of the four planes of a frustum, each with the frustum on its positive side.
std::array<Vec3d, 4> inward_normals(const std::array<Vec3d, 4>& corners) {
    std::array<Vec3d, 4> normals;
    for (std::size_t i = 0; i < 4; ++i) {
        Vec3d normal = cross(corners[i], corners[(i + 1) % 4]);
        normals[i] = dot(normal, corners[(i + 2) % 4]) + dot(normal, corners[(i + 3) % 4]) < 0 ? -normal : normal;
    }
    return normals;
}

/// Whether `box`, seen from the cone's apex, is wholly on the far side of a plane through it: no doubt left.
bool is_outside(const Box3d& box, const Vec3d& normal) {
    double nearest = 0, magnitude = 0;
    for (int axis = 0; axis < 3; ++axis) {
        double low = box.min[axis] * normal[axis], high = box.max[axis] * normal[axis];
        nearest += std::max(low, high);
        magnitude += std::max(std::abs(low), std::abs(high));
    }
    return nearest < -1e-9 * magnitude;
}

} // namespace

const char* to_string(Guarantee guarantee) {
    switch (guarantee) {
    case Guarantee::exact:
        return "exact";
    case Guarantee::conservative:
        return "conservative";
    case Guarantee::aggressive:
        return "aggressive";
    case Guarantee::approximate:
        return "approximate";
    }
    return "unknown";
}

const char* to_string(PvsCoding coding) {
    switch (coding) {
    case PvsCoding::cheapest:
        return "cheapest";
    case PvsCoding::tree_leaves:
        return "tree-leaves";
    case PvsCoding::tree_parent:
        return "tree-parent";
    case PvsCoding::tree_sibling:
        return "tree-sibling";
    case PvsCoding::references:
        return "references";
    case PvsCoding::archive:
        return "archive";
    }
    return "unknown";
}

PvsObject Pvs::object(std::uint32_t index) const {
    std::size_t at = std::size_t(index) * kObjectBytes;
    auto corner = [&](std::size_t from) {
        return Vec3f{load_f32(objects_, from), load_f32(objects_, from + 4), load_f32(objects_, from + 8)};
    };
    PvsObject object;
    object.node = static_cast<std::int32_t>(load_u32(objects_, at));
    object.primitive = static_cast<std::int32_t>(load_u32(objects_, at + 4));
    object.instance = static_cast<std::int32_t>(load_u32(objects_, at + 8));
    object.flags = load_u32(objects_, at + 12);
    object.triangle_count = load_u32(objects_, at + 16);
    object.bounds = {corner(at + 24), corner(at + 36)};
    object.name = object_name(index);
    return object;
}

std::string_view Pvs::object_name(std::uint32_t index) const {
    auto end = [&](std::uint32_t i) { return load_u32(objects_, std::size_t(i) * kObjectBytes + 20); };
    std::size_t first = index == 0 ? 0 : end(index - 1);
    return {reinterpret_cast<const char*>(names_.data()) + first, end(index) - first};
}

Box3d Pvs::object_bounds(std::uint32_t index) const {
    std::size_t at = std::size_t(index) * kObjectBytes + 24;
    Box3d box;
    for (int axis = 0; axis < 3; ++axis) {
        box.min[axis] = origin_[axis] + double(load_f32(objects_, at + 4 * std::size_t(axis)));
        box.max[axis] = origin_[axis] + double(load_f32(objects_, at + 12 + 4 * std::size_t(axis)));
    }
    return box;
}

std::uint32_t Pvs::cell_row(std::uint64_t cell) const { return load_u32(cells_, std::size_t(cell) * kCellBytes); }

std::span<const std::byte> Pvs::coded_row(std::uint32_t row) const {
    auto end = [&](std::uint32_t r) { return load_u32(row_index_, std::size_t(r) * kRowIndexBytes); };
    std::size_t first = row == 0 ? 0 : end(row - 1);
    return row_bytes_.subspan(first, end(row) - first);
}

void Pvs::decode_row(std::uint32_t row, std::span<std::uint64_t> words) const {
    bool is_decoded = row < row_count_;
    if (is_decoded && coding_ == PvsCoding::references)
        ReferenceRows(row_index_, row_bytes_, row_count_, bits_per_row()).decode(row, words);
    else if (is_decoded)
        is_decoded = antumbra::decode_row(coded_row(row), bits_per_row(), words);
    // open() has seen that every row decodes; should the bytes have changed since, everything is visible.
    if (!is_decoded) {
        mark_visible(words, bits_per_row());
        return;
    }
    for (std::size_t w = 0; w < always_visible_.size(); ++w)
        words[w] |= always_visible_[w];
}

std::uint32_t Pvs::row_or_everything(std::int64_t cell) const {
    std::uint32_t row = cell < 0 ? kEverything : cell_row(std::uint64_t(cell));
    return row == kCellSolid ? kEverything : row;
}

Pvs::Touched Pvs::touched(const ViewRange& range, std::vector<std::uint32_t>& rows) const {
    rows.clear();
    Touched touched;
    if (!tree_.nodes.empty()) {
        if (!tree_.find_leaves(range, rows))
            return touched;
        touched.only = rows.size() == 1 ? std::int64_t(rows[0]) : kSeveral;
        for (std::uint32_t& leaf : rows)
            leaf = tree_.nodes[leaf].link;
    } else {
        if (grid_.cells() == 0 || !grid_.bounds.contains(range.eyes.min) || !grid_.bounds.contains(range.eyes.max) ||
            range.eyes.empty())
            return touched;
        touched.only = kSeveral;
        SlabRange slabs = slabs_of(grid_, range.eyes);
        for (std::uint64_t k = slabs.first[2]; k <= slabs.last[2]; ++k)
            for (std::uint64_t j = slabs.first[1]; j <= slabs.last[1]; ++j)
                for (std::uint64_t i = slabs.first[0]; i <= slabs.last[0]; ++i)
                    rows.push_back(cell_row(i + grid_.count[0] * (j + grid_.count[1] * k)));
    }
    std::sort(rows.begin(), rows.end());
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
    touched.known = rows.back() < kCellSolid;
    return touched;
}

/// Bits of all rows of cursor.next_rows into cursor.united.
void Pvs::unite(PvsCursor& cursor) const {
    cursor.united.resize(words_per_row());
    cursor.decoded.resize(words_per_row());
    decode_row(cursor.next_rows[0], cursor.united);
    for (std::size_t i = 1; i < cursor.next_rows.size(); ++i) {
        decode_row(cursor.next_rows[i], cursor.decoded);
        for (std::size_t w = 0; w < cursor.united.size(); ++w)
            cursor.united[w] |= cursor.decoded[w];
    }
}

/// Makes cursor.united the answer: its first bits are objects, the others volumes. Whether that changed it.
bool Pvs::show(PvsCursor& cursor) const {
    std::size_t first = object_count_ / 64; // the word in which the volumes begin
    unsigned shift = object_count_ % 64;
    bool changed = false;
    auto put = [&](std::uint64_t& to, std::uint64_t value) {
        changed = changed || to != value;
        to = value;
    };
    cursor.visible.resize(words_for(object_count_));
    cursor.volumes.resize(words_for(bits_per_row() - object_count_));
    for (std::size_t w = 0; w < cursor.visible.size(); ++w)
        put(cursor.visible[w], w == first ? cursor.united[w] & ((std::uint64_t(1) << shift) - 1) : cursor.united[w]);
    for (std::size_t w = 0; w < cursor.volumes.size(); ++w) {
        std::uint64_t value = cursor.united[first + w] >> shift;
        if (shift != 0 && first + w + 1 < cursor.united.size())
            value |= cursor.united[first + w + 1] << (64 - shift);
        put(cursor.volumes[w], value);
    }
    cursor.visible_count = count_bits(cursor.visible);
    return changed;
}

/// Answers from cursor.next_rows, or with everything.
bool Pvs::answer(bool known, const ViewRange& range, PvsCursor& cursor) const {
    bool changed = cursor.cell == kNoneYet || cursor.everything == known;
    cursor.everything = !known;
    if (known) {
        unite(cursor);
    } else {
        cursor.united.resize(words_per_row());
        mark_visible(cursor.united, bits_per_row());
    }
    if (!range.all_directions)
        drop_outside(range, cursor.united);
    return show(cursor) || changed;
}

bool Pvs::query(const Vec3d& eye, PvsCursor& cursor) const {
    ViewRange range{{eye, eye}, true, {}};
    if (!tree_.nodes.empty())
        return query_range(range, cursor);
    std::int64_t cell = grid_.find(eye);
    if (cell == cursor.cell)
        return false;
    std::uint32_t row = row_or_everything(cell);
    bool changed = cursor.cell < kOutside || row != row_or_everything(cursor.cell);
    if (changed) {
        cursor.next_rows.assign(1, row);
        changed = answer(row != kEverything, range, cursor);
    }
    cursor.cell = cell;
    return changed;
}

bool Pvs::query_range(const ViewRange& range, PvsCursor& cursor) const {
    Touched cells = touched(range, cursor.next_rows);
    bool changed = answer(cells.known, range, cursor);
    // In a grid, only query(eye) may say that the cursor holds all that a cell sees.
    cursor.cell = cells.only == kOutside || !tree_.nodes.empty() ? cells.only : kSeveral;
    return changed;
}

void Pvs::drop_outside(const ViewRange& range, std::span<std::uint64_t> objects) const {
    std::array<Vec3d, 4> normals = inward_normals(range.corners);
    for (std::size_t w = 0; w < words_for(object_count_); ++w)
        for (std::uint64_t rest = objects[w] & ~always_visible_[w]; rest != 0; rest &= rest - 1) {
            std::size_t o = w * 64 + static_cast<unsigned>(std::countr_zero(rest));
            if (o >= object_count_)
                return; // volumes
            Box3d bounds = object_bounds(static_cast<std::uint32_t>(o));
            // All differences of a point of the object and a viewpoint.
            Box3d seen{bounds.min - range.eyes.max, bounds.max - range.eyes.min};
            bool outside = false;
            for (const Vec3d& normal : normals)
                outside = outside || is_outside(seen, normal);
            if (outside)
                objects[w] &= ~(std::uint64_t(1) << (o % 64));
        }
}

std::uint32_t Pvs::cluster_first(std::uint32_t c) const { return load_u32(clusters_, std::size_t(4) * c); }

#ifndef ANTUMBRA_WITHOUT_CLUSTERS
PvsTriangles Pvs::triangles_of(std::uint32_t object, std::uint32_t most) const {
    PvsTriangles triangles;
    if (tells_triangles()) {
        decode_triangles(triangles_, triangle_index_[object], cluster_index_[object], most, triangles);
        return triangles;
    }
    triangles.in_file = load_u32(objects_, std::size_t(object) * kObjectBytes + 16);
    for (std::uint32_t c = first_cluster_of(object); triangles.in_file <= most && c < first_cluster_of(object + 1); ++c)
        triangles.cluster.resize(triangles.cluster.size() + cluster_first(c + 1) - cluster_first(c), c);
    return triangles;
}
#endif

bool Pvs::is_cluster_visible(std::uint32_t c, const PvsCursor& cursor) const {
    if (cursor.everything || cursor.cell == kNoneYet || c >= cluster_count_)
        return true;
    std::size_t bit = std::size_t(volumes_.cells()) + c;
    return cursor.volumes[bit / 64] >> (bit % 64) & 1;
}

bool Pvs::is_box_visible(const Box3d& box, const PvsCursor& cursor) const {
    if (cursor.everything || cursor.cell == kNoneYet || cursor.volumes.empty() || box.empty() ||
        !volumes_.bounds.contains(box.min) || !volumes_.bounds.contains(box.max))
        return true;
    SlabRange slabs = slabs_of(volumes_, box);
    for (int axis = 0; axis < 3; ++axis) { // a face in common is touched, too
        auto k = static_cast<std::size_t>(axis);
        double low = volumes_.bounds.min[axis], high = volumes_.bounds.max[axis];
        while (slabs.first[k] > 0 && slab_start(low, high, volumes_.count[k], slabs.first[k]) >= box.min[axis])
            --slabs.first[k];
    }
    for (std::uint64_t z = slabs.first[2]; z <= slabs.last[2]; ++z)
        for (std::uint64_t y = slabs.first[1]; y <= slabs.last[1]; ++y)
            for (std::uint64_t x = slabs.first[0]; x <= slabs.last[0]; ++x) {
                std::uint64_t v = x + volumes_.count[0] * (y + volumes_.count[1] * z);
                if (cursor.volumes[v / 64] >> (v % 64) & 1)
                    return true;
            }
    return false;
}

} // namespace antumbra
