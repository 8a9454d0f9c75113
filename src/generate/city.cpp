// The city: rows of blocks along straight streets. A block is a closed ring of buildings around a court, so
// that a walker in a street sees its two sides, some crossings, and roofs; most objects are windows.
#include "generate/furniture.hpp"
#include "generate/kinds.hpp"

namespace antumbra::generation {
namespace {

constexpr double kBlockWidth = 72, kBlockDepth = 48, kStreet = 14, kHouseDepth = 12;
constexpr double kPavement = 0.125, kWalk = 3; // height of the pavement, its width along the street
constexpr double kStorey = 3.25;
constexpr std::uint64_t kDefaultTriangles = 300'000, kSmallest = 25'000, kLargest = 100'000'000;
/// What a whole block has, about: decides how many blocks a row has.
constexpr double kBlockTriangles = 11'500;

struct City {
    Modeller modeller{"generate city"};
    std::uint64_t seed = 1, wanted = 0;

    bool full() const { return modeller.triangle_count() >= wanted; }
    void block(int column, int row, double centre_column, double centre_row);
    void side(const Frame& frame, const std::string& name, double length, double tallness, Random& random);
    void building(const Frame& frame, const std::string& name, double width, int storeys, Random& random);
    void windows(const Frame& frame, const std::string& name, double width, int storeys, int first,
                 Random& random);
    void roof(const Frame& frame, const std::string& name, double width, double height, Random& random);
    void street_furniture(const Frame& frame, const std::string& name, double length, Random& random);
};

/// `frame`: x along the facade from 0 to `width`, y up, +z toward the street, the facade at z = 0.
void City::windows(const Frame& frame, const std::string& name, double width, int storeys, int first,
                   Random& random) {
    int columns = static_cast<int>(width / 2.75);
    double step = width / columns;
    bool sills = random.below(2) != 0;
    for (int level = first; level < storeys; ++level)
        for (int c = 0; c < columns; ++c) {
            double x = (c + 0.5) * step, y = level * kStorey + 0.9;
            modeller.begin(name + "/window " + std::to_string(level) + "." + std::to_string(c + 1));
            modeller.place(frame);
            modeller.box({x - 0.6, y, 0}, {x + 0.6, y + 1.6, 0.06});
            if (sills)
                modeller.box({x - 0.7, y - 0.1, 0}, {x + 0.7, y, 0.2});
        }
    if (sills && random.below(3) == 0)
        for (int level = 1; level < storeys; ++level) {
            modeller.begin(name + "/balcony " + std::to_string(level));
            modeller.place(frame * at({width / 2, level * kStorey, 0}));
            modeller.box({-1.5, 0, 0}, {1.5, 0.15, 1.2});
            modeller.box({-1.5, 0.15, 1.125}, {1.5, 1.1, 1.2});
        }
}

void City::roof(const Frame& frame, const std::string& name, double width, double height, Random& random) {
    modeller.begin(name + "/roof");
    modeller.place(frame * at({0, height, 0}));
    double ridge = random.uniform(2.5, 4.5);
    if (random.below(3)) { // a gable along the street; along x an outline is (y, z)
        Vec2 outline[] = {{0, -kHouseDepth}, {ridge, -kHouseDepth / 2}, {0, 0}};
        modeller.extrude(Axis::x, outline, 0, width);
    } else { // flat, behind a parapet
        ridge = 1;
        modeller.ring(Axis::y, {-kHouseDepth, 0}, {0, width}, {-kHouseDepth + 0.3, 0.3}, {-0.3, width - 0.3},
                      0, 1);
    }
    for (std::uint32_t i = random.below(3); i > 0; --i) {
        modeller.begin(name + "/chimney " + std::to_string(i));
        modeller.place(frame * at({width * i / 3.0, height, -kHouseDepth / 2 + random.uniform(-1, 1)}));
        modeller.box({-0.4, 0, -0.3}, {0.4, ridge + 1, 0.3});
        modeller.place(frame * at({width * i / 3.0, height + ridge + 1, -kHouseDepth / 2}));
        modeller.cylinder(Axis::y, 0.15, 0, 0.5, 5);
    }
}

void City::building(const Frame& frame, const std::string& name, double width, int storeys, Random& random) {
    double height = storeys * kStorey + 0.5;
    modeller.begin(name + "/walls");
    modeller.place(frame);
    modeller.box({0, 0, -kHouseDepth}, {width, height, 0});
    modeller.begin(name + "/cornice");
    modeller.box({0, height - 0.4, 0}, {width, height, 0.3});
    modeller.begin(name + "/door");
    modeller.box({width / 2 - 0.7, 0, 0}, {width / 2 + 0.7, 2.4, 0.1});
    modeller.begin(name + "/shop windows");
    for (double x : {0.8, width / 2 + 1.2})
        modeller.ring(Axis::z, {x, 0.4}, {x + width / 2 - 2, 2.6}, {x + 0.1, 0.5}, {x + width / 2 - 2.1, 2.5},
                      0, 0.1);
    roof(frame, name, width, height, random);
    windows(frame, name + "/street", width, storeys, 1, random);
    windows(frame * turned({width, 0, -kHouseDepth}, 0.5), name + "/court", width, storeys,
            std::max(0, storeys - 2), random);
}

/// A row of buildings that fills `length` metres of one side of a block.
void City::side(const Frame& frame, const std::string& name, double length, double tallness, Random& random) {
    int count = std::max(1, static_cast<int>(length / random.uniform(11, 14)));
    double x = 0;
    for (int i = 0; i < count && !full(); ++i) {
        double even = length / count, width = i + 1 == count ? length - x : even * random.uniform(0.85, 1.1);
        width = std::floor(width * 16) / 16;
        int storeys = 2 + static_cast<int>(tallness * random.uniform(0.6, 1.4));
        building(frame * at({x, 0, 0}), name + std::to_string(i + 1), width, storeys, random);
        x += width;
    }
}

void City::street_furniture(const Frame& frame, const std::string& name, double length, Random& random) {
    for (int i = 0; (i + 0.5) * 12 < length && !full(); ++i) {
        std::string n = " " + std::to_string(i + 1);
        Frame place = frame * at({(i + 0.5) * 12, 0, 0});
        modeller.begin(name + "lamp post" + n);
        modeller.place(place);
        modeller.cylinder(Axis::y, 0.08, 0, 5, 6);
        modeller.box({-0.15, 5, -0.15}, {0.15, 5.4, 0.9});
        if (random.below(2))
            desk(modeller, place * at({3, 0, -0.6}), name + "bench" + n, {1.8, 0.45, 0.5});
        modeller.begin(name + "bin" + n);
        modeller.place(place * at({4.5, 0, -0.3}));
        modeller.cylinder(Axis::y, 0.25, 0, 0.9, 5);
        if (random.below(3)) { // a parked car
            modeller.begin(name + "car" + n);
            modeller.place(place * at({6.5, -kPavement, 1.4}));
            modeller.box({-2.1, 0.3, -0.85}, {2.1, 0.9, 0.85});
            Vec3d cabin[8];
            for (int k = 0; k < 8; ++k)
                cabin[k] = {(k & 1 ? 1.0 : -1.0) * (k & 2 ? 0.9 : 1.3), k & 2 ? 1.45 : 0.9,
                            (k & 4 ? 1.0 : -1.0) * (k & 2 ? 0.65 : 0.8)};
            modeller.hexahedron(cabin);
            for (double x : {-1.35, 1.35}) { // an axle with its two wheels
                modeller.place(place * at({6.5 + x, 0.33 - kPavement, 1.4}));
                modeller.cylinder(Axis::z, 0.33, -0.9, 0.9, 6);
            }
        }
    }
}

void City::block(int column, int row, double centre_column, double centre_row) {
    std::string name = "block " + std::to_string(column + 1) + "," + std::to_string(row + 1) + "/";
    Random random(seed,
                  (std::uint64_t(static_cast<std::uint32_t>(row)) << 32) | static_cast<std::uint32_t>(column),
                  0x63697479);
    double dx = column - centre_column, dz = row - centre_row;
    // Houses grow from 3 storeys at the rim to 8 in the middle.
    double tallness = 2 + 5 / (1 + 0.25 * (dx * dx + dz * dz));
    Frame corner = at({column * (kBlockWidth + kStreet), 0, row * (kBlockDepth + kStreet)});
    modeller.place(corner);
    modeller.begin(name + "street");
    modeller.box({-kStreet / 2, -0.5, -kStreet / 2},
                 {kBlockWidth + kStreet / 2, 0, kBlockDepth + kStreet / 2});
    modeller.begin(name + "pavement");
    modeller.box({-kWalk, 0, -kWalk}, {kBlockWidth + kWalk, kPavement, kBlockDepth + kWalk});
    Frame base = corner * at({0, kPavement, 0});
    double inner = kBlockDepth - 2 * kHouseDepth;
    Frame south = base * at({0, 0, kBlockDepth}), north = base * turned({kBlockWidth, 0, 0}, 0.5),
          east = base * turned({kBlockWidth, 0, kBlockDepth - kHouseDepth}, 0.25),
          west = base * turned({0, 0, kHouseDepth}, 0.75);
    side(south, name + "south ", kBlockWidth, tallness, random);
    side(north, name + "north ", kBlockWidth, tallness, random);
    side(east, name + "east ", inner, tallness, random);
    side(west, name + "west ", inner, tallness, random);
    street_furniture(south * at({0, 0, kWalk - 0.5}), name + "south ", kBlockWidth, random);
    street_furniture(north * at({0, 0, kWalk - 0.5}), name + "north ", kBlockWidth, random);
    street_furniture(east * at({0, 0, kWalk - 0.5}), name + "east ", inner, random);
    street_furniture(west * at({0, 0, kWalk - 0.5}), name + "west ", inner, random);
}

} // namespace

Result<RawScene> city(const GenerateOptions& options) {
    City city;
    city.seed = options.seed;
    city.wanted = options.triangles ? options.triangles : kDefaultTriangles;
    if (city.wanted < kSmallest || city.wanted > kLargest)
        return Status(ErrorCode::usage, "a city has from " + std::to_string(kSmallest) + " to " +
                                            std::to_string(kLargest) + " triangles, not " +
                                            std::to_string(city.wanted));
    double blocks = double(city.wanted) / kBlockTriangles;
    int columns = std::max(
        1, static_cast<int>(std::sqrt(blocks * (kBlockDepth + kStreet) / (kBlockWidth + kStreet)) + 0.5));
    double rows = blocks / columns;
    for (int row = 0; !city.full(); ++row)
        for (int column = 0; column < columns && !city.full(); ++column)
            city.block(column, row, (columns - 1) / 2.0, (rows - 1) / 2);
    return city.modeller.finish();
}

} // namespace antumbra::generation
