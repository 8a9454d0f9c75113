// Rays per second of the strict tracer beside Embree alone, one thread each, same rays, same triangles; with
// the share of rays about which the two disagree.
//
//   bench_rays [--rays N] [--sorted | --views] [SCENE..]     without scenes: a built-in field of boxes
//
// Embree: rtcIntersect1, RTC_SCENE_FLAG_ROBUST, RTC_BUILD_QUALITY_MEDIUM, no filters. To be comparable all
// faces are double-sided and only occluding triangles are given to either. Origins are uniform in a box of
// 1/20 of the scene's size (the "cell"), directions uniform, 16 cells; --sorted: each cell's rays sorted by
// direction.
#include "base/random.hpp"
#include "rays/tracer.hpp"

#include <antumbra/import.hpp>

#include <embree3/rtcore.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <string>
#include <vector>

using namespace antumbra;

namespace {

/// Processor time of this thread: both run on one thread, and the machine may be busy.
double seconds() {
    timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

/// Sum over chunks of the least time over rounds.
class Stopwatch {
  public:
    template <class Work>
    void run(std::size_t chunk, Work&& work) {
        double start = seconds();
        work();
        best_.resize(std::max(best_.size(), chunk + 1), 1e30);
        best_[chunk] = std::min(best_[chunk], seconds() - start);
    }
    double total() const {
        double sum = 0;
        for (double best : best_)
            sum += best;
        return sum;
    }

  private:
    std::vector<double> best_;
};

/// A street grid of boxes of random height on a floor.
RawScene boxes(std::uint32_t side) {
    RawScene raw;
    raw.source = "boxes";
    Random random(5);
    auto add_box = [&](Vec3d low, Vec3d high) {
        auto first = static_cast<std::uint32_t>(raw.positions.size());
        for (int i = 0; i < 8; ++i)
            raw.positions.push_back(Box3d{low, high}.corner(i));
        const std::uint32_t quads[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                           {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
        RawObject object;
        object.name = "box";
        object.first_triangle = static_cast<std::uint32_t>(raw.triangles.size());
        object.triangle_count = 12;
        for (const auto& q : quads) {
            raw.triangles.push_back({first + q[0], first + q[1], first + q[2]});
            raw.triangles.push_back({first + q[0], first + q[2], first + q[3]});
        }
        raw.objects.push_back(object);
    };
    add_box({-10, -1, -10}, {side * 10.0, 0, side * 10.0});
    for (std::uint32_t i = 0; i < side; ++i)
        for (std::uint32_t j = 0; j < side; ++j)
            for (std::uint32_t part = 0; part < 8; ++part) {
                Vec3d at{i * 10.0 + random.uniform(0, 6), random.uniform(0, 8),
                         j * 10.0 + random.uniform(0, 6)};
                add_box(at,
                        at + Vec3d{random.uniform(0.2, 2), random.uniform(0.2, 6), random.uniform(0.2, 2)});
            }
    return raw;
}

/// Sorts the rays of a cell by direction: by the face of a cube and a bin of 1/16 on it.
void sort_by_direction(std::span<Ray> rays) {
    auto key = [](const Ray& ray) {
        int z = 0;
        for (int k = 1; k < 3; ++k)
            if (std::abs(ray.direction[k]) > std::abs(ray.direction[z]))
                z = k;
        auto bin = [&](int k) { return int((ray.direction[k] / std::abs(ray.direction[z]) + 1) * 7.999); };
        return ((z * 2 + (ray.direction[z] < 0)) * 16 + bin((z + 1) % 3)) * 16 + bin((z + 2) % 3);
    };
    std::stable_sort(rays.begin(), rays.end(), [&](const Ray& a, const Ray& b) { return key(a) < key(b); });
}

std::vector<Ray> rays_in_cells(const Scene& scene, std::size_t count, bool sorted) {
    constexpr std::size_t kCells = 16;
    std::vector<Ray> rays;
    Box3d bounds = to_double(scene.local_bounds());
    Vec3d size = bounds.size() * 0.05;
    for (std::size_t c = 0; c < kCells; ++c) {
        Random random(3, c);
        Vec3d corner;
        for (int k = 0; k < 3; ++k)
            corner[k] = random.uniform(bounds.min[k], bounds.max[k] - size[k]);
        for (std::size_t i = 0; i < count / kCells; ++i) {
            Ray ray;
            for (int k = 0; k < 3; ++k)
                ray.origin[k] = random.uniform(corner[k], corner[k] + size[k]);
            do
                ray.direction = {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
            while (dot(ray.direction, ray.direction) > 1 || dot(ray.direction, ray.direction) < 0.01);
            rays.push_back(ray);
        }
        if (sorted)
            sort_by_direction(std::span(rays).last(count / kCells));
    }
    return rays;
}

/// Pixels of square views that look in random directions, 90 degrees wide.
std::vector<Ray> rays_of_views(const Scene& scene, std::size_t count) {
    constexpr std::uint32_t kSide = 128, kTile = 4;
    std::vector<Ray> rays;
    Box3d bounds = to_double(scene.local_bounds());
    for (std::size_t view = 0; rays.size() < count; ++view) {
        Random random(9, view);
        Vec3d eye, forward, right;
        for (int k = 0; k < 3; ++k) {
            eye[k] = random.uniform(bounds.min[k], bounds.max[k]);
            forward[k] = random.uniform(-1, 1);
            right[k] = random.uniform(-1, 1);
        }
        forward = normalized(forward);
        right = normalized(cross(forward, right));
        Vec3d up = cross(right, forward);
        for (std::uint32_t p = 0; p < kSide * kSide; ++p) {
            std::uint32_t tile = p / (kTile * kTile), within = p % (kTile * kTile);
            double x = tile % (kSide / kTile) * kTile + within % kTile + 0.5;
            double y = double(tile / (kSide / kTile) * kTile + within / kTile) + 0.5;
            rays.push_back({eye, forward + right * (x * 2 / kSide - 1) + up * (y * 2 / kSide - 1)});
        }
    }
    return rays;
}

struct Embree {
    RTCDevice device = rtcNewDevice("threads=1");
    RTCScene scene = rtcNewScene(device);
    std::vector<std::uint32_t> triangles; ///< index in the Scene of each of ours

    explicit Embree(const Scene& source) {
        std::vector<std::uint32_t> indices;
        for (std::uint32_t t = 0; t < source.triangles().size(); ++t)
            if (source.object_of(t).has(kOccludes)) {
                triangles.push_back(t);
                indices.insert(indices.end(), source.triangles()[t].begin(), source.triangles()[t].end());
            }
        rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
        rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_MEDIUM);
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        std::size_t vertices = source.positions().size();
        void* v =
            rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, vertices);
        std::memcpy(v, source.positions().data(), vertices * 12);
        void* i = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12,
                                          triangles.size());
        std::memcpy(i, indices.data(), indices.size() * 4);
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(scene, geometry);
        rtcReleaseGeometry(geometry);
        rtcCommitScene(scene);
    }
    ~Embree() {
        rtcReleaseScene(scene);
        rtcReleaseDevice(device);
    }
    void first_hits(std::span<const Ray> rays, std::span<Hit> hits) const {
        for (std::size_t r = 0; r < rays.size(); ++r) {
            RTCRayHit query;
            query.ray.org_x = float(rays[r].origin.x);
            query.ray.org_y = float(rays[r].origin.y);
            query.ray.org_z = float(rays[r].origin.z);
            query.ray.dir_x = float(rays[r].direction.x);
            query.ray.dir_y = float(rays[r].direction.y);
            query.ray.dir_z = float(rays[r].direction.z);
            query.ray.tnear = 0;
            query.ray.tfar = std::numeric_limits<float>::infinity();
            query.ray.mask = ~0u;
            query.ray.flags = 0;
            query.ray.time = 0;
            query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
            query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
            RTCIntersectContext context;
            rtcInitIntersectContext(&context);
            rtcIntersect1(scene, &context, &query);
            hits[r] = {};
            if (query.hit.geomID != RTC_INVALID_GEOMETRY_ID)
                hits[r] = {query.ray.tfar, triangles[query.hit.primID]};
        }
    }
};

void compare(const std::string& name, const Scene& scene, std::size_t count, bool views, bool sorted) {
    double start = seconds();
    Job one;
    one.threads = 1;
    Tracer tracer = Tracer::build(scene, one);
    double build = seconds() - start;
    start = seconds();
    Embree embree(scene);
    double embree_build = seconds() - start;
    std::vector<Ray> rays = views ? rays_of_views(scene, count) : rays_in_cells(scene, count, sorted);
    std::vector<Hit> ours(rays.size()), theirs(rays.size());
    Stopwatch our_watch, their_watch;
    constexpr std::size_t kChunk = 4096;
    for (int round = 0; round < 7; ++round)
        for (std::size_t c = 0; c * kChunk < rays.size(); ++c) { // in turns, so that both meet the same noise
            std::size_t begin = c * kChunk, size = std::min(kChunk, rays.size() - begin);
            std::span<const Ray> part(rays.data() + begin, size);
            our_watch.run(c, [&] { tracer.first_hits(part, {ours.data() + begin, size}); });
            their_watch.run(c, [&] { embree.first_hits(part, {theirs.data() + begin, size}); });
        }
    double our_best = our_watch.total(), their_best = their_watch.total();
    Stopwatch alone_watch, batch_watch;
    std::vector<std::uint32_t> seen_alone;
    SeenBatch seen_batch;
    for (int round = 0; round < 3; ++round)
        for (std::size_t c = 0; c * kChunk < rays.size(); ++c) {
            std::span<const Ray> part(rays.data() + c * kChunk, std::min(kChunk, rays.size() - c * kChunk));
            alone_watch.run(c, [&] {
                seen_alone.clear();
                for (const Ray& ray : part)
                    tracer.seen(ray, seen_alone);
            });
            batch_watch.run(c, [&] { tracer.seen_batch(part, seen_batch); });
        }
    std::size_t hit = 0, other_triangle = 0, other_depth = 0;
    for (std::size_t r = 0; r < rays.size(); ++r) {
        hit += bool(ours[r]);
        other_triangle += ours[r].triangle != theirs[r].triangle;
        bool near = bool(ours[r]) == bool(theirs[r]) &&
                    (!ours[r] || std::abs(ours[r].t - theirs[r].t) <= 1e-4 * (1 + ours[r].t));
        other_depth += !near;
    }
    double n = double(rays.size());
    std::printf("%-28s %9zu tri  build %.2f s (Embree %.2f)  %4zu MB  ours %6.3f Mray/s  Embree %6.3f Mray/s "
                " ratio %.2f  "
                "hits %.3f  other triangle %.2e  other depth %.2e  seen %.3f, in batches %.3f Mray/s\n",
                name.c_str(), scene.triangles().size(), build, embree_build, tracer.memory_bytes() >> 20,
                n / our_best / 1e6, n / their_best / 1e6, their_best / our_best, double(hit) / n,
                double(other_triangle) / n, double(other_depth) / n, n / alone_watch.total() / 1e6,
                n / batch_watch.total() / 1e6);
    std::fflush(stdout);
}

} // namespace

int main(int argc, char** argv) {
    std::size_t count = 400000;
    std::vector<std::string> files;
    bool views = false, sorted = false;
    for (int i = 1; i < argc; ++i)
        if (!std::strcmp(argv[i], "--rays") && i + 1 < argc)
            count = std::strtoul(argv[++i], nullptr, 10);
        else if (!std::strcmp(argv[i], "--views"))
            views = true;
        else if (!std::strcmp(argv[i], "--sorted"))
            sorted = true;
        else
            files.push_back(argv[i]);
    SceneOptions both;
    both.sides = SidesOption::both;
    Result<Scene> built_in = Scene::create(boxes(100), both);
    compare("boxes (built in)", *built_in, count, views, sorted);
    for (const std::string& file : files) {
        Result<Scene> scene = load_scene(file, {}, both);
        if (!scene) {
            std::fprintf(stderr, "%s\n", scene.status().message().c_str());
            return 1;
        }
        compare(file.substr(file.rfind('/') + 1), *scene, count, views, sorted);
    }
}
