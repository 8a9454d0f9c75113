#include "bake/box_cells.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace antumbra {
namespace {

constexpr std::size_t kMostBoxes = 1 << 16;
/// From this depth on, cuts that balance are preferred to cuts that spare boxes.
constexpr std::size_t kDeep = 100;

struct Cut {
    int axis = -1;
    std::uint32_t step = 0;
    std::size_t boxes_cut = 0, larger_side = 0;
};

class Builder {
  public:
    explicit Builder(BoxCells& cells) : cells_(cells) {}

    /// Adds the node of `region` and all below it. `boxes`: clipped to it, none empty. False: too deep.
    bool grow(const ViewRegion& region, const std::vector<ViewRegion>& boxes, std::size_t depth) {
        std::size_t index = cells_.tree.nodes.size();
        cells_.tree.nodes.push_back({ViewNode::kLeaf, 0, kCellNotBaked});
        if (boxes.empty())
            return true;
        Cut cut = choose(region, boxes, depth);
        if (cut.axis < 0) { // every box is the whole region
            cells_.tree.nodes[index].link = std::uint32_t(cells_.regions.size());
            cells_.regions.push_back(region);
            return true;
        }
        if (depth == ViewTree::kMostDepth)
            return false;
        auto axis = std::size_t(cut.axis);
        for (bool above : {false, true}) {
            auto half = [&](ViewRegion box) {
                (above ? box.low : box.high)[axis] =
                    above ? std::max(box.low[axis], cut.step) : std::min(box.high[axis], cut.step);
                return box;
            };
            std::vector<ViewRegion> inside;
            for (const ViewRegion& box : boxes)
                if (above ? box.high[axis] > cut.step : box.low[axis] < cut.step)
                    inside.push_back(half(box));
            if (above)
                cells_.tree.nodes[index] = {std::uint8_t(axis), std::uint16_t(cut.step),
                                            std::uint32_t(cells_.tree.nodes.size())};
            if (!grow(half(region), inside, depth + 1))
                return false;
        }
        return true;
    }

  private:
    /// The face of a box, inside the region, that cuts the fewest boxes, then balances best.
    static Cut choose(const ViewRegion& region, const std::vector<ViewRegion>& boxes, std::size_t depth) {
        Cut best;
        std::vector<std::uint32_t> lows, highs, faces;
        for (std::size_t k = 0; k < 3; ++k) {
            lows.clear();
            highs.clear();
            for (const ViewRegion& box : boxes) {
                lows.push_back(box.low[k]);
                highs.push_back(box.high[k]);
            }
            std::sort(lows.begin(), lows.end());
            std::sort(highs.begin(), highs.end());
            faces = lows;
            faces.insert(faces.end(), highs.begin(), highs.end());
            for (std::uint32_t step : faces) {
                if (step <= region.low[k] || step >= region.high[k])
                    continue;
                auto below = std::size_t(std::lower_bound(lows.begin(), lows.end(), step) - lows.begin());
                auto above = std::size_t(highs.end() - std::upper_bound(highs.begin(), highs.end(), step));
                Cut cut{int(k), step, below + above - boxes.size(), std::max(below, above)};
                auto cost = [&](const Cut& c) {
                    return depth < kDeep ? std::pair(c.boxes_cut, c.larger_side) : std::pair(c.larger_side, c.boxes_cut);
                };
                if (best.axis < 0 || cost(cut) < cost(best))
                    best = cut;
            }
        }
        return best;
    }

    BoxCells& cells_;
};

} // namespace

Result<BoxCells> lay_box_cells(const Scene& scene, std::span<const Box3d> boxes) {
    if (boxes.empty())
        return Status(ErrorCode::usage, "cells that are boxes need boxes: --where boxes.json, or a camera path");
    if (boxes.size() > kMostBoxes)
        return Status(ErrorCode::limit, "more than 2^16 boxes of viewpoints; use a grid of cells");
    double step = scene.step();
    auto steps = [&](double local) { return std::floor(local / step + 0.5); };
    Vec3d low, high;
    for (const Box3d& box : boxes) {
        if (!is_finite(box.min) || !is_finite(box.max) || box.empty())
            return Status(ErrorCode::usage, "a box of viewpoints is empty or not finite; min must not exceed max");
        Vec3d a = scene.to_local(box.min), b = scene.to_local(box.max);
        for (int k = 0; k < 3; ++k) {
            low[k] = &box == boxes.data() ? steps(a[k]) : std::min(low[k], steps(a[k]));
            high[k] = &box == boxes.data() ? steps(b[k]) : std::max(high[k], steps(b[k]));
        }
    }
    double spacing[3]; // of the places, in steps of the scene
    BoxCells cells;
    for (int k = 0; k < 3; ++k) {
        spacing[k] = std::max(1.0, std::ceil((high[k] - low[k]) / double(kViewSteps)));
        cells.tree.bounds.min[k] = low[k] * step + scene.origin()[k];
        cells.tree.bounds.max[k] = (low[k] + spacing[k] * double(kViewSteps)) * step + scene.origin()[k];
    }
    std::vector<ViewRegion> regions;
    for (const Box3d& box : boxes) {
        Vec3d a = scene.to_local(box.min), b = scene.to_local(box.max);
        ViewRegion region;
        for (int k = 0; k < 3; ++k) {
            auto place = [&](double at) { return std::uint32_t(std::floor((steps(at) - low[k]) / spacing[k] + 0.5)); };
            auto axis = std::size_t(k);
            region.low[axis] = std::min(place(a[k]), kViewSteps - 1);
            region.high[axis] = std::max(std::min(place(b[k]), kViewSteps), region.low[axis] + 1);
        }
        regions.push_back(region);
    }
    if (!Builder(cells).grow(ViewRegion(), regions, 0))
        return Status(ErrorCode::limit, "the boxes of viewpoints need a tree of more than 255 levels; use fewer, or a grid");
    return cells;
}

std::uint64_t name_of(const ViewTree& tree) {
    std::uint64_t hash = 0xcbf29ce484222325u; // FNV-1a over words
    auto add = [&](std::uint64_t word) { hash = (hash ^ word) * 0x100000001b3u; };
    for (int k = 0; k < 3; ++k) {
        add(std::bit_cast<std::uint64_t>(tree.bounds.min[k]));
        add(std::bit_cast<std::uint64_t>(tree.bounds.max[k]));
    }
    for (const ViewNode& node : tree.nodes)
        add(std::uint64_t(node.axis) | std::uint64_t(node.split) << 8 | std::uint64_t(node.link) << 32);
    return hash;
}

} // namespace antumbra
