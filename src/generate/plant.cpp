#include "generate/plant.hpp"

namespace antumbra::generation {

void plant(Modeller& modeller, const Frame& frame, const std::string& name, Random random) {
    constexpr int kLeaves = 295;
    constexpr double kGoldenTurn =
        0.3819660112501051; // leaves that follow each other never stand above each other
    modeller.begin(name, kOccludes | kDoubleSided);
    modeller.place(frame);
    Vec2 pot[2] = {{0.12, 0}, {0.17, 0.3}};
    modeller.lathe(Axis::y, pot, 8);
    Vec3d stem[3] = {
        {0, 0.3, 0}, {random.uniform(-0.03, 0.03), 0.7, random.uniform(-0.03, 0.03)}, {0, 1.2, 0}};
    double radii[3] = {0.02, 0.015, 0.008};
    modeller.tube(stem, radii, 5);
    for (int i = 0; i < kLeaves; ++i) {
        double share = double(i) / kLeaves, turns = i * kGoldenTurn;
        double height = 0.4 + 0.8 * share, reach = 0.42 * (1 - 0.7 * share) * random.uniform(0.6, 1);
        double rise = random.uniform(-0.05, 0.25), half = random.uniform(0.02, 0.04);
        Frame out = frame * turned({0, height, 0}, turns);
        modeller.place(out);
        // A leaf runs outward along z, bent at its middle.
        Vec3d root{0, 0, 0.01}, left{-half, rise * 0.7, reach * 0.55}, right{half, rise * 0.7, reach * 0.55},
            tip{0, rise * 0.5, reach};
        std::uint32_t r = modeller.vertex(root), a = modeller.vertex(left), b = modeller.vertex(right),
                      t = modeller.vertex(tip);
        modeller.triangle(r, b, a);
        modeller.triangle(a, b, t);
    }
}

} // namespace antumbra::generation
