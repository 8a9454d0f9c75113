#include "cull/occluder_walk.hpp"

#include "cull/view_planes.hpp"

namespace antumbra {
namespace {

/// Points of a database whose lists are used: the nearest, and along each axis the next beyond the eye.
struct PointsAround {
    std::size_t point[4];
    std::size_t count = 1;
};

PointsAround points_around(const OccluderDatabase& database, const Vec3d& eye) {
    PointsAround points;
    points.point[0] = database.nearest(eye);
    std::size_t stride = 1, nearest = points.point[0];
    for (int axis = 0; axis < 3; ++axis) {
        const std::size_t count = database.count[static_cast<std::size_t>(axis)], along = nearest / stride % count;
        const double beyond = eye[axis] - database.point(nearest)[axis];
        if (beyond > 0 && along + 1 < count)
            points.point[points.count++] = nearest + stride;
        else if (beyond < 0 && along > 0)
            points.point[points.count++] = nearest - stride;
        stride *= count;
    }
    return points;
}

} // namespace

std::vector<std::uint32_t> owning_patches(const OccluderSet& set) {
    std::vector<std::uint32_t> owners(set.polygons.size(), kNoPolygon);
    for (std::uint32_t patch = 0; patch < set.patches.size(); ++patch)
        for (std::uint32_t i = 0; i < set.patches[patch].core; ++i)
            owners[set.patch_polygons[set.patches[patch].first + i]] = patch;
    return owners;
}

void OccluderWalk::begin(const Frame& frame) {
    heap_.clear();
    start_ = near_box(frame.camera);
    start_.extend(frame.camera.eye);
}

void OccluderWalk::push(const Frame& frame, const float (*min)[kWidth], const float (*max)[kWidth],
                        const EightOnScreen& boxes, int lane, std::uint32_t child, std::uint32_t planes) {
    const ScenePatches& patches = frame.scene.patches;
    const bool leaf = (child & kObjectChild) != 0;
    const std::uint32_t patch = (child & ~kObjectChild) - frame.scene.object_count();
    PixelRect rect{0, 0, frame.screen.width - 1, frame.screen.height - 1};
    const bool testable = (boxes.testable >> lane & 1) != 0;
    if (testable)
        rect = boxes.rect(lane);
    float polygons = leaf ? float(patches.store.patches[patch].polygon_count) : 1;
    if (float(rect.area()) < frame.least_pixels * polygons)
        return;
    float middle = 0, reach = 0; // only an order: it needs no care
    for (int axis = 0; axis < 3; ++axis) {
        float half = (max[axis][lane] - min[axis][lane]) * 0.5f, along = float(frame.camera.forward[axis]);
        middle += along * (min[axis][lane] + half - float(frame.camera.eye[axis]));
        reach += std::abs(along) * half;
    }
    if (!testable && middle - reach > float(frame.screen.clip_depth)) // beside the screen
        return;
    if (leaf && patches.solid[patch] != kNoPolygon &&
        !frame.scene.occluders.solids[patches.solid[patch]].serves(start_))
        return;
    heap_.push_back({leaf ? middle + reach : middle - reach, child, planes, rect});
    std::push_heap(heap_.begin(), heap_.end());
}

void OccluderWalk::push_root(const Frame& frame) {
    if (!frame.scene.patches.tree.empty())
        open(frame, 0, frame.planes.mask());
}

void OccluderWalk::open(const Frame& frame, std::uint32_t index, std::uint32_t planes) {
    const CullNode& node = frame.scene.patches.tree[index];
    BoxVerdicts verdicts;
    EightOnScreen boxes;
    frame.boxes({node.min, node.max}, frame.planes, planes, verdicts);
    std::uint32_t inside = node.mask() & ~verdicts.outside;
    if (!inside)
        return;
    frame.project(frame.screen, node.min, node.max, boxes);
    for (; inside; inside &= inside - 1) {
        int lane = std::countr_zero(inside);
        std::uint32_t child = node.child[lane];
        bool object = (child & kObjectChild) && (child & ~kObjectChild) < frame.scene.object_count();
        if (!object)
            push(frame, node.min, node.max, boxes, lane, child, verdicts.crossing[lane]);
    }
}

void OccluderWalk::push_lists(const Frame& frame, const OccluderDatabase& database,
                              std::span<const std::uint32_t> owners) {
    met_at_.resize(frame.scene.patches.boxes.size(), 0);
    if (++round_ == 0) { // once in four thousand million frames
        std::fill(met_at_.begin(), met_at_.end(), 0);
        round_ = 1;
    }
    const PointsAround points = points_around(database, frame.camera.eye);
    for (std::size_t p = 0; p < points.count; ++p)
        for (std::uint32_t d = 0; d < OccluderDatabase::kDirections; ++d)
            for (std::uint32_t polygon : database.list(points.point[p], d)) {
                std::uint32_t patch = owners[polygon];
                if (patch == kNoPolygon || met_at_[patch] == round_)
                    continue;
                met_at_[patch] = round_;
                eight_[pending_++] = patch;
                if (pending_ == kWidth)
                    push_eight(frame);
            }
    if (pending_ > 0)
        push_eight(frame);
}

void OccluderWalk::push_eight(const Frame& frame) {
    float min[3][kWidth], max[3][kWidth];
    for (int lane = 0; lane < kWidth; ++lane) {
        const Box3f& box = frame.scene.patches.boxes[eight_[lane < pending_ ? lane : 0]];
        for (int axis = 0; axis < 3; ++axis) {
            min[axis][lane] = box.min[axis];
            max[axis][lane] = box.max[axis];
        }
    }
    BoxVerdicts verdicts;
    EightOnScreen boxes;
    frame.boxes({min, max}, frame.planes, frame.planes.mask(), verdicts);
    frame.project(frame.screen, min, max, boxes);
    for (int lane = 0; lane < pending_; ++lane)
        if (!(verdicts.outside >> lane & 1))
            push(frame, min, max, boxes, lane, (eight_[lane] + frame.scene.object_count()) | kObjectChild, 0);
    pending_ = 0;
}

} // namespace antumbra
