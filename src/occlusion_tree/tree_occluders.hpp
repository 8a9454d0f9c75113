// A scene's occluders, prepared for occlusion trees, and the order in which they are put into one.
#pragma once

#include "occlusion_tree/occlusion_tree.hpp"

#include <antumbra/occluders.hpp>

#include <array>

namespace antumbra {

/// Immutable. Polygons that are not exactly flat and convex are left out: they hide nothing.
class TreeOccluders {
  public:
    struct Polygon {
        std::uint32_t first = 0, count = 0; ///< corners, as vertices of the set; no straight ones
        std::uint32_t plane = 0;            ///< polygons in one plane share the number
        bool usable = false, double_sided = false, along_plane = true; ///< shows the front of its plane's number
    };
    /// O(n log n).
    static TreeOccluders build(const OccluderSet& set);

    std::vector<Polygon> polygons; ///< as OccluderSet::polygons
    std::vector<std::uint32_t> corners;
    std::vector<std::array<std::uint32_t, 3>> planes; ///< three vertices each, counter-clockwise seen from its front
    std::vector<Vec3d> vertices;
};

/// Puts chosen occluders into a tree, as seen from its eye. Belongs to one view; takes its memory once.
class TreeBuilder {
  public:
    TreeBuilder(const TreeOccluders& occluders, std::uint32_t most);

    enum class Order : std::uint8_t {
        binary_space_partition, ///< front to back by a BSP of the occluders, which may split them (section 4.1)
        as_given,               ///< any order is right; nearly front to back is fast
    };
    /// `tree` has begun. Polygons whose undrawn side is turned to the eye are passed over. Returns how many were put in.
    std::uint32_t insert(OcclusionTree& tree, std::span<const std::uint32_t> chosen, Order order);

  private:
    struct Item {
        PicturePolygon picture;
        std::uint32_t plane, occluder;
        bool whole; ///< all corners are its own; a part may have corners of others
    };
    bool add_item(OcclusionTree& tree, std::uint32_t occluder);
    bool split(OcclusionTree& tree, std::uint32_t item, std::uint32_t splitter, const signed char* sides);
    void insert_front_to_back(OcclusionTree& tree, std::uint32_t first);
    int place(OcclusionTree& tree, const Item& item, std::uint32_t splitter, signed char* sides) const;
    int rough_place(OcclusionTree& tree, const Item& item, std::uint32_t splitter) const;
    std::uint32_t best_splitter(OcclusionTree& tree, std::uint32_t first);

    const TreeOccluders& occluders_;
    std::uint32_t stamp_ = 0;
    std::vector<std::uint32_t> vertex_stamp_, vertex_point_, plane_stamp_, plane_index_;
    std::vector<Item> items_;            ///< the first `item_count_` are used
    std::size_t item_count_ = 0;
    std::vector<unsigned char> in_front_;
    PicturePolygon part_;
    std::vector<std::uint32_t> segments_; ///< items of the partitions under way
    std::vector<std::uint32_t> loop_;
};

} // namespace antumbra
