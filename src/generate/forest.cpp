// The forest: trees of exactly 1,000 triangles on uneven ground. A dozen shapes of tree, each in four
// directions, are spread one to a field of a jittered grid, so that a file can share their meshes. In two kinds: of light
// crowns and of dense ones.
#include "generate/kinds.hpp"
#include "generate/modeller.hpp"

#include "base/random.hpp"

namespace antumbra::generation {
namespace {

constexpr std::uint64_t kTreeTriangles = 1000, kDefaultTrees = 1450, kMostTrees = 1'000'000;
constexpr int kShapes = 12;
constexpr double kSpacing = 5.5;
constexpr int kTileQuads = 8;  // along each side of a tile of ground
constexpr double kQuad = 2.75; // metres
constexpr double kBottom = -6; // the ground is a solid with a flat underside

/// How the trees of a forest look. Lengths in metres.
struct Crown {
    double first[2];  ///< height of the lowest branch, as a share of the tree's: from, to
    double wide;      ///< reach of the branches, as a factor
    double leaf;      ///< a leaf's corners lie within so much of its centre, along each axis
    double scatter;   ///< its centre within so much of its branch
};
/// One sees into the trees and far between the trunks.
constexpr Crown kLight{{0.2, 0.35}, 1, 0.35, 0.55};
/// Closed down to the ground; a leaf stands for a spray of them.
constexpr Crown kDense{{0.03, 0.05}, 1.2, 1.6, 0.7};

double ground_height(double x, double z) {
    return 1.6 * sine(x / 83 + z / 211) + 1.1 * sine(z / 59 - x / 301 + 0.3) +
           0.35 * sine(x / 17 + 0.1) * sine(z / 19);
}

/// A closed solid: the uneven top, the same grid flat below, and walls.
void ground_tile(Modeller& modeller, int tile_x, int tile_z) {
    constexpr int n = kTileQuads + 1;
    modeller.begin("ground " + std::to_string(tile_x) + "," + std::to_string(tile_z));
    modeller.place({});
    std::vector<std::uint32_t> top, bottom;
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
            double x = (tile_x * kTileQuads + i) * kQuad, z = (tile_z * kTileQuads + j) * kQuad;
            top.push_back(modeller.vertex({x, ground_height(x, z), z}));
            bottom.push_back(modeller.vertex({x, kBottom, z}));
        }
    auto quad = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
        modeller.triangle(a, b, c);
        modeller.triangle(a, c, d);
    };
    auto index = [](int i, int j) { return static_cast<std::size_t>(j * n + i); };
    for (int j = 0; j < kTileQuads; ++j)
        for (int i = 0; i < kTileQuads; ++i) {
            std::size_t a = index(i, j), b = index(i, j + 1), c = index(i + 1, j + 1), d = index(i + 1, j);
            quad(top[a], top[b], top[c], top[d]);
            quad(bottom[a], bottom[d], bottom[c], bottom[b]);
        }
    auto wall = [&](std::size_t from, std::size_t to) { quad(bottom[from], bottom[to], top[to], top[from]); };
    for (int i = 0; i < kTileQuads; ++i) {
        wall(index(i, kTileQuads), index(i + 1, kTileQuads));
        wall(index(i + 1, 0), index(i, 0));
        wall(index(0, i), index(0, i + 1));
        wall(index(kTileQuads, i + 1), index(kTileQuads, i));
    }
}

