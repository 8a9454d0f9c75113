#include "bake/viewpoint.hpp"

namespace antumbra {
namespace {

// Opposite pairs along three roughly orthogonal axes, tilted so that they run along no wall of a scene that was built
// on the coordinate axes.
constexpr Vec3d kProbes[6] = {{0.87, 0.31, 0.39},  {-0.29, 0.95, -0.11}, {-0.41, -0.02, 0.91},
                              {-0.87, -0.31, -0.39}, {0.29, -0.95, 0.11},  {0.41, 0.02, -0.91}};
constexpr int kBackFacesOfSolid = 4;

} // namespace

bool is_viewpoint(const Tracer& tracer, const Vec3d& point) {
    int backs = 0, others = 0;
    for (const Vec3d& direction : kProbes) {
        bool back = false;
        tracer.nearest_surface({point, direction}, back);
        ++(back ? backs : others);
        if (backs >= kBackFacesOfSolid)
            return false;
        if (others > 6 - kBackFacesOfSolid)
            return true;
    }
    return true;
}

} // namespace antumbra
