// Row coding 5: each row by its difference from another one, bit by bit through a model of where differences lie. Any
// row can be decoded alone, by way of at most kMostReferences others. Byte layout: docs/format.md, section 4.
#pragma once

#include "base/bytes.hpp"

#include <antumbra/status.hpp>

#include <cstdint>
#include <span>

namespace antumbra {

/// Longest chain of references that a reader accepts.
inline constexpr std::uint32_t kMostReferences = 32;
/// Longest one that the writer makes: shorter chains decode faster, longer ones take fewer bits.
inline constexpr std::uint32_t kWrittenReferences = 8;

/// The bytes of the index (RIDX) and of the coded rows (ROWS).
struct CodedReferences {
    std::vector<std::byte> index, rows;
};

CodedReferences encode_references(std::span<const std::uint64_t> bits, std::size_t row_count, std::size_t objects,
                                  std::uint32_t most_depth = kWrittenReferences);

/// A view of both, safe with any content once open() has passed.
class ReferenceRows {
  public:
    /// What open() has accepted.
    ReferenceRows(std::span<const std::byte> index, std::span<const std::byte> rows, std::uint32_t row_count,
                  std::size_t objects)
        : index_(index), rows_(rows), row_count_(row_count), objects_(objects) {}
    /// ErrorCode::corrupt if a record lies outside, refers to no row, or to itself through others, or through more
    /// than kMostReferences. O(rows).
    static Result<ReferenceRows> open(std::span<const std::byte> index, std::span<const std::byte> rows,
                                      std::uint32_t row_count, std::size_t objects);

    /// Fills words_for(objects) words. O(references * objects).
    void decode(std::uint32_t row, std::span<std::uint64_t> words) const;

  private:
    struct Record {
        std::uint32_t reference; ///< or kNoReference
        std::span<const std::byte> coded;
    };
    Record record(std::uint32_t row) const;
    bool read_record(std::uint32_t row, std::size_t& at, Record& record) const;
    Status check_records() const;
    Status check_chains() const;

    std::span<const std::byte> index_, rows_;
    std::uint32_t row_count_;
    std::size_t objects_;
};

} // namespace antumbra
