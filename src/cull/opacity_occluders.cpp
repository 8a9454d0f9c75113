#include "cull/opacity_occluders.hpp"

#include <algorithm>

namespace antumbra {
namespace {

constexpr std::uint32_t kStepsPerFrame = 64;   ///< nodes of the occluder tree that a frame opens
constexpr std::uint32_t kStepsAtOnce = 4096;   ///< at first and after a jump
constexpr double kJump = 0.02, kStep = 0.002;  ///< of the scene's size; who moves less keeps what was found
constexpr std::uint32_t kNoPatch = 0xFFFFFFFFu;

/// Area-angle (Coorg, Teller 1997) of one polygon, the projected size but for a constant. 0: shows no side that blocks.
double area_angle(const OccluderPolygon& polygon, const Camera& camera) {
    double towards, squared;
    if (camera.orthographic) {
        towards = -dot(polygon.normal, camera.forward);
        squared = 1;
    } else {
        Vec3d sight = polygon.centre - camera.eye;
        squared = dot(sight, sight) + 0.05 * polygon.area;
        towards = (dot(polygon.normal, camera.eye) + polygon.offset) / std::sqrt(squared);
    }
    if (towards < 0)
        towards = polygon.double_sided ? -towards : 0;
    return polygon.area * towards / squared;
}

template <class Corner>
bool is_in_view(const FrustumPlanes& planes, std::size_t count, Corner corner) {
    for (int i = 0; i < planes.count; ++i) {
        bool inside = false;
        for (std::size_t c = 0; c < count && !inside; ++c) {
            const Vec3f p = corner(c);
            inside = planes.normal[i][0] * p.x + planes.normal[i][1] * p.y + planes.normal[i][2] * p.z +
                         planes.offset[i] >= 0;
        }
        if (!inside)
            return false;
    }
    return true;
}

} // namespace

OpacityOccluders::OpacityOccluders(const CullScene::Data& scene, OccluderChoice choice, const Pvs* pvs)
    : choice_(choice), pvs_(pvs), layout_(scene.occluders), taken_at_(scene.occluders.polygons.size(), 0),
      patch_of_(scene.occluders.polygons.size(), kNoPatch) {
    if (!scene.tree_box.empty())
        size_ = length(to_double(scene.tree_box.max) - to_double(scene.tree_box.min));
}

void OpacityOccluders::choose(const CullScene::Data& scene, const OccluderDatabase* database, const Camera& camera,
                              const FrustumPlanes& planes, std::uint32_t most) {
    chosen_.clear();
    most_ = most;
    camera_ = camera;
    start_ = near_box(camera);
    start_.extend(camera.eye);
    if (++round_ == 0) { // once in four thousand million frames
        std::fill(taken_at_.begin(), taken_at_.end(), 0);
        round_ = 1;
    }
    interest_.look(scene, choice_, pvs_, camera);
    if (database)
        choose_from(scene, *database, camera, planes);
    else if (!interest_.first_hits().empty())
        take_groups(scene, interest_.first_hits(), planes);
    else
        choose_by_promise(scene, camera, planes);
}

/// True if it was taken.
bool OpacityOccluders::take(const CullScene::Data& scene, std::uint32_t index, const FrustumPlanes& planes) {
    const OccluderPolygon& polygon = scene.occluders.polygons[index];
    if (taken_at_[index] == round_ || !(area_angle(polygon, camera_) > 0) || !interest_.is_seen(polygon))
        return false;
    if (polygon.synthetic && !scene.occluders.solids[polygon.solid].serves(start_))
        return false;
    std::span<const std::uint32_t> loop = scene.occluders.loop(polygon);
    if (!is_in_view(planes, loop.size(), [&](std::size_t c) { return scene.occluders.vertices[loop[c]]; }))
        return false;
    taken_at_[index] = round_;
    chosen_.push_back(index);
    return true;
}

/// Of a whole group: what its polygons that show a side that blocks promise together.
double OpacityOccluders::promise(const CullScene::Data& scene, std::uint32_t group) const {
    const ConvexGroups::Group& candidate = scene.groups.groups[group];
    double sum = 0;
    for (std::uint32_t m = candidate.first; m < candidate.first + candidate.count; ++m)
        if (const OccluderPolygon& polygon = scene.occluders.polygons[scene.groups.members[m]]; interest_.is_seen(polygon))
            sum += area_angle(polygon, camera_);
    if (choice_ == OccluderChoice::projected_size && !camera_.orthographic && sum > 0)
        return double(area_angle_bound(static_cast<float>(candidate.area), candidate.box,
                                       Vec3f{float(camera_.eye.x), float(camera_.eye.y), float(camera_.eye.z)}));
    return sum;
}

void OpacityOccluders::choose_by_promise(const CullScene::Data& scene, const Camera& camera, const FrustumPlanes& planes) {
    auto score_of = [&](std::uint32_t group) { return promise(scene, group); };
    double moved = length(camera.eye - searched_from_);
    bool search_all = !searched_ || !(moved <= kJump * size_);
    if (search_all || (moved > kStep * size_ && !search_.running())) {
        search_.begin(scene.occluder_tree, camera.eye, 2 * most_);
        searched_from_ = camera.eye;
        searched_ = true;
    }
    partial_ = search_all || (partial_ && search_.running());
    if (search_.running())
        search_.advance(scene.occluder_tree, search_all ? kStepsAtOnce : partial_ ? 8 * kStepsPerFrame : kStepsPerFrame,
                        score_of);
    take_groups(scene, partial_ ? search_.found_so_far() : search_.found(), planes);
}

void OpacityOccluders::take_groups(const CullScene::Data& scene, std::span<const std::uint32_t> groups,
                                   const FrustumPlanes& planes) {
    for (std::uint32_t group : groups) {
        const ConvexGroups::Group& g = scene.groups.groups[group];
        if (!is_in_view(g.box, planes))
            continue;
        for (std::uint32_t m = g.first; m < g.first + g.count; ++m) {
            if (chosen_.size() >= most_)
                return;
            take(scene, scene.groups.members[m], planes);
        }
    }
}

void OpacityOccluders::choose_from(const CullScene::Data& scene, const OccluderDatabase& database,
                                   const Camera& camera, const FrustumPlanes& planes) {
    std::span<const std::uint32_t> lists[OccluderDatabase::kDirections];
    std::size_t point = database.nearest(camera.eye), longest = 0;
    for (std::uint32_t d = 0; d < OccluderDatabase::kDirections; ++d) {
        lists[d] = database.list(point, d);
        longest = std::max(longest, lists[d].size());
    }
    // What a list holds in vain (it looks elsewhere) take() leaves out.
    for (std::size_t rank = 0; rank < longest; ++rank)
        for (const std::span<const std::uint32_t>& list : lists) {
            if (chosen_.size() >= most_)
                return;
            if (rank < list.size())
                take(scene, list[rank], planes);
        }
}

const PatchStore& OpacityOccluders::patches(const OccluderSet& set) {
    if (chosen_ == laid_out_)
        return store_;
    laid_out_ = chosen_;
    store_.x.clear(), store_.y.clear(), store_.z.clear();
    store_.polygons.clear();
    store_.corners.clear();
    store_.neighbours.clear();
    store_.patches.clear();
    join(set);
    return store_;
}

void OpacityOccluders::join(const OccluderSet& set) {
    for (std::uint32_t polygon : chosen_)
        patch_of_[polygon] = kNoPatch;
    auto for_neighbours = [&](std::uint32_t polygon, auto&& visit) {
        const OccluderPolygon& p = set.polygons[polygon];
        for (std::uint32_t i = 0; i < p.count; ++i)
            if (std::uint32_t n = set.neighbours[p.first + i] & ~kSameDirection;
                n != kNoPolygon && taken_at_[n] == round_)
                visit(n);
    };
    std::uint32_t patch = 0;
    for (std::uint32_t seed : chosen_) {
        if (patch_of_[seed] != kNoPatch)
            continue;
        members_.assign(1, seed);
        patch_of_[seed] = patch;
        for (std::size_t at = 0; at < members_.size(); ++at)
            for_neighbours(members_[at], [&](std::uint32_t n) {
                if (patch_of_[n] == kNoPatch && members_.size() < kMostMembers) {
                    patch_of_[n] = patch;
                    members_.push_back(n);
                }
            });
        for (std::size_t at = 0, core = members_.size(); at < core; ++at)
            for_neighbours(members_[at], [&](std::uint32_t n) {
                if (patch_of_[n] != patch &&
                    std::find(members_.begin() + std::ptrdiff_t(core), members_.end(), n) == members_.end())
                    members_.push_back(n);
            });
        layout_.add(set, members_, store_);
        ++patch;
    }
}

} // namespace antumbra
