#include "pvs/row_coding.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

namespace antumbra {
namespace {

// Tokens of RowWay::runs: the two top bits say what, the six low ones how many less one.
enum Token : unsigned { kLiteral = 0x00, kZeros = 0x80, kOnes = 0xC0 };
constexpr unsigned kTokenMask = 0xC0, kLongestRun = 64;

/// A reader of one coded row: every access is checked, and the first impossible one ends it.
class RowReader {
  public:
    explicit RowReader(std::span<const std::byte> bytes) : bytes_(bytes) {}
    std::size_t left() const { return bytes_.size() - at_; }
    unsigned next() { return std::to_integer<unsigned>(bytes_[at_++]); }
    std::span<const std::byte> take(std::size_t count) {
        at_ += count;
        return bytes_.subspan(at_ - count, count);
    }
    /// Up to five bytes; false where they end or the value needs more than 32 bits.
    bool varint(std::uint64_t& value) {
        value = 0;
        for (unsigned shift = 0; shift < 35 && left() > 0; shift += 7) {
            unsigned byte = next();
            value |= std::uint64_t(byte & 0x7F) << shift;
            if (byte < 0x80)
                return value <= 0xFFFFFFFFu;
        }
        return false;
    }

  private:
    std::span<const std::byte> bytes_;
    std::size_t at_ = 0;
};

/// Bits of the last byte of a row that stand for no object.
constexpr unsigned excess_bits(std::size_t objects) { return objects % 8 ? 0xFFu << (objects % 8) & 0xFFu : 0; }

// Where the three ways put what they decode: nowhere, to check a row ..
struct NoSink {
    void literal(std::size_t, std::span<const std::byte>) {}
    void ones(std::size_t, std::size_t) {}
    void bit(std::size_t) {}
};
// .. or into the bytes of zeroed words, which finish() then turns into words on machines of other byte order.
struct WordSink {
    unsigned char* bytes;
    void literal(std::size_t at, std::span<const std::byte> from) {
        if (!from.empty()) // of no objects there are no words, and memcpy wants a place even for nothing
            std::memcpy(bytes + at, from.data(), from.size());
    }
    void ones(std::size_t at, std::size_t count) { std::memset(bytes + at, 0xFF, count); }
    void bit(std::size_t at) { bytes[at / 8] = static_cast<unsigned char>(bytes[at / 8] | 1u << (at % 8)); }
};

template <class Sink>
bool read_raw(RowReader& in, std::size_t objects, Sink& sink) {
    if (in.left() != bytes_for(objects))
        return false;
    std::span<const std::byte> bytes = in.take(in.left());
    sink.literal(0, bytes);
    return bytes.empty() || (std::to_integer<unsigned>(bytes.back()) & excess_bits(objects)) == 0;
}

template <class Sink>
bool read_runs(RowReader& in, std::size_t objects, Sink& sink) {
    std::size_t at = 0, end = bytes_for(objects);
    unsigned last = 0;
    while (in.left() > 0) {
        unsigned token = in.next();
        std::size_t count = (token & ~kTokenMask) + 1;
        if (count > end - at)
            return false;
        if ((token & kTokenMask) == kLiteral) {
            if (count > in.left())
                return false;
            std::span<const std::byte> bytes = in.take(count);
            sink.literal(at, bytes);
            last = std::to_integer<unsigned>(bytes.back());
        } else if ((token & kTokenMask) == kZeros) {
            last = 0;
        } else if ((token & kTokenMask) == kOnes) {
            sink.ones(at, count);
            last = 0xFF;
        } else {
            return false;
        }
        at += count;
    }
    return at == end && (last & excess_bits(objects)) == 0;
}

template <class Sink>
bool read_gaps(RowReader& in, std::size_t objects, Sink& sink) {
    std::uint64_t next = 0; // the lowest bit that the next gap can reach
    while (in.left() > 0) {
        std::uint64_t gap;
        if (!in.varint(gap) || gap >= objects - next)
            return false;
        sink.bit(std::size_t(next + gap));
        next += gap + 1;
    }
    return true;
}

template <class Sink>
bool read_row(std::span<const std::byte> coded, std::size_t objects, Sink& sink) {
    RowReader in(coded);
    if (in.left() == 0)
        return false;
    switch (RowWay(in.next())) {
    case RowWay::raw:
        return read_raw(in, objects, sink);
    case RowWay::runs:
        return read_runs(in, objects, sink);
    case RowWay::gaps:
        return read_gaps(in, objects, sink);
    }
    return false;
}

std::vector<std::byte> row_bytes(std::span<const std::uint64_t> words, std::size_t objects) {
    std::vector<std::byte> bytes(bytes_for(objects));
    for (std::size_t i = 0; i < bytes.size(); ++i)
        bytes[i] = std::byte(words[i / 8] >> (i % 8 * 8) & 0xFF);
    return bytes;
}

/// Length of the run of bytes equal to the one at `at`, at most kLongestRun.
std::size_t run_length(std::span<const std::byte> bytes, std::size_t at) {
    std::size_t end = std::min(bytes.size(), at + kLongestRun), i = at + 1;
    while (i < end && bytes[i] == bytes[at])
        ++i;
    return i - at;
}

bool is_run_byte(std::byte byte) { return byte == std::byte(0) || byte == std::byte(0xFF); }

/// Greedy: a lone zero or 0xFF byte between literals stays a literal (a token of its own costs as much and
/// another literal token would follow).
void write_runs(std::span<const std::byte> bytes, ByteWriter& out) {
    out.u8(std::uint8_t(RowWay::runs));
    for (std::size_t at = 0; at < bytes.size();) {
        if (is_run_byte(bytes[at])) {
            std::size_t count = run_length(bytes, at);
            out.u8(std::uint8_t((bytes[at] == std::byte(0) ? kZeros : kOnes) | (count - 1)));
            at += count;
            continue;
        }
        std::size_t end = at + 1;
        while (end < bytes.size() && end - at < kLongestRun &&
               !(is_run_byte(bytes[end]) && (end + 1 == bytes.size() || run_length(bytes, end) > 1)))
            ++end;
        out.u8(std::uint8_t(kLiteral | (end - at - 1)));
        out.raw(bytes.subspan(at, end - at));
        at = end;
    }
}

void write_gaps(std::span<const std::uint64_t> words, ByteWriter& out) {
    out.u8(std::uint8_t(RowWay::gaps));
    std::uint64_t next = 0;
    for (std::size_t w = 0; w < words.size(); ++w)
        for (std::uint64_t rest = words[w]; rest != 0; rest &= rest - 1) {
            std::uint64_t bit = w * 64 + static_cast<unsigned>(std::countr_zero(rest));
            out.varint(bit - next);
            next = bit + 1;
        }
}

} // namespace

void encode_row(std::span<const std::uint64_t> words, std::size_t objects, ByteWriter& out) {
    std::vector<std::byte> bytes = row_bytes(words, objects);
    ByteWriter raw, runs, gaps;
    raw.u8(std::uint8_t(RowWay::raw));
    raw.raw(bytes);
    write_runs(bytes, runs);
    write_gaps(words, gaps);
    // On a draw the one that decodes fastest.
    const ByteWriter* best = &raw;
    for (const ByteWriter* other : {&runs, &gaps})
        if (other->bytes.size() < best->bytes.size())
            best = other;
    out.raw(best->bytes);
}

bool is_row(std::span<const std::byte> coded, std::size_t objects) {
    NoSink sink;
    return read_row(coded, objects, sink);
}

bool decode_row(std::span<const std::byte> coded, std::size_t objects, std::span<std::uint64_t> words) {
    std::fill(words.begin(), words.end(), 0);
    WordSink sink{reinterpret_cast<unsigned char*>(words.data())};
    if (!read_row(coded, objects, sink))
        return false;
    // What was written bytewise is little-endian; a no-op where the machine is.
    for (std::uint64_t& word : words)
        word = load_u64(std::as_bytes(std::span(&word, 1)), 0);
    return true;
}

} // namespace antumbra
