// What a bake lists: objects, clusters of them, or single triangles.
#pragma once

#include <antumbra/bake.hpp>
#include <antumbra/scene.hpp>

#include <cstdint>
#include <vector>

namespace antumbra::exact {

/// A partition of the scene's triangles into units, each a range of the triangles of one object, in the order of the
/// scene. Units of one object follow each other, in the order of objects.
struct Units {
    std::vector<std::uint32_t> first; ///< per unit: its first triangle; and the number of triangles at the end
    std::vector<std::uint32_t> of;    ///< per triangle: its unit

    std::uint32_t count() const { return static_cast<std::uint32_t>(first.size()) - 1; }
    /// Per object: equal to its index, also where an object has no triangle left.
    static Units objects(const Scene& scene);
    static Units triangles(const Scene& scene);
    /// Objects of more than `most` triangles are cut into ranges of at most so many, where the sum of half areas times
    /// triangles is least (surface area heuristic along the order of the file). O(n log n).
    static Units clusters(const Scene& scene, std::uint32_t most);
    /// Ranges that begin at these triangles, ascending, the first at 0; each within one object.
    static Units ranges(const Scene& scene, std::vector<std::uint32_t> first);
    static Units make(const Scene& scene, Granularity granularity, std::uint32_t most);
};

} // namespace antumbra::exact