/// Trunk (68 triangles), branches (14 each) and leaves: one object of 1,000 triangles, seen from both sides.
void tree(Modeller& modeller, const Crown& style, const Frame& frame, const std::string& name, Random random) {
    constexpr int kBranches = 16;
    constexpr int kLeaves = static_cast<int>(kTreeTriangles) - 68 - 14 * kBranches;
    modeller.begin(name, kOccludes | kDoubleSided);
    modeller.place(frame);
    double height = random.uniform(8, 13), crown = style.wide * random.uniform(1.8, 2.6),
           first = height * random.uniform(style.first[0], style.first[1]);
    Vec3d trunk[6];
    double radii[6];
    for (int i = 0; i < 6; ++i) {
        double share = i / 5.0;
        trunk[i] = {i ? random.uniform(-0.15, 0.15) : 0, share * height * 0.92,
                    i ? random.uniform(-0.15, 0.15) : 0};
        radii[i] = 0.24 * (1 - share) + 0.03;
    }
    modeller.tube(trunk, radii, 6);
    Vec3d tips[kBranches];
    for (int i = 0; i < kBranches; ++i) {
        double share = (i + 0.5) / kBranches, y = first + (height * 0.88 - first) * share;
        double turns = i * 0.3819660112501051 + random.uniform(0, 0.1);
        // The crown is widest a third of the way up.
        double reach =
            crown * (share < 0.33 ? 0.6 + 1.2 * share : 1.5 * (1 - share)) * random.uniform(0.8, 1);
        Vec3d out{sine(turns) * reach, 0, cosine(turns) * reach};
        tips[i] = Vec3d{0, y + reach * 0.35, 0} + out;
        Vec3d path[3] = {{0, y, 0}, Vec3d{0, y + reach * 0.25, 0} + out * 0.55, tips[i]};
        double thin[3] = {0.07, 0.045, 0.015};
        modeller.tube(path, thin, 3);
    }
    for (int i = 0; i < kLeaves; ++i) {
        const Vec3d& tip = tips[i % kBranches];
        double share = random.uniform(0.35, 1.1);
        Vec3d centre{tip.x * share, tip.y - (1 - share) * 0.5, tip.z * share};
        auto shift = [&](double size) {
            return Vec3d{random.uniform(-size, size), random.uniform(-size, size),
                         random.uniform(-size, size)};
        };
        centre += shift(style.scatter);
        Vec3d a = centre + shift(style.leaf), b = centre + shift(style.leaf), c = centre + shift(style.leaf);
        modeller.leaf(a, b, c);
    }
}

Result<RawScene> trees_on_ground(const GenerateOptions& options, const char* kind, const Crown& style) {
    std::uint64_t trees =
        options.triangles ? (options.triangles + kTreeTriangles / 2) / kTreeTriangles : kDefaultTrees;
    if (trees < 20 || trees > kMostTrees)
        return Status(ErrorCode::usage,
                      "a forest of either kind has from 20,000 to 1,000,000,000 triangles, a thousand a tree, not " +
                          std::to_string(options.triangles));
    auto columns = static_cast<std::uint64_t>(std::sqrt(double(trees)));
    while (columns * columns < trees)
        ++columns;
    double side = double(columns) * kSpacing;
    int tiles = static_cast<int>(side / (kTileQuads * kQuad)) + 1;
    Modeller modeller("generate " + std::string(kind));
    for (int z = 0; z < tiles; ++z)
        for (int x = 0; x < tiles; ++x)
            ground_tile(modeller, x, z);
    for (std::uint64_t i = 0; i < trees; ++i) {
        Random random(options.seed, i, 0x74726565);
        // Places are multiples of 1/64 m: the vertices of equal shapes snap alike.
        auto place = [&](std::uint64_t field) {
            return std::floor((double(field) + random.uniform(0.2, 0.8)) * kSpacing * 64) / 64;
        };
        double x = place(i % columns), z = place(i / columns);
        double y = std::floor((ground_height(x, z) - 0.25) * 64) / 64; // the foot is in the ground
        Frame frame = at({x, y, z}) * turned({}, random.below(4) * 0.25);
        tree(modeller, style, frame, "tree " + std::to_string(i + 1),
             Random(options.seed, random.below(kShapes), 0x73686170));
    }
    return modeller.finish();
}

} // namespace

Result<RawScene> forest(const GenerateOptions& options) {
    return trees_on_ground(options, "forest", kLight);
}

Result<RawScene> forest_dense(const GenerateOptions& options) {
    return trees_on_ground(options, "forest-dense", kDense);
}

} // namespace antumbra::generation
