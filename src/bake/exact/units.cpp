#include "bake/exact/units.hpp"

#include <algorithm>

namespace antumbra::exact {
namespace {

double half_area(const Box3f& box) {
    Vec3d d = to_double(box).size();
    return d.x * d.y + d.y * d.z + d.z * d.x;
}

Box3f box_of(const Scene& scene, std::uint32_t triangle) {
    Box3f box;
    for (std::uint32_t corner : scene.triangles()[triangle])
        box.extend(scene.positions()[corner]);
    return box;
}

/// Cuts [first, last) until no part has more than `most` triangles; appends where parts begin.
void cut(const std::vector<Box3f>& boxes, std::uint32_t first, std::uint32_t last, std::uint32_t most,
         std::vector<std::uint32_t>& begins) {
    struct Range {
        std::uint32_t first, last;
    };
    std::vector<Range> open = {{first, last}};
    std::vector<double> right;
    while (!open.empty()) {
        Range range = open.back();
        open.pop_back();
        std::uint32_t n = range.last - range.first;
        if (n <= most) {
            begins.push_back(range.first);
            continue;
        }
        right.assign(n + 1, 0);
        Box3f box;
        for (std::uint32_t i = n; i > 0; --i) {
            box.extend(boxes[range.first + i - 1]);
            right[i - 1] = half_area(box) * (n - i + 1);
        }
        // A cut close to an end would make slivers of the tree: keep at least an eighth on either side.
        std::uint32_t least = std::max(1u, n / 8), best = n / 2;
        double best_cost = 0;
        box = {};
        for (std::uint32_t i = 1; i < n; ++i) {
            box.extend(boxes[range.first + i - 1]);
            double cost = half_area(box) * i + right[i];
            if (i >= least && i <= n - least && (best_cost == 0 || cost < best_cost)) {
                best = i;
                best_cost = cost;
            }
        }
        open.push_back({range.first + best, range.last}); // the lower part comes off first
        open.push_back({range.first, range.first + best});
    }
}

Units from_begins(const Scene& scene, std::vector<std::uint32_t> begins) {
    Units units;
    auto count = static_cast<std::uint32_t>(scene.triangles().size());
    begins.push_back(count);
    units.first = std::move(begins);
    units.of.resize(count);
    for (std::uint32_t u = 0; u < units.count(); ++u)
        std::fill(units.of.begin() + units.first[u], units.of.begin() + units.first[u + 1], u);
    return units;
}

} // namespace

Units Units::objects(const Scene& scene) {
    std::vector<std::uint32_t> begins;
    std::uint32_t next = 0;
    for (const Object& object : scene.objects()) {
        begins.push_back(next); // objects without triangles name a range that is empty
        next += object.triangle_count;
    }
    return from_begins(scene, std::move(begins));
}

Units Units::triangles(const Scene& scene) {
    std::vector<std::uint32_t> begins(scene.triangles().size());
    for (std::uint32_t t = 0; t < begins.size(); ++t)
        begins[t] = t;
    return from_begins(scene, std::move(begins));
}

Units Units::clusters(const Scene& scene, std::uint32_t most) {
    std::vector<Box3f> boxes(scene.triangles().size());
    for (std::uint32_t t = 0; t < boxes.size(); ++t)
        boxes[t] = box_of(scene, t);
    std::vector<std::uint32_t> begins;
    for (const Object& object : scene.objects())
        if (object.triangle_count > 0)
            cut(boxes, object.first_triangle, object.first_triangle + object.triangle_count, std::max(1u, most), begins);
    return from_begins(scene, std::move(begins));
}

Units Units::ranges(const Scene& scene, std::vector<std::uint32_t> first) { return from_begins(scene, std::move(first)); }

Units Units::make(const Scene& scene, Granularity granularity, std::uint32_t most) {
    switch (granularity) {
    case Granularity::triangle:
        return triangles(scene);
    case Granularity::cluster:
        return clusters(scene, most);
    case Granularity::object:
        break;
    }
    return objects(scene);
}

} // namespace antumbra::exact
