#include <antumbra/split.hpp>

#include <algorithm>
#include <numeric>

namespace antumbra {
namespace {

constexpr std::uint32_t kUnused = 0xFFFFFFFFu;

/// Cuts `triangles` into parts of at most `most`, appended to `clusters`.
void cut(const Scene& scene, std::span<std::uint32_t> triangles, std::uint32_t most,
         std::vector<std::span<std::uint32_t>>& clusters) {
    if (triangles.size() <= most) {
        std::sort(triangles.begin(), triangles.end());
        clusters.push_back(triangles);
        return;
    }
    auto centre = [&](std::uint32_t t, int axis) { // three times it: a whole number of grid steps, exact
        return scene.vertex(t, 0)[axis] + scene.vertex(t, 1)[axis] + scene.vertex(t, 2)[axis];
    };
    Box3d centres;
    for (std::uint32_t t : triangles)
        centres.extend(Vec3d{centre(t, 0), centre(t, 1), centre(t, 2)});
    int axis = 0;
    for (int k = 1; k < 3; ++k)
        if (centres.size()[k] > centres.size()[axis])
            axis = k;
    auto half = triangles.begin() + std::ptrdiff_t(triangles.size() / 2);
    std::nth_element(triangles.begin(), half, triangles.end(), [&](std::uint32_t a, std::uint32_t b) {
        double x = centre(a, axis), y = centre(b, axis);
        return x != y ? x < y : a < b;
    });
    auto first = std::size_t(half - triangles.begin());
    cut(scene, triangles.first(first), most, clusters);
    cut(scene, triangles.subspan(first), most, clusters);
}

/// Appends an object of these triangles, whose vertices are renumbered in order of first use.
void add_object(const Scene& scene, RawObject object, std::span<const std::uint32_t> triangles,
                std::vector<std::uint32_t>& number, RawScene& raw) {
    object.id = {std::int32_t(raw.objects.size()), 0, -1};
    object.first_triangle = std::uint32_t(raw.triangles.size());
    object.triangle_count = std::uint32_t(triangles.size());
    for (std::uint32_t t : triangles) {
        TriangleIndices corners = scene.triangles()[t];
        for (std::uint32_t& corner : corners) {
            if (number[corner] == kUnused) {
                number[corner] = std::uint32_t(raw.positions.size());
                raw.positions.push_back(scene.to_world(to_double(scene.positions()[corner])));
            }
            corner = number[corner];
        }
        raw.triangles.push_back(corners);
    }
    for (std::uint32_t t : triangles)
        for (std::uint32_t corner : scene.triangles()[t])
            number[corner] = kUnused; // objects share no vertices
    raw.objects.push_back(std::move(object));
}

} // namespace

RawScene split_scene(const Scene& scene, const SplitOptions& options, SplitStatistics* statistics) {
    RawScene raw;
    raw.source = "split " + scene.source();
    std::vector<std::uint32_t> number(scene.positions().size(), kUnused), triangles;
    SplitStatistics counted;
    for (std::uint32_t o = 0; o < scene.objects().size(); ++o) {
        const Object& object = scene.objects()[o];
        triangles.resize(object.triangle_count);
        std::iota(triangles.begin(), triangles.end(), object.first_triangle);
        RawObject made;
        made.name = std::string(scene.name(o));
        made.flags = object.flags;
        bool whole = object.has(kAlwaysVisible) || object.has(kMoves) ||
                     triangles.size() <= std::max(1u, options.most_triangles);
        if (whole) {
            add_object(scene, made, triangles, number, raw);
            continue;
        }
        std::vector<std::span<std::uint32_t>> clusters;
        cut(scene, triangles, std::max(1u, options.most_triangles), clusters);
        ++counted.objects_cut;
        counted.clusters += std::uint32_t(clusters.size());
        for (std::size_t k = 0; k < clusters.size(); ++k) {
            made.name = std::string(scene.name(o)) + "/cluster " + std::to_string(k + 1);
            add_object(scene, made, clusters[k], number, raw);
        }
    }
    if (statistics)
        *statistics = counted;
    return raw;
}

} // namespace antumbra
