// Random frames that look for trouble: see prove().
#include "bake/viewpoint.hpp"
#include "evaluate/proving.hpp"

#include <cmath>

namespace antumbra {
namespace {

class ViewMaker {
  public:
    ViewMaker(const Tracer& tracer, Random random)
        : tracer_(tracer), scene_(tracer.scene()), random_(random), bounds_(to_double(scene_.local_bounds())),
          size_(length(bounds_.size())) {}

    /// Where a burst begins and how it goes on.
    View begin() {
        View view;
        view.eye = place();
        view.target = view.eye + direction();
        view.up = random_.below(5) ? Vec3d{0, 1, 0} : sphere();
        view.fov_y_deg = random_.below(5) ? random_.uniform(30, 100) : random_.uniform(5, 150);
        view.near_plane = random_.below(5) < 2 ? 0 : small_length();
        if (random_.below(8) == 0) {
            view.projection = Projection::orthographic;
            view.height = std::exp2(-random_.uniform(0, 7)) * size_;
            if (random_.below(2))
                view.near_plane = -random_.uniform(0, 0.5) * size_;
        }
        step_ = (random_.below(3) ? (view.target - view.eye) : sphere()) * (random_.below(4) ? small_length() : 0);
        turn_ = random_.below(3) ? sphere() * (0.1 * random_.uniform()) : Vec3d{};
        return view;
    }

    void go_on(View& view) const {
        Vec3d ahead = view.target - view.eye;
        view.eye = view.eye + step_;
        view.target = view.eye + normalized(ahead + turn_);
    }

  private:
    Vec3d sphere() {
        for (;;) {
            Vec3d v{random_.uniform(-1, 1), random_.uniform(-1, 1), random_.uniform(-1, 1)};
            if (double square = dot(v, v); square > 0.01 && square <= 1)
                return v * (1 / std::sqrt(square));
        }
    }
    /// Logarithmic: 2^-20 .. 2^-6 of the scene.
    double small_length() { return std::exp2(-random_.uniform(6, 20)) * size_; }

    Vec3d direction() {
        switch (random_.below(8)) {
        case 0: return sphere();
        case 1: {
            Vec3d axis;
            axis[int(random_.below(3))] = random_.below(2) ? 1 : -1;
            return axis;
        }
        default: { // as people look
            Vec3d v = sphere();
            v.y *= 0.3;
            return length(v) > 0.01 ? normalized(v) : Vec3d{1, 0, 0};
        }
        }
    }

    Vec3d within(double scale) {
        Vec3d p;
        for (int axis = 0; axis < 3; ++axis) {
            double middle = (bounds_.min[axis] + bounds_.max[axis]) / 2, half = (bounds_.max[axis] - bounds_.min[axis]) / 2;
            p[axis] = middle + random_.uniform(-scale, scale) * half;
        }
        return p;
    }

    Vec3d place() {
        std::uint32_t kind = random_.below(16);
        if (kind < 8) { // where a viewer can be
            for (int attempt = 0; attempt < 20; ++attempt)
                if (Vec3d p = within(1); is_viewpoint(tracer_, p))
                    return p;
            return within(1);
        }
        if (kind < 9)
            return within(1); // anywhere, inside matter too
        if (kind < 11)
            return within(1.5);
        auto triangle = random_.below(std::uint32_t(scene_.triangles().size()));
        Vec3d a = scene_.vertex(triangle, 0), b = scene_.vertex(triangle, 1), c = scene_.vertex(triangle, 2);
        if (kind < 14) { // close to a surface
            double u = random_.uniform(), v = random_.uniform();
            if (u + v > 1)
                u = 1 - u, v = 1 - v;
            return a + (b - a) * u + (c - a) * v + sphere() * small_length();
        }
        Vec3d p = within(1); // in the planes of the axes through a corner
        for (int axis = 0; axis < 3; ++axis)
            if (random_.below(2))
                p[axis] = a[axis];
        return p;
    }

    const Tracer& tracer_;
    const Scene& scene_;
    Random random_;
    Box3d bounds_;
    double size_;
    Vec3d step_, turn_;
};

} // namespace

View proof_view(const Tracer& tracer, std::uint64_t seed, std::uint64_t frame, double aspect) {
    for (std::uint32_t attempt = 0;; ++attempt) {
        ViewMaker maker(tracer, Random(seed, frame / kProofBurst, attempt));
        View view = maker.begin();
        view.aspect = aspect;
        for (std::uint64_t k = 0; k < frame % kProofBurst; ++k)
            maker.go_on(view);
        if (!problem_of(view)) // or a frame that looks along its up
            return view;
    }
}

} // namespace antumbra
