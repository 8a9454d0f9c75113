// From the minimum occluder sets of all occludees to one list of occluders (Poon, Wang 1999, 4.3).
#pragma once

#include "mos/occluder_stack.hpp"

#include <antumbra/mos.hpp>

namespace antumbra {

/// A set of members of a stack and the occludees that it hides.
struct GroupedSet {
    std::vector<std::uint32_t> members;   ///< ascending
    std::vector<std::uint32_t> occludees; ///< ascending
    double cost = 0;
};

/// Takes sets until `options.limit` members are drawn. Members that sets drawn later hide wholly drop out: what is
/// returned is found in a picture of identities, in the order of drawing. `gain` per occludee.
std::vector<std::uint32_t> select_members(const OccluderStack& stack, std::vector<GroupedSet> sets,
                                          std::span<const double> gain, const MosOptions& options);

/// A z-buffer of identities.
class IdPicture {
  public:
    explicit IdPicture(const OccluderStack& stack)
        : stack_(stack), owner_(stack.pixels(), kNobody), nearness_(stack.pixels(), -1), pixels_(stack.members(), 0) {}
    void draw(std::uint32_t member);
    /// Pixels in which the member is the nearest drawn.
    std::uint32_t pixels(std::uint32_t member) const { return pixels_[member]; }
    std::uint32_t visible() const { return visible_; } ///< members with a pixel

  private:
    static constexpr std::uint32_t kNobody = 0xFFFFFFFFu;
    const OccluderStack& stack_;
    std::vector<std::uint32_t> owner_;
    std::vector<float> nearness_;
    std::vector<std::uint32_t> pixels_;
    std::uint32_t visible_ = 0;
};

} // namespace antumbra
