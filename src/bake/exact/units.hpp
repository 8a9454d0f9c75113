// What a bake lists: objects, clusters of them, or single triangles.
#pragma once

#include <antumbra/bake.hpp>
#include <antumbra/scene.hpp>

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace antumbra::exact {

/// A partition of the scene's triangles into units, each some triangles of one object. Units of one object follow each
/// other, in the order of objects.
struct Units {
    std::vector<std::uint32_t> first; ///< per unit: where its triangles begin in `order`; and their number at the end
    std::vector<std::uint32_t> order; ///< triangles by unit, ascending within each; each object's stay in its own range
    std::vector<std::uint32_t> of;    ///< per triangle: its unit

    std::uint32_t count() const { return static_cast<std::uint32_t>(first.size()) - 1; }
    std::span<const std::uint32_t> triangles_of(std::uint32_t unit) const {
        return std::span(order).subspan(first[unit], first[unit + 1] - first[unit]);
    }
    /// The units of an object that has triangles: from the first to the last.
    std::pair<std::uint32_t, std::uint32_t> range_of(const Object& object) const {
        return {of[order[object.first_triangle]], of[order[object.first_triangle + object.triangle_count - 1]]};
    }
    /// Per object: equal to its index, also where an object has no triangle left.
    static Units objects(const Scene& scene);
    static Units triangles(const Scene& scene);
    /// Objects of more than `most` triangles are cut again and again in two, until no part has more: at the place along an
    /// axis of space or of normals, or along the order of the file (or along that alone), where the sum over both of triangles times half area times
    /// the share of directions that see some front is least. O(n log^2 n).
    static Units clusters(const Scene& scene, std::uint32_t most, ClusterOrder order);
    /// From the unit of each triangle. Every unit up to the greatest must have a triangle, and units must follow each other
    /// as the objects do.
    static Units from_numbers(std::vector<std::uint32_t> of);
    static Units make(const Scene& scene, const ExactOptions& options);
};

} // namespace antumbra::exact
