// A walker gets everywhere that a view cell may lie: doorways, gates and streets are open. Judged from the bare
// triangles by a flood over the ground, so that a wall in the wrong place cannot hide behind the code that made it.
#include "generate/laws.hpp"

#include <functional>

namespace antumbra {
namespace {

using test::bounds_of;
using test::made;

/// The ground in squares, for an upright body of `kRadius` whose lowest `kStep` metres step over things.
class Ground {
  public:
    using Ignore = std::function<bool(const std::string& name)>;

    Ground(const RawScene& scene, double floor, const Ignore& ignore) {
        for (const Vec3d& p : scene.positions)
            bounds_.extend(p);
        columns_ = count(bounds_.size().x);
        rows_ = count(bounds_.size().z);
        std::vector<char> solid(columns_ * rows_);
        for (const RawObject& object : scene.objects)
            if (!ignore(object.name))
                for (std::uint32_t t = 0; t < object.triangle_count; ++t)
                    mark(scene, scene.triangles[object.first_triangle + t], floor, solid);
        grow(solid);
    }

    /// Floods from a free place; how many places it reaches.
    std::size_t walk_from(double x, double z) {
        std::vector<std::size_t> open{index(x, z)};
        EXPECT_EQ(state_[open[0]], kFree) << "the walker starts in a wall";
        state_[open[0]] = kReached;
        for (std::size_t next = 0; next < open.size(); ++next) {
            std::size_t c = open[next] % columns_, r = open[next] / columns_;
            for (auto [dc, dr] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}})
                if (inside(std::ptrdiff_t(c) + dc, std::ptrdiff_t(r) + dr)) {
                    auto i = std::size_t(std::ptrdiff_t(r) + dr) * columns_ + std::size_t(std::ptrdiff_t(c) + dc);
                    if (state_[i] == kFree) {
                        state_[i] = kReached;
                        open.push_back(i);
                    }
                }
        }
        return open.size();
    }

    bool reached_near(double x, double z, double distance) const {
        for (double dx = -distance; dx <= distance; dx += kSquare)
            for (double dz = -distance; dz <= distance; dz += kSquare)
                if (bounds_.min.x <= x + dx && x + dx <= bounds_.max.x && bounds_.min.z <= z + dz &&
                    z + dz <= bounds_.max.z && state_[index(x + dx, z + dz)] == kReached)
                    return true;
        return false;
    }

  private:
    static constexpr double kSquare = 0.05, kRadius = 0.2, kStep = 0.2, kHeight = 1.7;
    enum State : char { kFree, kBlocked, kReached };

    static std::size_t count(double length) { return std::size_t(length / kSquare) + 1; }
    std::size_t index(double x, double z) const {
        return std::size_t((z - bounds_.min.z) / kSquare) * columns_ + std::size_t((x - bounds_.min.x) / kSquare);
    }
    bool inside(std::ptrdiff_t c, std::ptrdiff_t r) const {
        return c >= 0 && r >= 0 && c < std::ptrdiff_t(columns_) && r < std::ptrdiff_t(rows_);
    }

    /// The part of a convex polygon with sign * (y - height) >= 0.
    static std::vector<Vec3d> cut(const std::vector<Vec3d>& polygon, double height, double sign) {
        std::vector<Vec3d> kept;
        for (std::size_t i = 0; i < polygon.size(); ++i) {
            const Vec3d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
            double above = sign * (a.y - height), next = sign * (b.y - height);
            if (above >= 0)
                kept.push_back(a);
            if ((above >= 0) != (next >= 0))
                kept.push_back(a + (b - a) * (above / (above - next)));
        }
        return kept;
    }

    /// Marks the squares under what a body would touch, by points closer to each other than a square.
    void mark(const RawScene& scene, const TriangleIndices& triangle, double floor, std::vector<char>& solid) const {
        std::vector<Vec3d> polygon;
        for (std::uint32_t v : triangle)
            polygon.push_back(scene.positions[v]);
        polygon = cut(cut(polygon, floor + kStep, 1), floor + kHeight, -1);
        for (std::size_t i = 1; i + 1 < polygon.size(); ++i) {
            Vec3d u = polygon[i] - polygon[0], v = polygon[i + 1] - polygon[0];
            u.y = v.y = 0;
            int steps = int(std::max({length(u), length(v), length(v - u)}) / kSquare * 1.5) + 1;
            for (int a = 0; a <= steps; ++a)
                for (int b = 0; a + b <= steps; ++b) {
                    Vec3d p = polygon[0] + u * (double(a) / steps) + v * (double(b) / steps);
                    solid[index(p.x, p.z)] = 1;
                }
        }
    }

