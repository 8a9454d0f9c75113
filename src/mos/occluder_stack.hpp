// Which occluders lie in front of what, pixel by pixel, from one viewpoint in one direction.
#pragma once

#include "mos/minimum_sets.hpp"
#include "raster/occluder_image.hpp"
#include "raster/pixel_rect.hpp"

#include <antumbra/occluders.hpp>

namespace antumbra {

/// One occluder polygon in one pixel.
struct Fragment {
    std::uint32_t pixel; ///< y * width + x
    float nearness;
};

struct StackOptions {
    std::uint32_t least_pixels = 4, layers = 48;
    /// `inner`: a polygon is in a pixel's stack if its centre is covered and no silhouette edge crosses its square, and
    /// then with its farthest depth there: what the run time draws, if neighbours that share edges are drawn, too.
    PixelCoverage coverage = PixelCoverage::inner;
};

/// The picture of all occluders: for every pixel the polygons that cover it, nearest first.
class OccluderStack {
  public:
    /// Polygons that show `screen`'s eye no side that blocks, reach no pixel, or belong to a solid around the eye are
    /// not there. O(polygons + fragments).
    OccluderStack(const OccluderSet& set, const Screen& screen, const StackOptions& options);

    int width() const { return width_; }
    std::size_t pixels() const { return first_.size() - 1; }

    /// Members are the polygons of the picture, numbered from 0 in the order of the set.
    std::size_t members() const { return polygon_.size(); }
    std::uint32_t polygon(std::uint32_t member) const { return polygon_[member]; }
    std::span<const Fragment> fragments(std::uint32_t member) const {
        return {fragments_.data() + first_fragment_[member], first_fragment_[member + 1] - first_fragment_[member]};
    }

    struct Layer {
        std::uint32_t member;
        float nearness;
    };
    /// Nearest first, at most options.layers.
    std::span<const Layer> stack(std::size_t pixel) const {
        return {layers_.data() + first_[pixel], first_[pixel + 1] - first_[pixel]};
    }
    /// Number of layers of the pixel that are nearer than `nearness`.
    std::size_t in_front(std::size_t pixel, float nearness) const;

    /// The distinct lists of what is in front of an occludee, over the pixels of its rectangle. `members` receives which
    /// member each item of the table is. False, early, if some pixel has nothing in front.
    bool lists_of(const PixelRect& rect, float nearness, ItemTable& table, std::vector<std::uint32_t>& members) const;

    /// Is there a member of `cover` (ascending) in front at every pixel? Looks at every stack anew.
    bool is_cover(const PixelRect& rect, float nearness, std::span<const std::uint32_t> cover) const;

  private:
    void add_polygon(const OccluderSet& set, std::uint32_t index, const Screen& screen, const StackOptions& options);
    void sort_layers(std::size_t pixels, std::uint32_t most);

    int width_ = 0;
    std::vector<std::uint32_t> polygon_, first_fragment_{0};
    std::vector<Fragment> fragments_;
    std::vector<std::uint32_t> first_; ///< per pixel, into layers_
    std::vector<Layer> layers_;
    std::vector<std::uint64_t> prefix_; ///< parallel to layers_: a hash of the set of members up to there
};

} // namespace antumbra
