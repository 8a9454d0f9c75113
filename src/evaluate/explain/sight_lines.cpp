#include "evaluate/explain/sight_lines.hpp"

#include "base/random.hpp"
#include "rays/arbiter.hpp"

#include <algorithm>
#include <map>

namespace antumbra::explain {
namespace {

/// Picks triangles of one object in proportion to a weight.
class Targets {
  public:
    Targets(const Scene& scene, const Box3d& box, std::uint32_t object) : scene_(scene) {
        const Object& o = scene.objects()[object];
        first_ = o.first_triangle;
        bool point = box.min == box.max;
        double sum = 0;
        for (std::uint32_t t = 0; t < o.triangle_count; ++t) {
            sum += weight(first_ + t, point, box.min, o.has(kDoubleSided));
            sums_.push_back(sum);
        }
    }
    bool empty() const { return sums_.empty() || !(sums_.back() > 0); }
    std::uint32_t pick(Random& random) const {
        double at = random.uniform() * sums_.back();
        auto found = std::upper_bound(sums_.begin(), sums_.end(), at);
        return first_ + std::uint32_t(std::min<std::ptrdiff_t>(found - sums_.begin(), std::ptrdiff_t(sums_.size()) - 1));
    }
    Vec3d point(std::uint32_t triangle, Random& random) const {
        double u = random.uniform(), v = random.uniform();
        if (u + v > 1) {
            u = 1 - u;
            v = 1 - v;
        }
        Vec3d a = scene_.vertex(triangle, 0);
        return a + (scene_.vertex(triangle, 1) - a) * u + (scene_.vertex(triangle, 2) - a) * v;
    }

  private:
    double weight(std::uint32_t t, bool from_point, const Vec3d& eye, bool both_sides) const {
        Vec3d a = scene_.vertex(t, 0), b = scene_.vertex(t, 1), c = scene_.vertex(t, 2);
        Vec3d normal = cross(b - a, c - a);
        if (!from_point)
            return length(normal);
        Vec3d toward = eye - (a + b + c) / 3.0;
        double distance = length(toward), facing = dot(normal, toward);
        if (!both_sides && facing <= 0)
            return 0;
        // A triangle at the eye has no centre worth a word: no more than half of all there is to see.
        return std::min(1.0, std::abs(facing) / (distance * distance * distance + 1e-300));
    }

    const Scene& scene_;
    std::uint32_t first_ = 0;
    std::vector<double> sums_;
};

} // namespace

void aim(const Tracer& tracer, const Box3d& box, std::uint32_t object, std::uint32_t count, std::uint64_t seed,
         SightAnswer& answer) {
    const Scene& scene = tracer.scene();
    Targets targets(scene, box, object);
    if (targets.empty())
        return;
    Arbiter arbiter(tracer);
    Random random(seed, object, 0x6578706c);
    std::map<std::uint32_t, std::map<std::uint32_t, std::uint32_t>> first; // object, triangle: lines that meet it first
    std::uint32_t undrawn = 0;
    for (std::uint32_t k = 0; k < count; ++k) {
        Vec3d eye;
        for (int axis = 0; axis < 3; ++axis)
            eye[axis] = random.uniform(box.min[axis], box.max[axis]);
        std::uint32_t target = targets.pick(random);
        Vec3d toward = targets.point(target, random);
        if (toward == eye)
            continue;
        ++answer.sight_lines;
        bool clear = arbiter.sees(eye, toward, target) == Verdict::clear;
        if (!clear) {
            Hit hit = tracer.first_hit({eye, toward - eye});
            std::uint32_t hider = hit && hit.t < 1 ? scene.triangle_objects()[hit.triangle] : object;
            if (hider != object) {
                ++first[hider][hit.triangle];
                continue;
            }
            // Another part of the same object may stand before the target.
            clear = hit && hit.t < 1 && arbiter.sees(eye, toward, hit.triangle) == Verdict::clear;
            if (clear) {
                target = hit.triangle;
                toward = eye + (toward - eye) * hit.t;
            }
        }
        if (!clear) {
            ++undrawn;
            continue;
        }
        ++answer.lines_through;
        if (answer.sight != Sight::visible) {
            answer.sight = Sight::visible;
            answer.verified = true; // the arbiter is exact
            answer.witness = SightLine{scene.to_world(eye), scene.to_world(toward), target};
        }
    }
    if (answer.sight_lines == 0)
        return;
    answer.undrawn = double(undrawn) / answer.sight_lines;
    for (const auto& [hider, triangles] : first) {
        Hider entry{hider, 0, 0, {}};
        std::uint32_t lines = 0;
        for (auto [triangle, met] : triangles) {
            lines += met;
            entry.triangles.push_back(triangle);
        }
        entry.share = double(lines) / answer.sight_lines;
        answer.hiders.push_back(std::move(entry));
    }
}

} // namespace antumbra::explain