    void grow(const std::vector<char>& solid) {
        constexpr auto kReach = std::ptrdiff_t(kRadius / kSquare);
        state_.assign(solid.size(), kFree);
        for (std::size_t i = 0; i < solid.size(); ++i)
            for (std::ptrdiff_t dc = -kReach; solid[i] && dc <= kReach; ++dc)
                for (std::ptrdiff_t dr = -kReach; dr <= kReach; ++dr) {
                    std::ptrdiff_t c = std::ptrdiff_t(i % columns_) + dc, r = std::ptrdiff_t(i / columns_) + dr;
                    if (dc * dc + dr * dr <= kReach * kReach && inside(c, r))
                        state_[std::size_t(r) * columns_ + std::size_t(c)] = kBlocked;
                }
    }

    Box3d bounds_;
    std::size_t columns_ = 0, rows_ = 0;
    std::vector<State> state_;
};

bool is_door(const std::string& name) { return name.ends_with("/door"); }
bool is_nothing(const std::string&) { return false; }

/// Names of the objects that end with `ending`, between the heights, that the walker does not get near.
std::vector<std::string> missed(const RawScene& scene, const Ground& ground, std::string_view ending, double low,
                                double high, double distance, int& found) {
    std::vector<std::string> names;
    for (const RawObject& object : scene.objects) {
        if (!object.name.ends_with(ending))
            continue;
        Box3d bounds = bounds_of(scene, object);
        Vec3d centre = bounds.centre();
        if (bounds.min.y < low || bounds.max.y > high)
            continue;
        ++found;
        if (!ground.reached_near(centre.x, centre.z, distance))
            names.push_back(object.name);
    }
    return names;
}

TEST(Walkable, apartment_joins_its_rooms_by_the_doorway) {
    RawScene scene = made("apartment");
    Ground ground(scene, 0, is_nothing);
    ground.walk_from(4.4, 2.0); // living room
    int found = 0;
    EXPECT_EQ(missed(scene, ground, "bedroom/bed", 0, 3, 1.2, found), std::vector<std::string>());
    EXPECT_EQ(missed(scene, ground, "kitchen/stove", 0, 3, 0.8, found), std::vector<std::string>());
    EXPECT_EQ(missed(scene, ground, "study/chair", 0, 3, 0.8, found), std::vector<std::string>());
    EXPECT_EQ(found, 3);
}

TEST(Walkable, apartment_is_shut_toward_the_outside) {
    RawScene scene = made("apartment", {.triangles = 0, .seed = 1, .copies = 12});
    Ground ground(scene, 0, is_nothing);
    ground.walk_from(4.4, 2.0);
    EXPECT_FALSE(ground.reached_near(10, 2, 0.5)); // between this flat and the next
}

TEST(Walkable, every_room_of_every_storey_of_the_office_has_its_door_on_the_corridor) {
    RawScene scene = made("office");
    for (int storey = 0; storey < 3; ++storey) {
        double floor = storey * 3.0;
        Ground ground(scene, floor, is_door);
        ground.walk_from(4.0, 6.0); // lobby
        int found = 0;
        EXPECT_EQ(missed(scene, ground, "/lamp", floor, floor + 3, 0.75, found), std::vector<std::string>());
        EXPECT_EQ(found, 22);
    }
}

TEST(Walkable, some_doors_of_the_office_are_closed_and_some_open) {
    RawScene scene = made("office");
    Ground ground(scene, 0, is_nothing);
    ground.walk_from(4.0, 6.0);
    int found = 0;
    std::size_t shut = missed(scene, ground, "/lamp", 0, 3, 0.75, found).size();
    EXPECT_GT(shut, 22u / 5);
    EXPECT_LT(shut, 22u * 4 / 5);
}

TEST(Walkable, town_houses_open_to_streets_that_lead_to_the_market_and_out_of_the_gate) {
    RawScene scene = made("town", {.triangles = 300'000});
    Ground ground(scene, 0.125, is_door);
    ground.walk_from(0, 15); // between the church and the stalls
    int found = 0;
    EXPECT_EQ(missed(scene, ground, "/workshop/counter", 0, 3, 1.5, found), std::vector<std::string>());
    EXPECT_EQ(missed(scene, ground, "/kitchen/bench", 0, 3, 1.0, found), std::vector<std::string>());
    EXPECT_GE(found, 80);
    EXPECT_TRUE(ground.reached_near(-71, -71, 0.5)); // outside the wall
}

TEST(Walkable, city_streets_lead_from_corner_to_corner) {
    RawScene scene = made("city", {.triangles = 50'000});
    Ground ground(scene, 0, is_nothing);
    ground.walk_from(-5, -5);
    EXPECT_TRUE(ground.reached_near(160, 112, 2));
}

} // namespace
} // namespace antumbra
