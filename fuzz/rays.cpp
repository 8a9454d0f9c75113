// The ray kernels against their plain twin and against no tree at all, and the arbiter against the tracer, on
// small scenes and rays of arbitrary bit patterns.
//
// Input: bytes. Count of triangles, corners on a grid of -8..7 (two bytes hold three coordinates and some
// flags), then rays as six doubles (any bits) or as six grid coordinates.
#include "rays/arbiter.hpp"
#include "rays/kernel.hpp"

#include <antumbra/scene.hpp>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <numeric>
#include <tuple>
#include <vector>

using namespace antumbra;
using namespace antumbra::rays;

namespace {

class Bytes {
  public:
    Bytes(const std::uint8_t* data, std::size_t size) : data_(data), left_(size) {}
    bool empty() const { return left_ == 0; }
    std::uint8_t next() { return left_ ? (--left_, *data_++) : 0; }
    template <class T>
    T value() {
        std::uint8_t raw[sizeof(T)];
        for (std::uint8_t& byte : raw)
            byte = next();
        T result;
        std::memcpy(&result, raw, sizeof(T));
        return result;
    }
    Vec3d grid_point() {
        auto bits = value<std::uint16_t>();
        return {double(bits % 16) - 8, double(bits / 16 % 16) - 8, double(bits / 256 % 16) - 8};
    }
    Ray ray() {
        if (next() % 2) {
            Vec3d from = grid_point();
            return {from, grid_point() - from};
        }
        Ray ray;
        for (int k = 0; k < 3; ++k) {
            ray.origin[k] = value<double>();
            ray.direction[k] = value<double>();
        }
        return ray;
    }

  private:
    const std::uint8_t* data_;
    std::size_t left_;
};

RawScene raw_scene(Bytes& bytes) {
    RawScene raw;
    raw.source = "fuzz";
    std::uint32_t count = 1 + bytes.next() % 24;
    for (std::uint32_t t = 0; t < count; ++t) {
        RawObject object;
        object.flags = bytes.next() % 4; // kOccludes, kDoubleSided
        object.first_triangle = t;
        object.triangle_count = 1;
        raw.objects.push_back(object);
        raw.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
        for (int c = 0; c < 3; ++c)
            raw.positions.push_back(bytes.grid_point());
    }
    return raw;
}

using Event = std::tuple<int, double, std::uint32_t, bool, bool>;
void add_event(void* self, int ray, double t, std::uint32_t triangle, bool front, bool double_sided) {
    static_cast<std::vector<Event>*>(self)->push_back({ray, t, triangle, front, double_sided});
}

std::vector<Event> everything(const Kernel& kernel, const TreeView& tree, const PreparedRay* rays,
                              int count) {
    std::vector<Event> events;
    double limits[kBatch];
    std::fill(limits, limits + kBatch, std::numeric_limits<double>::infinity());
    kernel.all(tree, rays, count, limits, {add_event, &events});
    std::sort(events.begin(), events.end());
    return events;
}

void require(bool law) {
    if (!law)
        std::abort();
}

/// One leaf without bounds over everything.
TriangleTree without_tree(const TriangleTree& tree) {
    TriangleTree flat;
    flat.blocks = tree.blocks;
    Node node;
    for (int i = 0; i < kWidth; ++i) {
        for (int k = 0; k < 6; ++k)
            node.bounds[k][i] = (k % 2 == 0) == (i == 0) ? -1e30f : 1e30f;
        node.first[i] = 0;
        node.count[i] = i == 0 ? std::uint32_t(flat.blocks.size()) : 0;
    }
    flat.nodes.push_back(node);
    return flat;
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    Bytes bytes(data, size);
    Result<Scene> scene = Scene::create(raw_scene(bytes));
    if (!scene || scene->triangles().empty())
        return 0;
    std::vector<std::uint32_t> triangles(scene->triangles().size());
    std::iota(triangles.begin(), triangles.end(), 0u);
    BvhOptions options;
    options.leaf_size = 1;
    TriangleTree tree = build_triangle_tree(*scene, triangles, options);
    TriangleTree flat = without_tree(tree);
    Tracer tracer = Tracer::build(*scene);
    Arbiter arbiter(tracer);
    PreparedRay prepared[kBatch];
    for (int batch = 0; batch < 4 && !bytes.empty(); ++batch) {
        int count = 0;
        for (int r = 0; r < kBatch && !bytes.empty(); ++r) {
            Ray ray = bytes.ray();
            if (!scalar_kernel().prepare(ray, 16, prepared[count]))
                continue;
            ++count;
            Hit hit = tracer.first_hit(ray);
            std::uint32_t target = std::uint32_t(r) % std::uint32_t(triangles.size());
            // Where the arbiter sees the way to the target clear, the tracer meets nothing well before it.
            Vec3d toward = ray.origin + ray.direction;
            if (toward - ray.origin == ray.direction &&
                arbiter.sees(ray.origin, toward, target) == Verdict::clear) {
                Vec3d a = scene->vertex(target, 0), b = scene->vertex(target, 1),
                      c = scene->vertex(target, 2);
                Vec3d normal = cross(b - a, c - a);
                double fall = dot(normal, ray.direction), t = dot(normal, a - ray.origin) / fall;
                bool steep = std::abs(fall) > 1e-6 * length(normal) * length(ray.direction) &&
                             length(ray.origin) < 1e3;
                require(!steep || hit.t >= t * (1 - 1e-6) - 1e-6 / length(ray.direction));
            }
        }
        std::vector<Event> expected = everything(scalar_kernel(), flat.view(), prepared, count);
        for (const Kernel* kernel : {&scalar_kernel(), avx2_kernel(), avx512_kernel()})
            if (kernel) {
                require(everything(*kernel, tree.view(), prepared, count) == expected);
                require(everything(*kernel, flat.view(), prepared, count) == expected);
            }
    }
    return 0;
}
