// How a row is told from its reference: byte by byte, first whether anything in the byte differs, then, if so, its
// bits. Both questions are put to an arithmetic coder with the probability that a fixed table gives them in their
// context: the byte of the reference and its neighbours, and what has already been told of the row. The table is that
// of the file, so that rows do not depend on one another's statistics.
#include "pvs/coding_references.hpp"

#include "pvs/count_bits.hpp"
#include "pvs/range_coder.hpp"
#include "pvs/reference_tree.hpp"
#include "pvs/row_coding.hpp"

#include <array>

namespace antumbra {
namespace {

constexpr std::size_t kByteContexts = 5 * 4 * 16, kBitContexts = 3 * 128, kContexts = kByteContexts + kBitContexts;
/// Rows between two entries of the index.
constexpr std::size_t kBlock = 32;

using Table = std::array<std::uint8_t, kContexts>;

/// The middle of each of 256 steps: never 0 or 1.
constexpr Probability probability(std::uint8_t step) { return step * 256u + 128u; }

/// How a byte of the reference looks: how many bits are set (0, 1, 2, more, all) and how often they change (0, 1, 2,
/// more).
constexpr std::array<std::uint8_t, 256> make_looks() {
    std::array<std::uint8_t, 256> looks{};
    for (unsigned byte = 0; byte < 256; ++byte) {
        unsigned ones = count_bits(std::uint64_t(byte)), changes = count_bits(std::uint64_t((byte ^ byte >> 1) & 0x7F));
        looks[byte] = static_cast<std::uint8_t>((ones == 8 ? 4 : ones < 3 ? ones : 3) * 4 + (changes < 3 ? changes : 3));
    }
    return looks;
}
constexpr std::array<std::uint8_t, 256> kLooks = make_looks();

/// The bits of a byte that differs somewhere. If all but the last are told to be equal, the last is known.
template <class Coder>
unsigned walk_byte(unsigned old, unsigned old_before, unsigned new_before, unsigned after, unsigned valid, Coder& coder,
                   unsigned wanted) {
    unsigned wide = old_before >> 7 | old << 1 | (after & 1) << 9; // the reference from one bit before to one after
    unsigned row = 0, left = new_before >> 7, differences = ((old_before ^ new_before) >> 6) & 3;
    differences = (differences >> 1 & 1) | (differences & 1) << 1; // the nearest in the lowest bit
    bool some = false;
    for (unsigned j = 0; j < valid; ++j) {
        unsigned reference = wide >> (j + 1) & 1;
        bool bit;
        if (j + 1 == valid && !some) {
            bit = !reference;
        } else {
            unsigned place = (valid - 1 - j) / 2;
            std::size_t context = (wide >> j & 7) | left << 3 | differences << 4 | unsigned(some) << 6;
            bit = coder.code(kByteContexts + (place < 2 ? place : 2) * 128 + context, wanted >> j & 1);
        }
        bool differs = bit != bool(reference);
        some = some || differs;
        differences = (differences << 1 | unsigned(differs)) & 3;
        left = bit;
        row |= unsigned(bit) << j;
    }
    return row;
}

/// Walks a row that starts as its reference and ends as itself. `coder.code(context, bit)` returns the bit: the one
/// given when it counts or writes, the next one when it reads. `target(i)` gives byte i of the row when writing.
template <class Coder, class Target>
void walk_row(unsigned char* bytes, std::size_t objects, Coder& coder, Target target) {
    std::size_t count = bytes_for(objects);
    unsigned old_before = 0, new_before = 0; // the byte before: of the reference, of the row
    unsigned told = 0;                       // whether the two bytes before differed
    for (std::size_t i = 0; i < count; ++i) {
        unsigned old = bytes[i], after = i + 1 < count ? bytes[i + 1] : 0, wanted = target(i);
        unsigned valid = i + 1 == count ? unsigned(objects - 8 * i) : 8;
        std::size_t context = kLooks[old] * 16u + told * 4 + (after != 0) * 2u + (old_before != 0);
        bool differs = coder.code(context, wanted != old);
        unsigned row = old;
        if (differs)
            row = walk_byte(old, old_before, new_before, after, valid, coder, wanted);
        told = (told << 1 | unsigned(differs)) & 3;
        bytes[i] = static_cast<unsigned char>(row);
        old_before = old;
        new_before = row;
    }
}

struct Counter {
    std::array<std::uint32_t, kContexts> ones{}, all{};
    bool code(std::size_t context, bool bit) {
        ones[context] += bit;
        ++all[context];
        return bit;
    }
    Table table() const {
        Table table{};
        for (std::size_t c = 0; c < kContexts; ++c)
            table[c] = static_cast<std::uint8_t>((ones[c] * std::uint64_t(256)) / (std::uint64_t(all[c]) + 1));
        return table;
    }
};

struct Writer {
    const Table& table;
    RangeEncoder encoder{};
    bool code(std::size_t context, bool bit) {
        encoder.put(bit, probability(table[context]));
        return bit;
    }
};

struct Reader {
    std::span<const std::byte> table;
    RangeDecoder decoder;
    bool code(std::size_t context, bool) {
        return decoder.get(probability(std::to_integer<std::uint8_t>(table[context])));
    }
};

/// Bytes of row r, or zeros for kNoReference.
void load_row(std::span<const std::uint64_t> bits, std::uint32_t row, std::size_t objects,
              std::vector<unsigned char>& bytes) {
    std::size_t words = words_for(objects);
    bytes.assign(words * 8, 0);
    for (std::size_t i = 0; row != kNoReference && i < bytes_for(objects); ++i)
        bytes[i] = static_cast<unsigned char>(bits[row * words + i / 8] >> (i % 8 * 8));
}

/// Hands each row, told from its reference, to a coder.
template <class Coder>
void code_row(std::span<const std::uint64_t> bits, std::uint32_t row, std::uint32_t reference, std::size_t objects,
              Coder& coder) {
    std::vector<unsigned char> bytes, wanted;
    load_row(bits, reference, objects, bytes);
    load_row(bits, row, objects, wanted);
    walk_row(bytes.data(), objects, coder, [&](std::size_t i) -> unsigned { return wanted[i]; });
}

} // namespace

CodedReferences encode_references(std::span<const std::uint64_t> bits, std::size_t row_count, std::size_t objects,
                                  std::uint32_t most_depth) {
    std::vector<std::uint32_t> references = choose_references(bits, row_count, words_for(objects), most_depth);
    Counter counter;
    for (std::uint32_t r = 0; r < row_count; ++r)
        code_row(bits, r, references[r], objects, counter);
    Table table = counter.table();
    ByteWriter index, rows;
    for (std::uint8_t step : table)
        rows.u8(step);
    for (std::uint32_t r = 0; r < row_count; ++r) {
        if (r % kBlock == 0)
            index.u32(static_cast<std::uint32_t>(rows.bytes.size()));
        Writer writer{table};
        code_row(bits, r, references[r], objects, writer);
        std::vector<std::byte> coded = writer.encoder.finish();
        rows.varint(reference_code(r, references[r]));
        rows.varint(coded.size());
        rows.raw(coded);
    }
    return {std::move(index.bytes), std::move(rows.bytes)};
}

Result<ReferenceRows> ReferenceRows::open(std::span<const std::byte> index, std::span<const std::byte> rows,
                                          std::uint32_t row_count, std::size_t objects) {
    ReferenceRows view(index, rows, row_count, objects);
    if (Status status = view.check_records(); !status)
        return status;
    if (Status status = view.check_chains(); !status)
        return status;
    return view;
}

bool ReferenceRows::read_record(std::uint32_t row, std::size_t& at, Record& record) const {
    std::uint64_t code = 0, size = 0;
    if (!read_varint(rows_, at, code) || !read_varint(rows_, at, size) || size > rows_.size() - at)
        return false;
    if (!read_reference(row, row_count_, code, record.reference))
        return false;
    record.coded = rows_.subspan(at, std::size_t(size));
    at += std::size_t(size);
    return true;
}

Status ReferenceRows::check_records() const {
    if (rows_.size() < kContexts || index_.size() != (std::size_t(row_count_) + kBlock - 1) / kBlock * 4)
        return {ErrorCode::corrupt, "the index of the rows or their table is too short"};
    std::size_t at = kContexts;
    Record record;
    for (std::uint32_t row = 0; row < row_count_; ++row)
        if ((row % kBlock == 0 && load_u32(index_, row / kBlock * 4) != at) || !read_record(row, at, record))
            return {ErrorCode::corrupt, "row " + std::to_string(row) + " cannot be found"};
    return at == rows_.size() ? Status() : Status(ErrorCode::corrupt, "there is more than the rows");
}

/// Depths of all rows, each found once: O(rows) in all.
Status ReferenceRows::check_chains() const {
    std::vector<std::uint32_t> reference(row_count_);
    std::vector<std::uint8_t> depth(row_count_, 0xFF);
    std::size_t at = kContexts;
    Record record;
    for (std::uint32_t row = 0; row < row_count_ && read_record(row, at, record); ++row)
        reference[row] = record.reference;
    for (std::uint32_t row = 0; row < row_count_; ++row) {
        std::uint32_t length = 0, at_row = row; // walk to a row of known depth, or to an end
        for (; at_row != kNoReference && depth[at_row] == 0xFF && length <= kMostReferences; at_row = reference[at_row])
            ++length;
        std::uint32_t total = length + (at_row == kNoReference ? 0 : depth[at_row] == 0xFF ? kMostReferences : depth[at_row] + 1);
        if (total > kMostReferences + 1)
            return {ErrorCode::corrupt, "row " + std::to_string(row) + " refers through too many others"};
        for (at_row = row; length > 0; --length, at_row = reference[at_row])
            depth[at_row] = static_cast<std::uint8_t>(--total);
    }
    return {};
}

ReferenceRows::Record ReferenceRows::record(std::uint32_t row) const {
    std::size_t at = load_u32(index_, row / kBlock * 4);
    Record record{kNoReference, {}};
    for (std::uint32_t r = row / kBlock * kBlock; r <= row; ++r)
        (void)read_record(r, at, record);
    return record;
}

void ReferenceRows::decode(std::uint32_t row, std::span<std::uint64_t> words) const {
    std::array<std::span<const std::byte>, kMostReferences + 1> chain;
    std::size_t length = 0;
    while (row != kNoReference && length < chain.size()) {
        Record found = record(row);
        chain[length++] = found.coded;
        row = found.reference;
    }
    std::fill(words.begin(), words.end(), 0);
    auto* bytes = reinterpret_cast<unsigned char*>(words.data());
    while (length-- > 0) {
        Reader reader{rows_.first(kContexts), RangeDecoder(chain[length])};
        walk_row(bytes, objects_, reader, [](std::size_t) { return 0u; });
    }
    // What was written bytewise is little-endian; a no-op where the machine is.
    for (std::uint64_t& word : words)
        word = load_u64(std::as_bytes(std::span(&word, 1)), 0);
}

} // namespace antumbra
