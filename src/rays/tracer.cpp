#include "rays/tracer.hpp"

#include "rays/kernel.hpp"

#include <algorithm>
#include <cmath>

namespace antumbra {

using rays::Block;
using rays::HitSink;
using rays::Kernel;
using rays::Node;
using rays::prepare;
using rays::PreparedRay;
using rays::TreeView;
using rays::TriangleTree;

namespace {

double largest(const Vec3d& v) {
    return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

} // namespace

struct Tracer::Tree {
    const Scene* scene = nullptr;
    double size = 0; ///< largest coordinate
    TriangleTree occluding, open;
    const Kernel* kernel = nullptr;

    bool prepared(const Ray& ray, PreparedRay& prepared) const {
        return kernel->prepare(ray, size, prepared);
    }
};

Tracer::Tracer() = default;
Tracer::~Tracer() = default;
Tracer::Tracer(Tracer&&) noexcept = default;
Tracer& Tracer::operator=(Tracer&&) noexcept = default;

Tracer Tracer::build(const Scene& scene, const Job& job) {
    Tracer tracer;
    tracer.tree_ = std::make_unique<Tree>();
    Tree& tree = *tracer.tree_;
    tree.scene = &scene;
    tree.kernel = &rays::best_kernel();
    Box3f bounds = scene.local_bounds();
    tree.size = std::max(largest(to_double(bounds.min)), largest(to_double(bounds.max)));
    std::vector<std::uint32_t> occluding, open;
    for (std::uint32_t t = 0; t < scene.triangles().size(); ++t)
        (scene.object_of(t).has(kOccludes) ? occluding : open).push_back(t);
    tree.occluding = rays::build_triangle_tree(scene, occluding, {}, job);
    tree.open = rays::build_triangle_tree(scene, open, {}, job);
    return tracer;
}

const Scene& Tracer::scene() const {
    return *tree_->scene;
}

std::size_t Tracer::memory_bytes() const {
    return tree_->occluding.bytes() + tree_->open.bytes();
}

Hit Tracer::first_hit(const Ray& ray) const {
    Hit hit;
    first_hits({&ray, 1}, {&hit, 1});
    return hit;
}

void Tracer::first_hits(std::span<const Ray> rays, std::span<Hit> hits) const {
    tree_->kernel->first_hits(tree_->occluding.view(), tree_->size, rays, hits);
}

namespace {

/// A hit of one ray of a batch.
struct Found {
    int ray;
    std::uint32_t object;
    double t;
    std::uint32_t triangle;
};

/// Collects the hits of a batch.
struct Collector {
    const Scene* scene;
    std::vector<Found>* found;

    static void add(void* self, int ray, double t, std::uint32_t triangle, bool, bool) {
        auto& collector = *static_cast<Collector*>(self);
        collector.found->push_back({ray, collector.scene->triangle_objects()[triangle], t, triangle});
    }
};

/// The order in which seen() lists what it found: by ray, then object, the nearest triangle of each first.
bool listed_before(const Found& a, const Found& b) {
    if (a.ray != b.ray)
        return a.ray < b.ray;
    if (a.object != b.object)
        return a.object < b.object;
    return a.t != b.t ? a.t < b.t : a.triangle < b.triangle;
}

/// Prepared rays of a batch; those that can hit nothing are left out.
struct Batch {
    PreparedRay rays[rays::kBatch];
    double limits[rays::kBatch];
    int place[rays::kBatch]; ///< in the caller's batch
    int count = 0;

