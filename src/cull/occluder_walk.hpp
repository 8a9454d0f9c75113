// Which occluder patches the modern form of `opacity` draws in a frame: of all, or of those that a database names, front to
// back, whatever would cover a pixel that is open yet. What is behind covered pixels is never looked at.
#pragma once

#include "cull/box_kernels.hpp"
#include "cull/scene_data.hpp"
#include "raster/opacity_rows.hpp"

#include <antumbra/occluder_database.hpp>

#include <algorithm>

namespace antumbra {

/// Per polygon the patch that owns it; kNoPolygon: none.
std::vector<std::uint32_t> owning_patches(const OccluderSet& set);

/// Best first, by the far ends of the patches' boxes: what is drawn sooner lies in front, and a ground that begins under the
/// eye comes when what stands on it has been drawn. Per view; keeps only memory.
class OccluderWalk {
  public:
    struct Frame {
        const CullScene::Data& scene;
        const Camera& camera;
        const FrustumPlanes& planes;
        const Screen& screen;
        const OccluderImage& image; ///< draw() adds to it
        BoxKernel boxes;
        ProjectEight project;
        float least_pixels; ///< that the box of a patch covers, for each polygon of the patch
    };

    /// Calls draw(patch) for patches of the scene's tree. O(nodes that are large enough and not covered).
    template <class Draw>
    void run(const Frame& frame, Draw&& draw) {
        begin(frame);
        push_root(frame);
        while (!heap_.empty())
            pop(frame, draw);
    }

    /// For the owners of the polygons that the lists name at the grid points around the eye. O(polygons in these lists).
    template <class Draw>
    void run(const Frame& frame, const OccluderDatabase& database, std::span<const std::uint32_t> owners, Draw&& draw) {
        begin(frame);
        push_lists(frame, database, owners);
        while (!heap_.empty())
            pop(frame, draw);
    }

  private:
    struct Item {
        float depth;         ///< of a patch the farthest, of a node the nearest
        std::uint32_t child; ///< as in CullNode
        std::uint32_t planes;
        PixelRect rect;      ///< pixels that the box touches; all of them if it may be anywhere
        bool operator<(const Item& other) const { // the heap has its greatest on top
            return depth != other.depth ? depth > other.depth : child > other.child;
        }
    };

    void begin(const Frame& frame);
    void push_root(const Frame& frame);
    void push_lists(const Frame& frame, const OccluderDatabase& database, std::span<const std::uint32_t> owners);
    void push_eight(const Frame& frame);
    void open(const Frame& frame, std::uint32_t node, std::uint32_t planes);
    void push(const Frame& frame, const float (*min)[kWidth], const float (*max)[kWidth], const EightOnScreen& boxes,
              int lane, std::uint32_t child, std::uint32_t planes);

    template <class Draw>
    void pop(const Frame& frame, Draw&& draw) {
        std::pop_heap(heap_.begin(), heap_.end());
        const Item item = heap_.back();
        heap_.pop_back();
        if (overlaps_by_rows(frame.image, item.rect))
            return;
        if (item.child & kObjectChild)
            draw((item.child & ~kObjectChild) - frame.scene.object_count());
        else
            open(frame, item.child, item.planes);
    }

    std::vector<Item> heap_;
    std::vector<std::uint32_t> met_at_; ///< per patch: the round in which a list named it
    std::uint32_t round_ = 0;
    std::uint32_t eight_[kWidth];
    int pending_ = 0;
    Box3d start_; ///< where lines of sight begin
};

} // namespace antumbra
