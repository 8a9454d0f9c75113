// The downtown: copies of one district of towers on straight streets, as the model of Poon and Wang (thirty copies of a
// Chicago model, 300,540 polygons). A tower is one object of some 120 triangles.
#include "generate/kinds.hpp"
#include "generate/modeller.hpp"

#include "base/random.hpp"

#include <cmath>

namespace antumbra::generation {
namespace {

constexpr int kBlocksAcross = 10, kBlocksDeep = 8, kCopiesAcross = 6;
constexpr double kPitch = 40, kLot = 26;
constexpr std::uint64_t kDefaultTriangles = 300'540, kSmallest = 5'000, kLargest = 100'000'000;

/// A base, tiers that step back, ribs up two facades, plant on the roof. It stands somewhere on its lot, whose middle is
/// the local origin: gaps between towers show others far behind, as in a real town and unlike in a street canyon.
void tower(Modeller& modeller, const Frame& lot, Random& random, double tallness) {
    double half = 4 + 9 * random.uniform(), room = kLot / 2 - half;
    double x = random.uniform(-room, room);
    double z = random.uniform(-room, room);
    modeller.place(lot * at({x, 0, z}));
    double height = 3 + std::floor(9 * random.uniform()), reach = half;
    modeller.box({-half, 0, -half}, {half, height, half});
    double rise = random.below(2) ? tallness : 8; // every other one stays low
    for (std::uint32_t tier = 1 + random.below(3); tier > 0; --tier) {
        reach *= 0.75 + 0.2 * random.uniform();
        double top = height + 2 + std::floor(rise * random.uniform());
        modeller.box({-reach, height, -reach}, {reach, top, reach});
        height = top;
    }
    for (int rib = -1; rib <= 1; ++rib) {
        double across = rib * half * 0.6;
        modeller.box({across - 0.4, 0, half}, {across + 0.4, 2.5, half + 0.4});
        modeller.box({across - 0.4, 0, -half - 0.4}, {across + 0.4, 2.5, -half});
    }
    double plant = reach * 0.4;
    modeller.box({-plant, height, -plant}, {plant, height + 3, plant});
    if (random.below(2))
        modeller.cylinder(Axis::y, 0.3, height + 3, height + 5 + 15 * random.uniform(), 4);
}

void district(Modeller& modeller, int column, int row, const GenerateOptions& options, std::uint64_t wanted) {
    Random random(options.seed, 0x646f776e); // the same for every copy
    std::string name = "district " + std::to_string(column + 1) + "," + std::to_string(row + 1) + "/";
    double x0 = column * kBlocksAcross * kPitch, z0 = row * kBlocksDeep * kPitch;
    modeller.begin(name + "ground");
    modeller.place(at({x0, 0, z0}));
    modeller.box({0, -0.5, 0}, {kBlocksAcross * kPitch, 0, kBlocksDeep * kPitch});
    for (int j = 0; j < kBlocksDeep; ++j)
        for (int i = 0; i < kBlocksAcross && modeller.triangle_count() < wanted; ++i) {
            double dx = i - (kBlocksAcross - 1) / 2.0, dz = j - (kBlocksDeep - 1) / 2.0;
            double tallness = 8 + 60 / (1 + 0.15 * (dx * dx + dz * dz));
            modeller.begin(name + "tower " + std::to_string(i + 1) + "," + std::to_string(j + 1));
            tower(modeller, at({x0 + (i + 0.5) * kPitch, 0, z0 + (j + 0.5) * kPitch}), random, tallness);
        }
}

} // namespace

Result<RawScene> downtown(const GenerateOptions& options) {
    std::uint64_t wanted = options.triangles ? options.triangles : kDefaultTriangles;
    if (wanted < kSmallest || wanted > kLargest)
        return Status(ErrorCode::usage, "a downtown has from " + std::to_string(kSmallest) + " to " +
                                            std::to_string(kLargest) + " triangles, not " + std::to_string(wanted));
    Modeller modeller("generate downtown");
    for (int copy = 0; modeller.triangle_count() < wanted; ++copy)
        district(modeller, copy % kCopiesAcross, copy / kCopiesAcross, options, wanted);
    return modeller.finish();
}

} // namespace antumbra::generation
