#include "cull/tree_choice.hpp"

#include "cull/shadow.hpp"

#include <algorithm>
#include <bit>
#include <numeric>

namespace antumbra {
namespace {

constexpr std::uint32_t kMostEach = 16;       ///< polygons that an object offers
constexpr std::size_t kMostListed = 1u << 17; ///< the largest polygons of the scene
constexpr std::uint32_t kMostLooked = 4096;   ///< polygons that a frame chooses from, about
constexpr int kMostNodes = 4096;              ///< looked at for the objects that a polygon touches

Vec3f rounded(const Vec3d& v) { return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)}; }

/// Shows a side that blocks, with nothing of it nearer than the near plane, from outside of its solid.
bool is_usable(const OccluderSet& set, const OccluderPolygon& polygon, const SightStart& sight, const Box3d& start) {
    int side = facing(polygon, sight.camera);
    if (side == 0 || !is_beyond_near(polygon, side, sight))
        return false;
    return !polygon.synthetic || set.solids[polygon.solid].serves(start);
}

} // namespace

TreeChoice::Memory::Memory(const TreeChoice& owner, std::uint32_t most) : looked(owner.listed_.size()) {
    chosen.reserve(most);
    candidates.reserve(2 * kMostLooked);
}

TreeChoice TreeChoice::build(const CullScene::Data& scene, const TreeOccluders& occluders) {
    TreeChoice result;
    const OccluderSet& set = scene.occluders;
    std::vector<std::uint32_t> usable, room(scene.object_count(), kMostEach);
    for (std::uint32_t p = 0; p < set.polygons.size(); ++p)
        if (occluders.polygons[p].usable)
            usable.push_back(p);
    std::sort(usable.begin(), usable.end(), [&](std::uint32_t a, std::uint32_t b) {
        return set.polygons[a].area != set.polygons[b].area ? set.polygons[a].area > set.polygons[b].area : a < b;
    });
    usable.resize(std::min(usable.size(), kMostListed));
    std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs; // object, place in the list
    std::vector<std::uint32_t> stack;
    for (std::uint32_t p : usable) {
        const OccluderPolygon& polygon = set.polygons[p];
        Box3f box;
        for (std::uint32_t v : set.loop(polygon))
            box.extend(set.vertices[v]);
        auto index = static_cast<std::uint32_t>(result.listed_.size());
        result.listed_.push_back({rounded(polygon.centre), rounded(polygon.normal), static_cast<float>(polygon.area), p,
                                  polygon.double_sided, box});
        auto offer = [&](std::uint32_t object) {
            if (object < room.size() && room[object] > 0) {
                --room[object];
                pairs.push_back({object, index});
            }
        };
        // Polygons are merged across objects: its own object is only one of those that it is seen with.
        offer(polygon.object);
        stack.clear();
        if (!scene.wide.empty())
            stack.push_back(0);
        for (int nodes = 0; !stack.empty() && nodes < kMostNodes; ++nodes) {
            const CullNode& node = scene.wide[stack.back()];
            stack.pop_back();
            for (std::uint32_t slot = 0; slot < node.used; ++slot) {
                std::uint32_t child = node.child[slot];
                if (!node.box(static_cast<int>(slot)).overlaps(box))
                    continue;
                if (!(child & kObjectChild))
                    stack.push_back(child);
                else if ((child & ~kObjectChild) != polygon.object)
                    offer(child & ~kObjectChild);
            }
        }
    }
    std::sort(pairs.begin(), pairs.end());
    result.first_polygon_.assign(std::size_t(scene.object_count()) + 1, 0);
    for (auto [object, index] : pairs) {
        ++result.first_polygon_[object + 1];
        result.polygons_.push_back(index);
    }
    std::partial_sum(result.first_polygon_.begin(), result.first_polygon_.end(), result.first_polygon_.begin());
    return result;
}

/// -A (N . V) / |D|^2 with V along the line of sight, less for what is so near that it would outweigh all.
float TreeChoice::promise(const CullScene::Data& scene, const Listed& polygon, const Vec3f& eye, const OccluderInterest& interest) {
    Vec3f sight = polygon.centre - eye;
    float squared = dot(sight, sight) + 0.05f * polygon.area;
    float towards = -dot(polygon.normal, sight);
    if (towards < 0)
        towards = polygon.double_sided ? -towards : 0;
    return static_cast<float>(interest.promise(polygon.polygon, scene.occluders.polygons[polygon.polygon], double(polygon.area),
                                               double(towards / std::sqrt(squared)), double(squared)));
}

void TreeChoice::choose(const CullScene::Data& scene, const Camera& camera, std::span<const std::uint64_t> visible,
                        std::span<const std::uint64_t> hidden, const OccluderInterest& interest, std::uint32_t most,
                        Memory& memory) const {
    std::uint32_t objects = 0;
    for (std::size_t word = 0; word < visible.size(); ++word)
        objects += static_cast<std::uint32_t>(std::popcount(visible[word] & ~hidden[word]));
    std::uint32_t most_each = std::max<std::uint32_t>(2, kMostLooked / std::max<std::uint32_t>(1, objects));
    Vec3f eye = rounded(camera.eye);
    ++memory.choice;
    memory.candidates.clear();
    for (std::size_t word = 0; word < visible.size(); ++word)
        for (std::uint64_t rest = visible[word] & ~hidden[word]; rest; rest &= rest - 1) {
            std::size_t object = word * 64 + static_cast<std::size_t>(std::countr_zero(rest));
            std::uint32_t first = first_polygon_[object], end = std::min(first_polygon_[object + 1], first + most_each);
            for (std::uint32_t i = first; i < end && memory.candidates.size() < memory.candidates.capacity(); ++i) {
                std::uint32_t index = polygons_[i];
                if (memory.looked[index] == memory.choice)
                    continue;
                memory.looked[index] = memory.choice;
                if (float measure = promise(scene, listed_[index], eye, interest); measure > 0)
                    memory.candidates.push_back({-measure, index});
            }
        }
    FrustumPlanes planes = frustum_planes(camera, scene.tree_box);
    SightStart sight = sight_start(camera, scene.tree_box);
    Box3d start = near_box(camera);
    start.extend(camera.eye);
    memory.chosen.clear();
    // Some of the best are out of view or too near: twice as many are looked at.
    std::size_t looked = std::min<std::size_t>(2 * std::size_t(most), memory.candidates.size());
    std::partial_sort(memory.candidates.begin(), memory.candidates.begin() + static_cast<std::ptrdiff_t>(looked),
                      memory.candidates.end());
    for (std::size_t c = 0; c < looked && memory.chosen.size() < most; ++c) {
        const Listed& listed = listed_[memory.candidates[c].second];
        if (is_in_view(listed.box, planes) && is_usable(scene.occluders, scene.occluders.polygons[listed.polygon], sight, start))
            memory.chosen.push_back(listed.polygon);
    }
}

} // namespace antumbra
