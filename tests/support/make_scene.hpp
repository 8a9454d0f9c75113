// Small scenes for tests, built triangle by triangle.
#pragma once

#include <antumbra/scene.hpp>

#include <gtest/gtest.h>

namespace antumbra::test {

class SceneMaker {
  public:
    /// Begins an object; what follows belongs to it.
    SceneMaker& object(std::string name, std::uint32_t flags = kOccludes) {
        RawObject made;
        made.id = {std::int32_t(raw_.objects.size()), 0, -1};
        made.name = std::move(name);
        made.flags = flags;
        made.first_triangle = std::uint32_t(raw_.triangles.size());
        raw_.objects.push_back(made);
        return *this;
    }
    SceneMaker& triangle(Vec3d a, Vec3d b, Vec3d c) {
        auto first = std::uint32_t(raw_.positions.size());
        raw_.positions.insert(raw_.positions.end(), {a, b, c});
        raw_.triangles.push_back({first, first + 1, first + 2});
        ++raw_.objects.back().triangle_count;
        return *this;
    }
    /// Corners counter-clockwise seen from the front.
    SceneMaker& quad(Vec3d a, Vec3d b, Vec3d c, Vec3d d) { return triangle(a, b, c).triangle(a, c, d); }
    /// A solid box: faces point outward, or inward for a room.
    SceneMaker& box(Vec3d low, Vec3d high, bool inward = false) {
        Box3d b{low, high};
        static constexpr int faces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                            {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
        for (const auto& f : faces)
            if (inward)
                quad(b.corner(f[3]), b.corner(f[2]), b.corner(f[1]), b.corner(f[0]));
            else
                quad(b.corner(f[0]), b.corner(f[1]), b.corner(f[2]), b.corner(f[3]));
        return *this;
    }
    RawScene raw() const { return raw_; }
    Scene scene(const SceneOptions& options = {}) const {
        Result<Scene> made = Scene::create(raw_, options);
        EXPECT_TRUE(made) << made.status().message();
        return std::move(made).value();
    }

  private:
    RawScene raw_{.source = "test scene", .positions = {}, .triangles = {}, .objects = {}, .findings = {}};
};

} // namespace antumbra::test
