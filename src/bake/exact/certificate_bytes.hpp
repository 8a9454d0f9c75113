// Bytes of a file of certificates: numbers, points, trees. Layout: docs/methods/exact.md.
#pragma once

#include "base/bytes.hpp"
#include "bake/exact/frame.hpp"
#include "certify/certificate.hpp"

#include <algorithm>

namespace antumbra::certificates {

using certify::HiddenTree;
using certify::Integer;

inline constexpr char kMagic[8] = {'\x89', 'P', 'R', 'F', '\r', '\n', '\x1a', '\n'};
inline constexpr std::uint32_t kVersion = 1;
inline constexpr std::size_t kHeader = 56, kBlockHeader = 24;
inline constexpr std::size_t kLargestInteger = 1 << 16; ///< bytes

/// First byte of a certificate.
enum class Kind : std::uint8_t { hidden = 0, visible = 1, touches = 2, undecided = 3 };

/// Reads numbers; ok() turns false, for good, once the bytes end or make no sense.
class Reader {
  public:
    explicit Reader(std::span<const std::byte> bytes) : bytes_(bytes) {}
    bool ok() const { return ok_; }
    bool at_end() const { return ok_ && at_ == bytes_.size(); }

    std::uint8_t byte() {
        if (at_ >= bytes_.size())
            ok_ = false;
        return ok_ ? std::to_integer<std::uint8_t>(bytes_[at_++]) : std::uint8_t(0);
    }
    std::uint64_t number() {
        std::uint64_t value = 0;
        for (unsigned shift = 0; shift < 64 && ok_; shift += 7) {
            std::uint8_t b = byte();
            value |= std::uint64_t(b & 0x7F) << shift;
            if (b < 0x80)
                return value;
        }
        ok_ = false;
        return 0;
    }
    /// Of things that take at least a byte each.
    std::size_t count() {
        std::uint64_t n = number();
        if (n > bytes_.size() - std::min(at_, bytes_.size()))
            ok_ = false;
        return ok_ ? std::size_t(n) : 0;
    }
    std::int64_t signed_number() {
        std::uint64_t n = number();
        return std::int64_t(n >> 1) ^ -std::int64_t(n & 1);
    }
    Integer integer() {
        std::uint64_t head = number();
        std::size_t size = std::size_t(head >> 1);
        Integer value = 0;
        if (size > kLargestInteger || size > bytes_.size() - std::min(at_, bytes_.size()))
            ok_ = false;
        if (!ok_ || size == 0)
            return value;
        auto first = reinterpret_cast<const unsigned char*>(bytes_.data() + at_);
        import_bits(value, first, first + size, 8, false);
        at_ += size;
        return head & 1 ? Integer(-value) : value;
    }
    GridPoint point() {
        GridPoint p;
        for (int k = 0; k < 3; ++k) {
            p[k] = signed_number();
            if (p[k] < -(1 << 25) || p[k] > 1 << 25)
                ok_ = false;
        }
        return p;
    }
    void fail() { ok_ = false; }

  private:
    std::span<const std::byte> bytes_;
    std::size_t at_ = 0;
    bool ok_ = true;
};

/// Seven bits a byte, lowest first, up to 64 bits.
void put_number(ByteWriter& out, std::uint64_t value);
void put_signed(ByteWriter& out, std::int64_t value);
void put_integer(ByteWriter& out, const Integer& value);
void put_point(ByteWriter& out, const GridPoint& p);
void put_rational_point(ByteWriter& out, const Vec3<certify::Rational>& p);
Vec3<certify::Rational> get_rational_point(Reader& in);
void put_tree(ByteWriter& out, const HiddenTree& tree);
/// Of a tree whose leaves name the first `blockers` blockers; fails where they, or children, are out of range.
HiddenTree get_tree(Reader& in, std::size_t blockers);

} // namespace antumbra::certificates
