// A sampled region as bytes, for the checkpoint: eight numbers of 64 bits, then the bit set.
#pragma once

#include "bake/resumable.hpp"
#include "bake/sampled/region_sampler.hpp"

namespace antumbra {

/// Appends integers of 64 bits, little-endian.
class PayloadWriter {
  public:
    void put(std::uint64_t word) {
        for (int byte = 0; byte < 8; ++byte)
            bytes_.push_back(std::byte(word >> (8 * byte) & 0xFF));
    }
    void put(const RegionSample& sample);
    Payload take() { return std::move(bytes_); }

  private:
    Payload bytes_;
};

/// Reads them back; ok() turns false, for good, once more was asked for than there is.
class PayloadReader {
  public:
    explicit PayloadReader(std::span<const std::byte> bytes) : bytes_(bytes) {}
    std::uint64_t get();
    /// `words` of the bit set are read unless the sample is solid.
    RegionSample get_sample(std::size_t words);
    bool ok() const { return ok_; }
    bool at_end() const { return ok_ && bytes_.empty(); }

  private:
    std::span<const std::byte> bytes_;
    bool ok_ = true;
};

} // namespace antumbra
