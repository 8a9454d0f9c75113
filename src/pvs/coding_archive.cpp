// The model: a bit is foretold by its left neighbours, by the same place and its surroundings in the row that this
// one refers to, and by the row that that one refers to. Sixteen such bits choose one of 65,536 adaptive
// probabilities; while that one is young, twelve of them choose another that has seen more.
#include "pvs/coding_archive.hpp"

#include "base/bytes.hpp"
#include "pvs/range_coder.hpp"
#include "pvs/reference_tree.hpp"
#include "pvs/row_coding.hpp"

#include <algorithm>
#include <array>

namespace antumbra {
namespace {

/// A probability that learns: by 1 / (times seen + 1.5), at least by 1/129.
class Adaptive {
  public:
    Probability one() const { return std::clamp<Probability>(one_, 32, 65535 - 32); }
    bool is_young() const { return seen_ < 3; }
    void learn(bool bit) {
        std::int32_t target = bit ? 65535 : 0;
        one_ = static_cast<std::uint16_t>(one_ + (target - one_) * 2 / (2 * seen_ + 3));
        seen_ = std::min(seen_ + 1, 127);
    }

  private:
    std::uint16_t one_ = 32768;
    int seen_ = 0;
};

/// Bits o-1, o-2, .. of a row are `left`; bit o + k of the references is bit 8 + k of `near` and of `far`.
class Model {
  public:
    template <class Coder>
    bool code(Coder& coder, unsigned left, unsigned near, unsigned far, bool bit) {
        // Twelve bits: four to the left, the reference from -2 to +3, its own reference at 0 and -1.
        std::size_t small = (left & 15) | (near >> 6 & 63) << 4 | (far >> 7 & 3) << 10;
        // Sixteen: two more to the left, the reference from -3 to +4.
        std::size_t large = (left & 63) | (near >> 5 & 255) << 6 | (far >> 7 & 3) << 14;
        Adaptive &young = small_[small], &old = large_[large];
        bit = coder.code((old.is_young() ? young : old).one(), bit);
        young.learn(bit);
        old.learn(bit);
        return bit;
    }

  private:
    std::vector<Adaptive> small_ = std::vector<Adaptive>(1 << 12), large_ = std::vector<Adaptive>(1 << 16);
};

struct Writer {
    RangeEncoder encoder{};
    bool code(Probability one, bool bit) {
        encoder.put(bit, one);
        return bit;
    }
};
struct Reader {
    RangeDecoder decoder;
    bool code(Probability one, bool) { return decoder.get(one); }
};

/// Sixteen bits of a row around bit o: bit 8 + k is bit o + k; zeros beyond the ends and for no row.
class Window {
  public:
    Window(std::span<const std::uint64_t> row, std::size_t objects) : row_(row), objects_(objects) {
        for (std::size_t k = 0; k < 8; ++k)
            bits_ |= unsigned(at(k)) << (8 + k);
    }
    unsigned bits() const { return bits_; }
    void move_on() {
        ++o_;
        bits_ = bits_ >> 1 | unsigned(at(o_ + 7)) << 15;
    }

  private:
    bool at(std::size_t bit) const { return !row_.empty() && bit < objects_ && (row_[bit / 64] >> (bit % 64) & 1); }
    std::span<const std::uint64_t> row_;
    std::size_t objects_, o_ = 0;
    unsigned bits_ = 0;
};

/// Tells one row; `row` holds it when writing and receives it when reading.
template <class Coder>
void code_row(Model& model, Coder& coder, std::span<std::uint64_t> row, std::span<const std::uint64_t> reference,
              std::span<const std::uint64_t> further, std::size_t objects) {
    Window near(reference, objects), far(further, objects);
    unsigned left = 0;
    for (std::size_t o = 0; o < objects; ++o) {
        std::uint64_t mask = std::uint64_t(1) << (o % 64);
        bool bit = model.code(coder, left, near.bits(), far.bits(), (row[o / 64] & mask) != 0);
        row[o / 64] = bit ? row[o / 64] | mask : row[o / 64] & ~mask;
        left = left << 1 | unsigned(bit);
        near.move_on();
        far.move_on();
    }
}

/// All rows, each behind the one that it refers to. Fewer than all if some refer to themselves through others.
std::vector<std::uint32_t> order_of(const std::vector<std::uint32_t>& references) {
    // Rows by what they refer to: a count, then a place for each.
    std::size_t rows = references.size();
    std::vector<std::uint32_t> first(rows + 2), followers(rows), order;
    auto slot = [&](std::uint32_t reference) { return reference == kNoReference ? rows : reference; };
    for (std::uint32_t reference : references)
        ++first[slot(reference) + 1];
    for (std::size_t i = 1; i < first.size(); ++i)
        first[i] += first[i - 1];
    std::vector<std::uint32_t> next = first;
    for (std::uint32_t row = 0; row < rows; ++row)
        followers[next[slot(references[row])]++] = row;
    auto add_followers = [&](std::size_t of) {
        order.insert(order.end(), followers.begin() + first[of], followers.begin() + first[of + 1]);
    };
    add_followers(rows);
    for (std::size_t done = 0; done < order.size(); ++done)
        add_followers(order[done]);
    return order;
}

template <class Coder>
void code_rows(Coder& coder, std::span<std::uint64_t> bits, const std::vector<std::uint32_t>& references,
               const std::vector<std::uint32_t>& order, std::size_t objects) {
    std::size_t words = words_for(objects);
    auto row = [&](std::uint32_t r) {
        return r == kNoReference ? std::span<std::uint64_t>() : bits.subspan(r * words, words);
    };
    Model model;
    for (std::uint32_t r : order) {
        std::uint32_t reference = references[r];
        std::uint32_t further = reference == kNoReference ? kNoReference : references[reference];
        code_row(model, coder, row(r), row(reference), row(further), objects);
    }
}

} // namespace

std::vector<std::byte> encode_archive(std::span<const std::uint64_t> bits, std::size_t row_count,
                                      std::size_t objects) {
    std::vector<std::uint32_t> references = choose_references(bits, row_count, words_for(objects), 0xFFFFFFFFu);
    ByteWriter out;
    for (std::uint32_t r = 0; r < row_count; ++r)
        out.varint(reference_code(r, references[r]));
    std::vector<std::uint64_t> copy(bits.begin(), bits.end());
    Writer writer;
    code_rows(writer, copy, references, order_of(references), objects);
    out.raw(writer.encoder.finish());
    return std::move(out.bytes);
}

Result<std::vector<std::uint64_t>> decode_archive(std::span<const std::byte> coded, std::uint32_t row_count,
                                                  std::size_t objects) {
    std::vector<std::uint32_t> references(row_count);
    std::size_t at = 0;
    for (std::uint32_t r = 0; r < row_count; ++r) {
        std::uint64_t code = 0;
        if (!read_varint(coded, at, code) || !read_reference(r, row_count, code, references[r]))
            return Status(ErrorCode::corrupt, "row " + std::to_string(r) + " refers to no row");
    }
    std::vector<std::uint32_t> order = order_of(references);
    if (order.size() != row_count)
        return Status(ErrorCode::corrupt, "some rows refer to themselves through others");
    std::vector<std::uint64_t> bits(std::size_t(row_count) * words_for(objects));
    Reader reader{RangeDecoder(coded.subspan(at))};
    code_rows(reader, bits, references, order, objects);
    return bits;
}

} // namespace antumbra
