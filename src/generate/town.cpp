// The town: a market place with a church and stalls, around it rings of houses with narrow crooked streets
// between them and lanes through them, and a wall with towers and a gate around all.
#include "generate/kinds.hpp"
#include "generate/town_house.hpp"

namespace antumbra::generation {
namespace {

constexpr std::uint64_t kDefaultTriangles = 1'330'000, kSmallest = 40'000, kLargest = 100'000'000;
constexpr double kMarket = 26, kStreet = 3.2;
constexpr double kTau = 6.283185307179586;
constexpr std::size_t kBarrelTriangles = 96;

struct Town {
    Modeller modeller{"generate town"};
    std::uint64_t seed = 1;
    double outer = 0; // radius that holds all houses

    void church();
    void stalls();
    std::size_t wall_triangles() const;
    void ring(int number, std::size_t end);
    void houses(std::size_t end);
    void wall();
    void ground();
    void barrels(std::size_t end);
};

/// How far streets swing to and fro: the same in every ring, so that they keep their width.
double swing(double turns) {
    return 1.6 * sine(3 * turns + 0.1) + 0.9 * sine(7 * turns);
}

Vec3d outward(double turns) {
    return {sine(turns), 0, cosine(turns)};
}

void Town::church() {
    modeller.place({});
    modeller.begin("church/nave floor");
    modeller.box({-10, 0, -5}, {10, 0.125, 5});
    modeller.place(at({0, 0.125, 0}));
    for (int side = 0; side < 2; ++side) {
        double z = side ? 4.5 : -5;
        for (int i = 0; i < 5; ++i) { // a pier and a window each, the window 1.6 m wide
            modeller.begin(std::string("church/wall ") + (side ? "south " : "north ") +
                           std::to_string(i + 1));
            double x = -10 + 4 * i;
            modeller.ring(Axis::z, {x, 0}, {x + 4, 8}, {x + 1.2, 2}, {x + 2.8, 6.5}, z, z + 0.5);
        }
        for (int i = 0; i < 4; ++i) {
            modeller.begin(std::string("church/column ") + (side ? "south " : "north ") +
                           std::to_string(i + 1));
            modeller.place(at({-6.0 + 4 * i, 0.125, side ? 2.6 : -2.6}));
            Vec2 profile[] = {{0.5, 0}, {0.5, 0.4}, {0.35, 0.6}, {0.3, 6.8}, {0.5, 7.2}, {0.5, 8}};
            modeller.lathe(Axis::y, profile, 16);
            modeller.place(at({0, 0.125, 0}));
        }
    }
    modeller.begin("church/wall east");
    modeller.box({9.5, 0, -4.5}, {10, 8, 4.5});
    modeller.begin("church/wall west"); // with the portal; along x an outline is (y, z)
    Vec2 west[] = {{0, -4.5}, {8, -4.5}, {8, 4.5}, {0, 4.5}, {0, 1.2}, {3.5, 1.2}, {3.5, -1.2}, {0, -1.2}};
    modeller.extrude(Axis::x, west, -10, -9.5);
    modeller.begin("church/roof");
    Vec2 gable[] = {{8, -5.5}, {13, 0}, {8, 5.5}};
    modeller.extrude(Axis::x, gable, -10.5, 10.5);
    modeller.begin("church/tower");
    modeller.box({10, 0, -2.5}, {15, 20, 2.5});
    modeller.begin("church/spire");
    modeller.place(at({12.5, 20.125, 0}));
    Vec2 spire[] = {{3.6, 0}, {0, 12}};
    modeller.lathe(Axis::y, spire, 8);
    for (int row = 0; row < 9; ++row)
        for (int side = 0; side < 2; ++side) {
            modeller.begin("church/pew " + std::to_string(2 * row + side + 1));
            modeller.place(at({-6.0 + 1.2 * row, 0.125, side ? 1.2 : -1.2}));
            modeller.box({0, 0, -0.9}, {0.05, 0.95, 0.9});
            modeller.box({0.05, 0.4, -0.9}, {0.45, 0.45, 0.9});
            modeller.box({0.4, 0, -0.85}, {0.45, 0.4, 0.85});
        }
    block(modeller, turned({8.6, 0.125, 0}, 0.75), "church/altar", {2.4, 1.1, 1});
}

void Town::stalls() {
    for (int i = 0; i < 10; ++i) {
        double turns = (i + 0.5) / 10;
        Frame place = turned(outward(turns) * 18.5, turns);
        std::string name = "market/stall " + std::to_string(i + 1);
        table(modeller, place, name, {2.2, 0.85, 0.9});
        modeller.begin(name + "/roof");
        modeller.place(place);
        for (double x : {-1.1, 1.0})
            modeller.box({x, 0, -0.2}, {x + 0.1, 2.2, -0.1});
        Vec3d corners[8];
        for (int k = 0; k < 8; ++k)
            corners[k] = {k & 1 ? 1.3 : -1.3, (k & 4 ? 1.9 : 2.2) + (k & 2 ? 0.06 : 0.0), k & 4 ? 1.3 : -0.3};
        modeller.hexahedron(corners);
        for (int k = 0; k < 3; ++k)
            jug(modeller, place * at({-0.6 + 0.6 * k, 0.85, 0.4}), name + "/jug " + std::to_string(k + 1),
                0.3);
    }
    modeller.begin("market/well");
    modeller.place(at({-15, 0, 0}));
    Vec2 profile[] = {{1.1, 0}, {1.1, 0.8}, {0.8, 0.8}, {0.8, 0.1}};
    modeller.lathe(Axis::y, profile, 16);
}

/// One ring of houses with their fronts toward the market, until the scene has `end` triangles or the ring is
/// closed.
void Town::ring(int number, std::size_t end) {
    double radius = kMarket + number * (kTownHouseDepth + kStreet);
    outer = radius + kTownHouseDepth + 3;
    Random random(seed, static_cast<std::uint64_t>(number), 0x746f776e);
    double turns = 0.03 * number, last = turns + 1;
    for (int i = 1, since_lane = 0; modeller.triangle_count() + kTownHouseTriangles <= end;
         ++i, ++since_lane) {
        double width = std::floor(random.uniform(6, 7.5) * 16) / 16, gap = random.uniform(0.2, 0.4);
        if (since_lane >= 4 && random.below(3) == 0) {
            gap = 2.5;
            since_lane = 0;
        }
        // The narrowest place of the ring decides, so that neighbours never overlap.
        double share = (width + gap) / (kTau * (radius - 3));
        if (turns + share > last)
            return;
        double middle = turns + share / 2;
        Frame frame = turned(outward(middle) * (radius + swing(middle)), middle + 0.5);
        town_house(
            modeller, frame, "house " + std::to_string(number + 1) + "." + std::to_string(i), width,
            Random(seed,
                   (std::uint64_t(static_cast<std::uint32_t>(number)) << 32) | static_cast<std::uint32_t>(i),
                   0x686f7573));
        turns += share;
    }
}

void Town::houses(std::size_t end) {
    for (int number = 0; modeller.triangle_count() + kTownHouseTriangles <= end; ++number)
        ring(number, end);
}

/// 36 straight pieces with merlons, a tower at every third corner, one piece left open with a gate house.
void Town::wall() {
    constexpr int kPieces = 36;
    double radius = outer + 3, length = 2 * radius * sine(0.5 / kPieces),
           inner = radius * cosine(0.5 / kPieces);
    for (int i = 0; i < kPieces; ++i) {
        double turns = (i + 0.5) / kPieces, half = length / 2;
        std::string number = std::to_string(i + 1);
        Frame frame = turned(outward(turns) * inner, turns);
        modeller.begin(i == 0 ? "town wall/gate" : "town wall/piece " + number);
        modeller.place(frame);
        if (i == 0) {
            Vec2 outline[] = {{-half, 0}, {-1.6, 0}, {-1.6, 3.5}, {1.6, 3.5},
                              {1.6, 0},   {half, 0}, {half, 7},   {-half, 7}};
            modeller.extrude(Axis::z, outline, -1.2, 1.2);
        } else {
            modeller.box({-half, 0, -0.6}, {half, 6, 0.6});
            for (int m = 0; m < 6; ++m)
                modeller.box({half * (2 * m - 5.3) / 6, 6, 0.1}, {half * (2 * m - 4.5) / 6, 6.8, 0.6});
        }
        if (i % 3)
            continue;
        modeller.begin("town wall/tower " + number);
        modeller.place(turned(outward(double(i) / kPieces) * radius, double(i) / kPieces));
        modeller.cylinder(Axis::y, 2.2, 0, 9, 16);
        modeller.begin("town wall/tower roof " + number);
        Vec2 roof[] = {{2.6, 9}, {0, 13}};
        modeller.lathe(Axis::y, roof, 16);
    }
}

std::size_t Town::wall_triangles() const {
    return 28 + 35 * 84 + 12 * (60 + 30);
}

void Town::ground() {
    constexpr double kTile = 24;
    int tiles = static_cast<int>((outer + 12) / kTile) + 1;
    for (int z = -tiles; z < tiles; ++z)
        for (int x = -tiles; x < tiles; ++x) {
            modeller.begin("ground " + std::to_string(x) + "," + std::to_string(z));
            modeller.place({});
            modeller.box({x * kTile, -0.5, z * kTile}, {(x + 1) * kTile, 0, (z + 1) * kTile});
        }
}

/// In heaps of rows on the market place: what brings the scene to its size.
void Town::barrels(std::size_t end) {
    for (int i = 0; modeller.triangle_count() + kBarrelTriangles <= end; ++i) {
        double turns = (i % 20) / 20.0 + 0.02, radius = 20.5 - (i / 20 % 4) * 0.9;
        barrel(modeller, at(outward(turns) * radius + Vec3d{0, (i / 80) * 0.9, 0}),
               "market/barrel " + std::to_string(i + 1), 0.9);
    }
}

} // namespace

Result<RawScene> town(const GenerateOptions& options) {
    std::uint64_t triangles = options.triangles ? options.triangles : kDefaultTriangles;
    if (triangles < kSmallest || triangles > kLargest)
        return Status(ErrorCode::usage, "a town has from " + std::to_string(kSmallest) + " to " +
                                            std::to_string(kLargest) + " triangles, not " +
                                            std::to_string(triangles));
    Town town;
    town.seed = options.seed;
    town.church();
    town.stalls();
    town.houses(triangles - town.wall_triangles());
    town.wall();
    town.ground();
    town.barrels(triangles);
    return town.modeller.finish();
}

} // namespace antumbra::generation
