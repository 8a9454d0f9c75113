// Rays aimed at what the exact method calls hidden: each that hits is judged again by the exact arbiter.
//
//   bench_exact_soak SCENE.. [--cells N] [--rays N] [--seed S]     prints CSV; exits 1 if a hidden triangle is seen
//
// SCENE is a file, or KIND:TRIANGLES of a generator. Random cells of 1/24 of the scene's longest side; each triangle is a
// unit. Of the rays half are aimed at random hidden triangles, half at the hidden neighbours (in the list of triangles) of
// visible ones, where mistakes would be; a random point of the cell to a random point of the triangle.
#include "bake/exact/cell.hpp"
#include "bake/viewpoint.hpp"
#include "base/random.hpp"
#include "rays/arbiter.hpp"

#include <antumbra/generate.hpp>
#include <antumbra/import.hpp>

#include <cstdio>
#include <cstdlib>
#include <cstring>

using namespace antumbra;
using namespace antumbra::exact;

namespace {

Result<Scene> open_scene(const std::string& name) {
    std::size_t colon = name.find(':');
    if (colon == std::string::npos)
        return load_scene(name);
    Result<RawScene> raw = generate(name.substr(0, colon), {.triangles = std::strtoull(name.c_str() + colon + 1, nullptr, 10)});
    return raw ? Scene::create(std::move(*raw)) : Result<Scene>(raw.status());
}

int soak(const std::string& name, std::size_t cells, std::uint64_t rays, std::uint64_t seed) {
    Result<Scene> scene = open_scene(name);
    if (!scene)
        return std::fprintf(stderr, "%s\n", scene.status().message().c_str()), 1;
    Tracer tracer = Tracer::build(*scene);
    Arbiter arbiter(tracer);
    SceneTree tree = SceneTree::build(*scene, Units::triangles(*scene));
    CellOptions options;
    options.look_around = 50000;
    options.follow = 200000;
    options.sample_between = true;
    CellSolver solver(tree, tracer, options);
    Box3d bounds = to_double(scene->local_bounds());
    Random random(seed, 0x736f616b);
    double edge = std::max({bounds.size().x, bounds.size().y, bounds.size().z}) / 24;
    std::uint64_t cast = 0, float_hits = 0, confirmed = 0, solved = 0, hidden_sum = 0, undecided = 0;
    auto triangles = std::uint32_t(scene->triangles().size());
    for (int attempt = 0; attempt < 1000 && solved < cells; ++attempt) {
        Vec3d low;
        for (int k = 0; k < 3; ++k)
            low[k] = random.uniform(bounds.min[k], bounds.max[k]);
        low.y = random.uniform(bounds.min.y, bounds.min.y + 0.3 * bounds.size().y);
        Vec3d high = low + Vec3d{edge, std::min(edge, std::max(bounds.size().y / 8, 4 * scene->step())), edge};
        if (!is_viewpoint(tracer, (low + high) * 0.5))
            continue;
        GridBox cell{tree.to_grid(low), tree.to_grid(high)};
        std::vector<std::uint64_t> bits((triangles + 63) / 64, 0);
        CellCounters counters;
        solver.solve(cell, bits, counters);
        undecided += counters.undecided;
        auto is_visible = [&](std::uint32_t t) { return bits[t / 64] >> (t % 64) & 1; };
        std::vector<std::uint32_t> hidden, border;
        for (std::uint32_t t = 0; t < triangles; ++t) {
            if (is_visible(t))
                continue;
            hidden.push_back(t);
            bool beside = false;
            for (std::uint32_t n = t > 4 ? t - 4 : 0; n < std::min(triangles, t + 5); ++n)
                beside |= is_visible(n) != 0;
            if (beside)
                border.push_back(t);
        }
        ++solved;
        hidden_sum += hidden.size();
        if (hidden.empty())
            continue;
        Vec3d from = tree.to_local({double(cell.min.x), double(cell.min.y), double(cell.min.z)}),
              to = tree.to_local({double(cell.max.x), double(cell.max.y), double(cell.max.z)});
        std::vector<std::uint32_t> seen;
        for (std::uint64_t r = 0; r < rays / cells; ++r) {
            const std::vector<std::uint32_t>& among = r % 2 && !border.empty() ? border : hidden;
            std::uint32_t target = among[random.below(std::uint32_t(among.size()))];
            Vec3d eye;
            for (int k = 0; k < 3; ++k)
                eye[k] = random.uniform(from[k], to[k]);
            double u = random.uniform(), v = random.uniform();
            if (u + v > 1) {
                u = 1 - u;
                v = 1 - v;
            }
            Vec3d a = scene->vertex(target, 0);
            Vec3d toward = a + (scene->vertex(target, 1) - a) * u + (scene->vertex(target, 2) - a) * v;
            ++cast;
            seen.clear();
            tracer.seen({eye, toward - eye}, seen);
            for (std::uint32_t t : seen)
                if (!is_visible(t)) {
                    ++float_hits;
                    if (arbiter.sees(eye, toward, t) == Verdict::clear) {
                        ++confirmed;
                        std::fprintf(stderr, "%s: triangle %u is called hidden, but seen from %.17g,%.17g,%.17g to %.17g,%.17g,%.17g\n",
                                     name.c_str(), t, eye.x, eye.y, eye.z, toward.x, toward.y, toward.z);
                    }
                }
        }
    }
    std::string label = name.substr(name.rfind('/') + 1);
    std::printf("%s,%u,%llu,%.1f,%llu,%llu,%llu,%llu\n", label.c_str(), triangles, (unsigned long long)solved,
                double(hidden_sum) / double(std::max<std::uint64_t>(solved, 1)), (unsigned long long)cast,
                (unsigned long long)float_hits, (unsigned long long)confirmed, (unsigned long long)undecided);
    std::fflush(stdout);
    return confirmed > 0;
}

} // namespace

int main(int argc, char** argv) {
    std::size_t cells = 4;
    std::uint64_t rays = 4'000'000, seed = 1;
    std::vector<std::string> scenes;
    for (int i = 1; i < argc; ++i)
        if (i + 1 < argc && std::strcmp(argv[i], "--cells") == 0)
            cells = std::strtoull(argv[++i], nullptr, 10);
        else if (i + 1 < argc && std::strcmp(argv[i], "--rays") == 0)
            rays = std::strtoull(argv[++i], nullptr, 10);
        else if (i + 1 < argc && std::strcmp(argv[i], "--seed") == 0)
            seed = std::strtoull(argv[++i], nullptr, 10);
        else
            scenes.push_back(argv[i]);
    std::puts("scene,triangles,cells,hidden_per_cell,rays,tracer_hits,confirmed,undecided");
    int failed = 0;
    for (const std::string& scene : scenes)
        failed |= soak(scene, cells, rays, seed);
    return failed;
}
