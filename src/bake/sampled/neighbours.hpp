// Which objects lie next to which: where to look once something was seen.
#pragma once

#include <antumbra/scene.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace antumbra {

/// For each object the nearest others, by the distance between boxes, then between their centres, then by index.
/// Immutable, thread-safe. O(n log n) time.
class ObjectNeighbours {
  public:
    static constexpr std::size_t kMost = 10;

    explicit ObjectNeighbours(const Scene& scene);
    /// At most kMost, nearest first.
    std::span<const std::uint32_t> of(std::uint32_t object) const {
        return {neighbours_.data() + begin_[object], begin_[object + 1] - begin_[object]};
    }

  private:
    std::vector<std::uint32_t> begin_, neighbours_;
};

} // namespace antumbra
