// What an opened file answers. Everything here trusts what open() has proved.
#include <antumbra/pvs.hpp>

#include "pvs/format.hpp"
#include "pvs/row_coding.hpp"

#include <algorithm>

namespace antumbra {
namespace {

/// Portable and inlined: the library call that stands for std::popcount without the instruction costs more.
std::uint32_t count_bits(std::span<const std::uint64_t> words) {
    std::uint64_t total = 0;
    for (std::uint64_t word : words) {
        word -= word >> 1 & 0x5555555555555555u;
        word = (word & 0x3333333333333333u) + (word >> 2 & 0x3333333333333333u);
        word = (word + (word >> 4)) & 0x0F0F0F0F0F0F0F0Fu;
        total += word * 0x0101010101010101u >> 56;
    }
    return static_cast<std::uint32_t>(total);
}

/// The one writer of "unknown": all objects, no bit beyond.
void mark_visible(std::span<std::uint64_t> words, std::size_t objects) {
    std::fill(words.begin(), words.end(), ~std::uint64_t(0));
    if (objects % 64 != 0 && !words.empty())
        words.back() = (std::uint64_t(1) << (objects % 64)) - 1;
}

/// Row of cells without an answer of their own.
constexpr std::uint32_t kEverything = kCellNotBaked;

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

std::uint64_t Pvs::visibility_bytes() const { return row_index_.size() + row_bytes_.size(); }

std::span<const std::byte> Pvs::coded_row(std::uint32_t row) const {
    auto end = [&](std::uint32_t r) { return load_u32(row_index_, std::size_t(r) * kRowIndexBytes); };
    std::size_t first = row == 0 ? 0 : end(row - 1);
    return row_bytes_.subspan(first, end(row) - first);
}

void Pvs::decode_row(std::uint32_t row, std::span<std::uint64_t> words) const {
    // open() has seen that every row decodes; should the bytes have changed since, everything is visible.
    if (row >= row_count_ || !antumbra::decode_row(coded_row(row), object_count_, words)) {
        mark_visible(words, object_count_);
        return;
    }
    for (std::size_t w = 0; w < words.size(); ++w)
        words[w] |= always_visible_[w];
}

std::uint32_t Pvs::row_or_everything(std::int64_t cell) const {
    std::uint32_t row = cell < 0 ? kEverything : cell_row(std::uint64_t(cell));
    return row == kCellSolid ? kEverything : row;
}

bool Pvs::query(const Vec3d& eye, PvsCursor& cursor) const {
    std::int64_t cell = grid_.find(eye);
    bool first = cursor.cell == -2 || cursor.visible.size() != words_per_row();
    if (!first && cell == cursor.cell)
        return false;
    std::uint32_t row = row_or_everything(cell);
    bool same = !first && row == (cursor.everything ? kEverything : row_or_everything(cursor.cell));
    cursor.cell = cell;
    if (same)
        return false;
    cursor.visible.resize(words_per_row());
    cursor.everything = row == kEverything;
    if (cursor.everything)
        mark_visible(cursor.visible, object_count_);
    else
        decode_row(row, cursor.visible);
    cursor.visible_count = count_bits(cursor.visible);
    return true;
}

} // namespace antumbra
