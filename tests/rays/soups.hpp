// Random scenes for tests.
#pragma once

#include "base/random.hpp"

#include <antumbra/scene.hpp>

#include <string>

namespace soups {

using namespace antumbra;

/// Builds a scene out of single-triangle objects.
class Soup {
  public:
    void add(const Vec3d& a, const Vec3d& b, const Vec3d& c, std::uint32_t flags = kOccludes | kDoubleSided) {
        auto first = static_cast<std::uint32_t>(raw_.positions.size());
        raw_.positions.insert(raw_.positions.end(), {a, b, c});
        raw_.triangles.push_back({first, first + 1, first + 2});
        RawObject object;
        object.name = "t" + std::to_string(raw_.objects.size());
        object.flags = flags;
        object.first_triangle = static_cast<std::uint32_t>(raw_.triangles.size()) - 1;
        object.triangle_count = 1;
        raw_.objects.push_back(object);
    }
    std::size_t size() const { return raw_.triangles.size(); }
    Scene scene() const {
        Result<Scene> scene = Scene::create(raw_);
        return std::move(scene).value();
    }

  private:
    RawScene raw_;
};

inline Vec3d grid_point(Random& random, std::uint32_t size) {
    return {double(random.below(size + 1)), double(random.below(size + 1)), double(random.below(size + 1))};
}

inline Vec3d random_point(Random& random, double size) {
    return {random.uniform(-size, size), random.uniform(-size, size), random.uniform(-size, size)};
}

inline Vec3d random_direction(Random& random) {
    for (;;) {
        Vec3d d = random_point(random, 1);
        if (dot(d, d) > 0.01 && dot(d, d) < 1)
            return d;
    }
}

inline std::uint32_t random_flags(Random& random, bool mixed) {
    if (!mixed)
        return kOccludes | kDoubleSided;
    return (random.below(4) ? kOccludes : 0u) | (random.below(2) ? kDoubleSided : 0u);
}

/// `count` triangles with corners on the grid 0..size; always at least one with area. `mixed`: with all
/// flags.
inline Scene grid_soup(Random& random, std::uint32_t size, std::uint32_t count, bool mixed) {
    Soup soup;
    soup.add({0, 0, 0}, {double(size), 0, 0}, {0, double(size), double(size)}, random_flags(random, mixed));
    while (soup.size() < count)
        soup.add(grid_point(random, size), grid_point(random, size), grid_point(random, size),
                 random_flags(random, mixed));
    return soup.scene();
}

/// Small triangles all over a cube of the given size, at `origin`.
inline Scene small_soup(Random& random, double size, std::uint32_t count, double triangle_size,
                        Vec3d origin = {}, bool mixed = false) {
    Soup soup;
    while (soup.size() < count) {
        Vec3d centre = origin + random_point(random, size);
        Vec3d corner[3];
        for (Vec3d& p : corner)
            p = centre + random_point(random, triangle_size);
        soup.add(corner[0], corner[1], corner[2], random_flags(random, mixed));
    }
    return soup.scene();
}

} // namespace soups
