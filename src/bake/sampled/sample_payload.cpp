#include "bake/sampled/sample_payload.hpp"

namespace antumbra {

void PayloadWriter::put(const RegionSample& sample) {
    for (std::uint64_t number : {std::uint64_t(sample.solid), sample.rays, sample.aimed_rays,
                                 std::uint64_t(sample.confirmed), std::uint64_t(sample.unconfirmed),
                                 std::uint64_t(sample.holdout_rays), std::uint64_t(sample.holdout_misses),
                                 std::uint64_t(sample.fewest_aimed)})
        put(number);
    for (std::uint64_t word : sample.visible)
        put(word);
}

std::uint64_t PayloadReader::get() {
    if (bytes_.size() < 8) {
        ok_ = false;
        return 0;
    }
    std::uint64_t word = 0;
    for (std::size_t byte = 0; byte < 8; ++byte)
        word |= std::to_integer<std::uint64_t>(bytes_[byte]) << (8 * byte);
    bytes_ = bytes_.subspan(8);
    return word;
}

RegionSample PayloadReader::get_sample(std::size_t words) {
    RegionSample sample;
    sample.solid = get() != 0;
    sample.rays = get();
    sample.aimed_rays = get();
    sample.confirmed = std::uint32_t(get());
    sample.unconfirmed = std::uint32_t(get());
    sample.holdout_rays = std::uint32_t(get());
    sample.holdout_misses = std::uint32_t(get());
    sample.fewest_aimed = std::uint32_t(get());
    if (!sample.solid && ok_ && bytes_.size() / 8 >= words) {
        sample.visible.resize(words);
        for (std::uint64_t& word : sample.visible)
            word = get();
    } else if (!sample.solid) {
        ok_ = false;
    }
    return sample;
}

} // namespace antumbra
