// Occluders per place and direction, found in preprocessing (Coorg, Teller 1997, "dynamic occluder selection"): each cell of
// space knows, for a number of viewing directions, the polygons of the largest area-angle
//     - area (normal . direction) / |centre - viewpoint|^2
// summed over sample viewpoints in it.
#pragma once

#include "base/bytes.hpp"
#include "occluders/choose.hpp"
#include "occluders/space_cells.hpp"

#include <antumbra/occluders.hpp>

#include <array>
#include <functional>

namespace antumbra {

struct OccluderSetsOptions {
    std::uint32_t per_set = 32;
    std::uint32_t most_corners = 8;
    std::uint32_t viewpoints = 4;     ///< of one cell
    std::uint32_t candidates = 768;   ///< polygons that are looked at from one viewpoint: those of the largest area / distance^2
    /// Single-sided polygons count when they turn this side to the cell.
    enum class Shown : std::uint8_t { fronts, backs };
    Shown shown = Shown::fronts;
    /// What the best are: area times cosine over squared distance, or the same without the cosine.
    enum class Measure : std::uint8_t { area_angle, projected_size };
    Measure measure = Measure::area_angle;
    /// In which order a set lists them. Sets by number can be stored as changes from cell to cell.
    enum class Order : std::uint8_t { best_first, by_number };
    Order order = Order::best_first;
    /// What the cells see, where that is known: whether objects count in cell `leaf`. Called from several threads.
    std::function<bool(std::uint32_t leaf, std::uint32_t object)> is_seen;
};

class OccluderSetMaker;

class OccluderSets {
  public:
    static constexpr std::size_t kDirections = 14; ///< along the axes and the diagonals

    /// O(leaves * viewpoints * candidates log n). A pure function of its arguments.
    static OccluderSets build(const OccluderSet& set, const SpaceCells& cells, const OccluderSetsOptions& options);

    /// Sets of anything, made elsewhere: members[leaf * kDirections + direction].
    static OccluderSets of_members(const SpaceCells& cells, const std::vector<std::vector<std::uint32_t>>& members);
    static const std::array<Vec3d, kDirections>& directions();

    /// The nearest of directions().
    static std::size_t direction_of(const Vec3d& direction);

    /// The set of the leaf that holds `place` (the nearest one outside of the space) and the direction closest to
    /// `direction`, in the order that it was made in.
    std::span<const std::uint32_t> at(const Vec3d& place, const Vec3d& direction) const;

    std::span<const std::uint32_t> of_leaf(std::size_t leaf, std::size_t direction) const {
        std::size_t set = leaf * kDirections + direction;
        return {polygons_.data() + first_[set], first_[set + 1] - first_[set]};
    }

    bool empty() const { return first_.empty(); }
    /// Of all sets together.
    std::span<const std::uint32_t> members() const { return polygons_; }
    const SpaceCells& cells() const { return cells_; }

    /// One family of chunk OSET of a .pvs file (docs/format.md, section 6), and back from `at`, which moves behind it; and
    /// a family as it was before cells were a tree. ErrorCode::corrupt unless every set holds nothing but numbers below
    /// `items`.
    void encode(ByteWriter& out) const;
    static Result<OccluderSets> decode(std::span<const std::byte> bytes, std::size_t& at, std::size_t items);
    /// The same in fewer bytes, for sets by number (OccluderSetsOptions::Order).
    void encode_changes(ByteWriter& out) const;
    static Result<OccluderSets> decode_changes(std::span<const std::byte> bytes, std::size_t& at, std::size_t items);
    static Result<OccluderSets> decode_grid(std::span<const std::byte> bytes, std::size_t& at, std::size_t items);

  private:
    SpaceCells cells_;
    std::vector<std::uint32_t> first_; ///< per leaf and direction, into polygons_; one more at the end
    std::vector<std::uint32_t> polygons_;
};

/// Makes the sets of single cells, when they are needed. Immutable; `set` must outlive it.
class OccluderSetMaker {
  public:
    /// What a thread works with.
    class Memory {
      public:
        explicit Memory(const OccluderSetMaker& owner);

      private:
        friend class OccluderSetMaker;
        struct Entry {
            std::uint32_t polygon = 0;
            std::array<double, OccluderSets::kDirections> score{};
        };
        OccluderSearch search_;
        std::vector<Entry> entries_;
        std::vector<std::uint32_t> entry_of_; ///< per polygon: its entry, counted from 1; 0: none
    };

    OccluderSetMaker(const OccluderSet& set, const SpaceCells& cells, const OccluderSetsOptions& options);

    /// The kDirections sets of a leaf, as OccluderSets::build() makes them. O(viewpoints * candidates log n), about a millisecond.
    void make(std::uint32_t leaf, Memory& memory, std::span<std::vector<std::uint32_t>> sets) const;

  private:
    void look_from(std::uint32_t leaf, const Vec3d& eye, Memory& memory) const;
    void add(std::uint32_t index, const Vec3d& eye, Memory& memory) const;

    const OccluderSet& set_;
    OccluderSetsOptions options_;
    std::vector<Box3d> boxes_;
    ConvexGroups singles_;
    OccluderTree tree_;
};

} // namespace antumbra
