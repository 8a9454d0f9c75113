// Random occluders, eyes and boxes: in general position, and on small lattices where everything touches.
#pragma once

#include "occlusion_tree/oracle.hpp"
#include "occlusion_tree/tree_occluders.hpp"

#include "base/random.hpp"

namespace antumbra::test {

struct Configuration {
    OccluderSet set;
    Vec3d eye;
    std::vector<Box3d> boxes;
};

inline void add_polygon(OccluderSet& set, const std::vector<Vec3d>& corners, bool double_sided) {
    OccluderPolygon polygon;
    polygon.first = std::uint32_t(set.loops.size());
    polygon.count = std::uint32_t(corners.size());
    polygon.double_sided = double_sided;
    Vec3d normal{};
    for (std::size_t i = 1; i + 1 < corners.size(); ++i)
        normal += antumbra::cross(corners[i] - corners[0], corners[i + 1] - corners[0]);
    polygon.area = length(normal) / 2;
    polygon.normal = normalized(normal);
    polygon.offset = -antumbra::dot(polygon.normal, corners[0]);
    for (const Vec3d& p : corners) {
        Vec3f v{float(p.x), float(p.y), float(p.z)};
        std::uint32_t index = 0;
        while (index < set.vertices.size() && !(set.vertices[index] == v))
            ++index;
        if (index == set.vertices.size())
            set.vertices.push_back(v);
        set.loops.push_back(index);
        set.neighbours.push_back(kNoPolygon);
        polygon.centre += p / double(corners.size());
    }
    set.polygons.push_back(polygon);
}

/// Corners in the integer span of u and v, so that they are exactly in a plane.
inline std::vector<Vec3d> random_polygon(Random& random, const Vec3d& origin, const Vec3d& u, const Vec3d& v) {
    static const std::vector<std::vector<std::array<int, 2>>> shapes = {
        {{0, 0}, {1, 0}, {0, 1}},
        {{0, 0}, {1, 0}, {1, 1}, {0, 1}},
        {{0, 0}, {2, 0}, {2, 1}, {1, 2}, {0, 2}},
        {{1, 0}, {2, 0}, {3, 1}, {3, 2}, {2, 3}, {1, 3}, {0, 2}, {0, 1}},
        {{0, 0}, {1, 0}, {2, 0}, {2, 1}, {0, 1}}, // with a straight corner
        {{0, 0}, {3, 0}, {1, 2}},
    };
    std::vector<Vec3d> corners;
    for (auto [i, j] : shapes[random.below(std::uint32_t(shapes.size()))])
        corners.push_back(origin + u * double(i) + v * double(j));
    return corners;
}

inline Vec3d lattice_point(Random& random, int reach) {
    auto one = [&] { return double(int(random.below(std::uint32_t(2 * reach + 1))) - reach); };
    double x = one(), y = one(), z = one();
    return {x, y, z};
}

/// On a lattice: planes, edges and corners coincide all the time.
inline Configuration lattice_configuration(Random& random, std::uint32_t occluders, std::uint32_t boxes) {
    Configuration made;
    int reach = 2 + int(random.below(5));
    while (made.set.polygons.size() < occluders) {
        Vec3d u = lattice_point(random, 3), v = lattice_point(random, 3);
        if (random.below(2)) { // axis-aligned
            int axis = int(random.below(3));
            u = v = {};
            u[axis] = 1 + random.below(4);
            v[(axis + 1) % 3] = 1 + random.below(4);
        }
        if (antumbra::cross(u, v) == Vec3d{})
            continue;
        add_polygon(made.set, random_polygon(random, lattice_point(random, reach), u, v), random.below(4) > 0);
    }
    made.eye = lattice_point(random, reach + 2);
    if (random.below(2))
        made.eye = made.eye + Vec3d{0.5, 0.25, 0.125} * double(random.below(3));
    for (std::uint32_t i = 0; i < boxes; ++i) {
        Box3d box;
        box.extend(lattice_point(random, reach + 2));
        box.extend(lattice_point(random, reach + 2));
        made.boxes.push_back(box);
    }
    return made;
}

/// Floats in general position; `crowded`: large occluders near the eye, small boxes far away, so that much is hidden.
inline Configuration general_configuration(Random& random, std::uint32_t occluders, std::uint32_t boxes, bool crowded) {
    Configuration made;
    // Multiples of 2^-20, so that sums of three are exact floats and polygons exactly flat.
    auto coarse = [&](double reach) { return std::ldexp(std::round(std::ldexp(random.uniform(-reach, reach), 16)), -16); };
    auto around = [&](double reach) { return Vec3d{coarse(reach), coarse(reach), coarse(reach)}; };
    made.eye = {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
    while (made.set.polygons.size() < occluders) {
        Vec3d origin = around(8), u = around(crowded ? 6 : 3), v = around(crowded ? 6 : 3);
        if (crowded)
            origin.z = coarse(2) + 6;
        if (length(antumbra::cross(u, v)) < 0.01)
            continue;
        add_polygon(made.set, random_polygon(random, origin, u, v), random.below(4) > 0);
    }
    for (std::uint32_t i = 0; i < boxes; ++i) {
        Vec3d centre{random.uniform(-8, 8), random.uniform(-8, 8), crowded ? random.uniform(4, 20) : random.uniform(-8, 8)};
        Vec3d half{random.uniform(0, 2), random.uniform(0, 2), random.uniform(0, 2)};
        made.boxes.push_back({centre - half, centre + half});
    }
    return made;
}

/// A wall of bricks that share edges, with T-junctions where rows are shifted, and holes; boxes around and behind.
inline Configuration wall_configuration(Random& random, std::uint32_t boxes) {
    Configuration made;
    Vec3d along{double(1 + random.below(2)), 0, double(int(random.below(3)) - 1)}, up{0, 1, 0};
    bool slanted = random.below(2);
    if (slanted)
        up.z = 0.5;
    int rows = 2 + int(random.below(3)), columns = 2 + int(random.below(4));
    for (int r = 0; r < rows; ++r)
        for (int c = 0; c < columns; ++c) {
            if (random.below(12) == 0)
                continue;
            double shift = r % 2 && random.below(2) ? 0.5 : 0;
            Vec3d a = Vec3d{-3, -2, 5} + along * (c + shift) + up * double(r);
            std::vector<Vec3d> quad{a, a + along, a + along + up, a + up};
            if (random.below(2))
                add_polygon(made.set, quad, true);
            else {
                add_polygon(made.set, {quad[0], quad[1], quad[2]}, true);
                add_polygon(made.set, {quad[0], quad[2], quad[3]}, true);
            }
        }
    made.eye = {random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-4, 1)};
    if (random.below(2))
        made.eye = lattice_point(random, 2);
    for (std::uint32_t i = 0; i < boxes; ++i) {
        Vec3d centre{random.uniform(-4, 8), random.uniform(-3, 4), random.uniform(3, 14)};
        double half = random.uniform(0.01, 1.5);
        Box3d box{centre - Vec3d{half, half, half}, centre + Vec3d{half, half, half}};
        if (random.below(2))
            for (int k = 0; k < 3; ++k) {
                box.min[k] = std::round(box.min[k]);
                box.max[k] = std::round(box.max[k]);
            }
        made.boxes.push_back(box);
    }
    return made;
}

inline std::vector<std::vector<HalfSpace>> shadows_of(const Configuration& made) {
    std::vector<std::vector<HalfSpace>> shadows;
    for (const OccluderPolygon& polygon : made.set.polygons) {
        Loop loop;
        for (std::uint32_t v : made.set.loop(polygon))
            loop.push_back(exactly(to_double(made.set.vertices[v])));
        if (auto shadow = shadow_of(loop, polygon.double_sided, exactly(made.eye)))
            shadows.push_back(*shadow);
    }
    return shadows;
}

} // namespace antumbra::test