    void add(const Kernel& kernel, const Ray& ray, double scene_size, int at) {
        limits[count] = std::numeric_limits<double>::infinity();
        place[count] = at;
        count += kernel.prepare(ray, scene_size, rays[count]);
    }
};

/// Leaves only those occluding hits that tie for the first of their ray, and tells it.
void keep_first(std::vector<Found>& found, const Batch& batch, Hit* hits) {
    std::size_t kept = 0;
    for (const Found& one : found) {
        if (one.t != batch.limits[one.ray])
            continue;
        Hit& hit = hits[batch.place[one.ray]];
        hit.t = one.t * batch.rays[one.ray].unit;
        hit.triangle = std::min(hit.triangle, one.triangle);
        found[kept++] = one;
    }
    found.resize(kept);
}

struct Surface {
    Hit best;
    bool front = true, double_sided = true;
    static void add(void* self, int, double t, std::uint32_t triangle, bool front, bool double_sided) {
        auto& surface = *static_cast<Surface*>(self);
        if (t < surface.best.t || (t == surface.best.t && triangle < surface.best.triangle))
            surface = {{t, triangle}, front, double_sided};
    }
};

} // namespace

/// At most kBatch rays; calls list(place of the ray, triangle) in order.
template <class List>
void Tracer::see(std::span<const Ray> rays, Hit* hits, List&& list) const {
    thread_local std::vector<Found> found;
    found.clear();
    Batch batch;
    for (std::size_t i = 0; i < rays.size(); ++i)
        batch.add(*tree_->kernel, rays[i], tree_->size, static_cast<int>(i));
    Collector collector{tree_->scene, &found};
    HitSink sink{Collector::add, &collector};
    tree_->kernel->nearest(tree_->occluding.view(), batch.rays, batch.count, batch.limits, sink);
    keep_first(found, batch, hits);
    tree_->kernel->all(tree_->open.view(), batch.rays, batch.count, batch.limits, sink);
    if (found.size() > 1)
        std::sort(found.begin(), found.end(), listed_before);
    for (std::size_t i = 0; i < found.size(); ++i)
        if (i == 0 || found[i].object != found[i - 1].object || found[i].ray != found[i - 1].ray)
            list(batch.place[found[i].ray], found[i].triangle);
}

Hit Tracer::seen(const Ray& ray, std::vector<std::uint32_t>& triangles) const {
    Hit hit;
    see({&ray, 1}, &hit, [&](int, std::uint32_t triangle) { triangles.push_back(triangle); });
    return hit;
}

void Tracer::seen_batch(std::span<const Ray> rays, SeenBatch& seen) const {
    seen.hits.assign(rays.size(), {});
    seen.triangles.clear();
    seen.begin.assign(1, 0);
    for (std::size_t done = 0; done < rays.size(); done += rays::kBatch) {
        std::size_t count = std::min<std::size_t>(rays::kBatch, rays.size() - done);
        see(rays.subspan(done, count), seen.hits.data() + done, [&](int place, std::uint32_t triangle) {
            // begin[i + 1] is set when the list of ray i is over.
            seen.begin.resize(done + static_cast<std::size_t>(place) + 1,
                              static_cast<std::uint32_t>(seen.triangles.size()));
            seen.triangles.push_back(triangle);
        });
        seen.begin.resize(done + count + 1, static_cast<std::uint32_t>(seen.triangles.size()));
    }
}

Hit Tracer::nearest_surface(const Ray& ray, bool& back) const {
    back = false;
    PreparedRay prepared;
    if (!tree_->prepared(ray, prepared))
        return {};
    Surface surface;
    double limit = std::numeric_limits<double>::infinity();
    HitSink sink{Surface::add, &surface};
    tree_->kernel->surface(tree_->occluding.view(), &prepared, 1, &limit, sink);
    tree_->kernel->surface(tree_->open.view(), &prepared, 1, &limit, sink);
    if (!surface.best)
        return {};
    back = !surface.front && !surface.double_sided &&
           tree_->scene->object_of(surface.best.triangle).has(kOccludes);
    surface.best.t *= prepared.unit;
    return surface.best;
}

std::vector<std::uint32_t>& Tracer::scratch() {
    thread_local std::vector<std::uint32_t> found;
    return found;
}

namespace {

/// Does the stretch of the ray up to `limit` touch the lane's grown box?
bool near_lane(const Block& block, int lane, const PreparedRay& ray, double limit) {
    double enter = 0, leave = limit;
    for (int k = 0; k < 3; ++k) {
        double a = block.corner[0][k][lane], b = block.corner[1][k][lane], c = block.corner[2][k][lane];
        double at_low = (std::min({a, b, c}) - (ray.origin[k] + ray.margin)) * ray.inverse[k];
        double at_high = (std::max({a, b, c}) - (ray.origin[k] - ray.margin)) * ray.inverse[k];
        enter = std::max(enter, ray.inverse[k] < 0 ? at_high : at_low);
        leave = std::min(leave, ray.inverse[k] < 0 ? at_low : at_high);
    }
    return enter <= leave;
}

/// Does the stretch touch the child's box? In doubles: this walk is not the hot one.
bool near_child(const Node& node, int child, const PreparedRay& ray, double limit) {
    double enter = 0, leave = limit;
    for (int k = 0; k < 3; ++k) {
        double at_low = (node.bounds[2 * k][child] - (ray.origin[k] + ray.margin)) * ray.inverse[k];
        double at_high = (node.bounds[2 * k + 1][child] - (ray.origin[k] - ray.margin)) * ray.inverse[k];
        enter = std::max(enter, ray.inverse[k] < 0 ? at_high : at_low);
        leave = std::min(leave, ray.inverse[k] < 0 ? at_low : at_high);
    }
    return enter <= leave;
}

void collect(const TreeView& tree, const PreparedRay& ray, double limit, std::vector<std::uint32_t>& found) {
    if (!tree.nodes)
        return;
    std::uint32_t stack[kMaxBvhDepth * (rays::kWidth - 1) + rays::kWidth];
    int depth = 0;
    stack[depth++] = 0;
    while (depth) {
        const Node& node = tree.nodes[stack[--depth]];
        for (int i = 0; i < rays::kWidth; ++i) {
            if (!near_child(node, i, ray, limit))
                continue;
            if (node.count[i] == 0) {
                stack[depth++] = node.first[i];
                continue;
            }
            for (std::uint32_t b = node.first[i]; b < node.first[i] + node.count[i]; ++b)
                for (int lane = 0; lane < rays::kLanes; ++lane)
                    if (tree.blocks[b].triangle[lane] != kNoTriangle &&
                        near_lane(tree.blocks[b], lane, ray, limit))
                        found.push_back(tree.blocks[b].triangle[lane]);
        }
    }
}

} // namespace

void Tracer::collect_near_segment(const Vec3d& p, const Vec3d& q, std::vector<std::uint32_t>& found) const {
    found.clear();
    PreparedRay prepared;
    Vec3d direction = q - p;
    if (largest(direction) == 0)
        direction = {1, 0, 0}; // a point: a ray cut off at once, and boxes grow by the margin
    double end = largest(q - p) == 0 ? 0 : 1;
    if (!prepare(p, direction, tree_->size, prepared))
        return;
    double limit = end / prepared.unit * (1 + 0x1p-40) + prepared.margin;
    collect(tree_->occluding.view(), prepared, limit, found);
    collect(tree_->open.view(), prepared, limit, found);
}

void Tracer::collect_near_ray(const Vec3d& p, const Vec3d& direction, double end,
                              std::vector<std::uint32_t>& found) const {
    found.clear();
    PreparedRay prepared;
    if (prepare(p, direction, tree_->size, prepared))
        collect(tree_->occluding.view(), prepared, end / prepared.unit * (1 + 0x1p-40) + prepared.margin,
                found);
}

namespace rays {

const Kernel& best_kernel() {
    const Kernel* avx512 = avx512_kernel();
    const Kernel* avx2 = avx2_kernel();
    return avx512 ? *avx512 : avx2 ? *avx2 : scalar_kernel();
}

} // namespace rays

} // namespace antumbra
