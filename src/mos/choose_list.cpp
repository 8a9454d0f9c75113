#include "mos/choose_list.hpp"

#include "tree/bvh.hpp"

#include <algorithm>
#include <map>
#include <numeric>

namespace antumbra {
namespace {

/// What occludees hide behind: every set found for any of them, equal ones once.
class SetFinder {
  public:
    SetFinder(const OccluderStack& stack, const MosOptions& options, MosStatistics& statistics)
        : stack_(stack), options_(options), statistics_(statistics) {}

    void add(std::uint32_t occludee, const PixelRect& rect, float nearness) {
        ++statistics_.occludees;
        if (!stack_.lists_of(rect, nearness, table_, members_)) {
            ++statistics_.uncovered;
            return;
        }
        costs_.clear();
        for (std::uint32_t member : members_)
            costs_.push_back(options_.polygon_weight + options_.size_weight * double(stack_.fragments(member).size()) /
                                                           double(stack_.pixels()));
        MinimumSets found =
            find_minimum_sets(table_, costs_, options_.sets_per_occludee, options_.work_per_occludee);
        statistics_.searches_cut += !found.complete;
        for (const MinimumSet& set : found.sets)
            take(occludee, rect, nearness, set);
    }

    std::vector<GroupedSet> grouped() {
        std::vector<GroupedSet> sets;
        for (auto& [members, occludees] : sets_)
            sets.push_back({members, std::move(occludees), 0});
        return sets;
    }

  private:
    /// Only what is a cover, and minimal, by the definition.
    void take(std::uint32_t occludee, const PixelRect& rect, float nearness, const MinimumSet& set) {
        std::vector<std::uint32_t> members;
        for (std::uint32_t item : set.items)
            members.push_back(members_[item]);
        std::sort(members.begin(), members.end());
        if (!is_minimum_set(table_, set.items) || !stack_.is_cover(rect, nearness, members))
            return;
        ++statistics_.sets;
        std::vector<std::uint32_t>& occludees = sets_[std::move(members)];
        if (occludees.empty() || occludees.back() != occludee)
            occludees.push_back(occludee);
    }

    const OccluderStack& stack_;
    const MosOptions& options_;
    MosStatistics& statistics_;
    ItemTable table_;
    std::vector<std::uint32_t> members_;
    std::vector<double> costs_;
    std::map<std::vector<std::uint32_t>, std::vector<std::uint32_t>> sets_; ///< in an order of its own
};

std::vector<std::uint32_t> minimum_sets_list(const OccluderStack& stack, std::span<const Occludee> occludees,
                                             const Screen& screen, const MosOptions& options,
                                             MosStatistics& statistics) {
    SetFinder finder(stack, options, statistics);
    std::vector<double> gain;
    for (const Occludee& occludee : occludees) {
        BoxOnScreen box = project_box(screen, occludee.box);
        PixelRect rect = pixel_rect(screen, box);
        if (rect.empty())
            continue;
        finder.add(static_cast<std::uint32_t>(gain.size()), rect, box.nearness);
        gain.push_back(options.occludee_weight + options.primitive_weight * occludee.primitives);
    }
    return select_members(stack, finder.grouped(), gain, options);
}

/// Largest first; equal ones in the order of the set.
std::vector<std::uint32_t> largest(const OccluderStack& stack, std::span<const std::uint32_t> pixels,
                                   std::uint32_t limit) {
    std::vector<std::uint32_t> order;
    for (std::uint32_t member = 0; member < stack.members(); ++member)
        if (pixels[member] > 0)
            order.push_back(member);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return pixels[a] > pixels[b]; });
    order.resize(std::min<std::size_t>(order.size(), limit));
    return order;
}

std::vector<std::uint32_t> largest_list(const OccluderStack& stack, const MosOptions& options) {
    std::vector<std::uint32_t> pixels(stack.members(), 0);
    if (options.criterion == OccluderCriterion::projected_size) {
        for (std::uint32_t member = 0; member < stack.members(); ++member)
            pixels[member] = static_cast<std::uint32_t>(stack.fragments(member).size());
    } else {
        for (std::size_t pixel = 0; pixel < stack.pixels(); ++pixel)
            if (!stack.stack(pixel).empty())
                ++pixels[stack.stack(pixel)[0].member];
    }
    return largest(stack, pixels, options.limit);
}

} // namespace

std::vector<Occludee> find_occludees(const Scene& scene, const MosOptions& options) {
    std::vector<Box3f> boxes;
    std::vector<std::uint32_t> triangles;
    for (const Object& object : scene.objects())
        if (!object.has(kAlwaysVisible) && object.triangle_count > 0) {
            boxes.push_back(object.bounds);
            triangles.push_back(object.triangle_count);
        }
    std::vector<Occludee> occludees;
    if (boxes.empty())
        return occludees;
    BvhOptions leaves;
    leaves.leaf_size = 1;
    Bvh tree = build_bvh(boxes, leaves);
    std::vector<std::uint32_t> below(tree.nodes.size(), 0);
    for (std::size_t n = tree.nodes.size(); n-- > 0;) { // children come after their parents
        const BvhNode& node = tree.nodes[n];
        if (node.leaf())
            for (std::uint32_t i = 0; i < node.count; ++i)
                below[n] += triangles[tree.order[node.first + i]];
        else
            below[n] = below[node.first] + below[node.first + 1];
    }
    std::vector<std::uint32_t> open{0};
    while (!open.empty()) {
        std::uint32_t n = open.back();
        open.pop_back();
        const BvhNode& node = tree.nodes[n];
        if (node.leaf() || below[n] <= options.most_primitives) {
            if (below[n] > options.least_primitives)
                occludees.push_back({node.box, below[n]});
        } else {
            open.push_back(node.first + 1);
            open.push_back(node.first);
        }
    }
    return occludees;
}

std::vector<std::uint32_t> choose_list(const OccluderSet& set, std::span<const Occludee> occludees,
                                       const Screen& screen, const MosOptions& options, MosStatistics* statistics) {
    // The other criteria look at pixels as a renderer draws them.
    bool sets = options.criterion == OccluderCriterion::minimum_sets;
    OccluderStack stack(set, screen, {options.least_pixels, options.layers,
                                      sets ? PixelCoverage::inner : PixelCoverage::centre});
    MosStatistics counts;
    std::vector<std::uint32_t> list = sets
                                          ? minimum_sets_list(stack, occludees, screen, options, counts)
                                          : largest_list(stack, options);
    for (std::uint32_t& member : list)
        member = stack.polygon(member);
    if (statistics) {
        ++statistics->pictures;
        statistics->occludees += counts.occludees;
        statistics->uncovered += counts.uncovered;
        statistics->sets += counts.sets;
        statistics->searches_cut += counts.searches_cut;
    }
    return list;
}

Screen picture_of(const Vec3d& point, std::uint32_t direction, int resolution, double extent) {
    Vec3d forward = OccluderDatabase::direction(direction);
    Camera camera = look_along(point, forward, direction / 2 == 1 ? Vec3d{0, 0, 1} : Vec3d{0, 1, 0});
    return make_screen(camera, resolution, resolution, extent);
}

} // namespace antumbra
