#include "rays/tracer.hpp"

#include "rays/kernel.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace antumbra {

using rays::Block;
using rays::HitSink;
using rays::Kernel;
using rays::Node;
using rays::PreparedRay;
using rays::TreeView;

namespace {

constexpr double kFarthestOrigin = 0x1p100;
constexpr double kLargestInverse = 0x1p64;
constexpr double kMargin = 0x1p-46;

/// The triangles of one kind and the tree above them.
struct TriangleTree {
    std::vector<Node> nodes;
    std::vector<Block> blocks;
    TreeView view() const { return {nodes.empty() ? nullptr : nodes.data(), blocks.data()}; }
    std::size_t bytes() const { return nodes.size() * sizeof(Node) + blocks.size() * sizeof(Block); }
};

bool before(const Vec3f& a, const Vec3f& b) {
    return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
}

/// Puts a triangle into a lane, corners in order of position.
void set_lane(Block& block, int lane, const Scene& scene, std::uint32_t triangle) {
    const TriangleIndices& indices = scene.triangles()[triangle];
    Vec3f corners[3];
    for (std::size_t c = 0; c < 3; ++c)
        corners[c] = scene.positions()[indices[c]];
    bool flipped = false;
    auto order = [&](int i, int j) {
        if (before(corners[j], corners[i])) {
            std::swap(corners[i], corners[j]);
            flipped = !flipped;
        }
    };
    order(0, 1);
    order(1, 2);
    order(0, 1);
    for (int c = 0; c < 3; ++c)
        for (int k = 0; k < 3; ++k)
            block.corner[c][k][lane] = corners[c][k];
    block.triangle[lane] = triangle;
    const Object& object = scene.object_of(triangle);
    auto bit = [&](bool set) { return static_cast<std::uint8_t>(set ? 1 << lane : 0); };
    block.flipped |= bit(flipped);
    block.double_sided |= bit(object.has(kDoubleSided));
}

void clear_lanes(Block& block, int from) {
    for (int lane = from; lane < rays::kLanes; ++lane) {
        for (int c = 0; c < 3; ++c)
            for (int k = 0; k < 3; ++k)
                block.corner[c][k][lane] = block.corner[0][k][0];
        block.triangle[lane] = kNoTriangle;
    }
}

/// Replaces the item ranges of leaves by ranges of blocks.
TriangleTree make_tree(const Scene& scene, const std::vector<std::uint32_t>& triangles, const Job& job) {
    std::vector<Box3f> boxes(triangles.size());
    for (std::size_t i = 0; i < triangles.size(); ++i)
        for (std::uint32_t v : scene.triangles()[triangles[i]])
            boxes[i].extend(scene.positions()[v]);
    BvhOptions options;
    options.leaf_size = 2 * rays::kLanes;
    options.block_size = rays::kLanes;
    WideBvh<rays::kWidth> wide = widen<rays::kWidth>(build_bvh(boxes, options, job));
    TriangleTree tree;
    for (Node& node : wide.nodes)
        for (int i = 0; i < rays::kWidth; ++i) {
            std::uint32_t first = node.first[i], count = node.count[i];
            if (count == 0)
                continue;
            node.first[i] = static_cast<std::uint32_t>(tree.blocks.size());
            for (std::uint32_t item = 0; item < count; ++item) {
                int lane = static_cast<int>(item % rays::kLanes);
                if (lane == 0)
                    tree.blocks.emplace_back();
                set_lane(tree.blocks.back(), lane, scene, triangles[wide.order[first + item]]);
            }
            clear_lanes(tree.blocks.back(), static_cast<int>((count - 1) % rays::kLanes) + 1);
            node.count[i] = static_cast<std::uint32_t>(tree.blocks.size()) - node.first[i];
        }
    tree.nodes = std::move(wide.nodes);
    tree.blocks.shrink_to_fit();
    return tree;
}

double largest(const Vec3d& v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

/// Prepares a ray; false if it cannot hit anything.
///
/// The margin. Let S = the largest |origin| plus the largest |coordinate|, u = 2^-53. A corner relative to the origin
/// is off by u S at most, sheared by 7 u S, so the triangle that the edge test of `cover` sees lies within 7 sqrt(2) u S
/// of the true one: whenever the edges accept it by more than the noise of collinear corners, the ray passes
/// within that of a point of the triangle, thus within 10 u S of its box. The margin is 128 u S.
///
/// Components of the direction below 2^-64 move a point by less than 2^-64 * S on its way through the scene, far less than the
/// margin; their inverse is cut off there, which keeps 0 * infinity out of the slabs and keeps an origin on a
/// box plane inside the (grown) slab.
bool prepare(const Vec3d& origin, const Vec3d& direction, double scene_size, PreparedRay& ray, int& exponent) {
    double size = largest(direction), reach = largest(origin);
    if (!(size > 0) || !std::isfinite(size) || !(reach <= kFarthestOrigin) || !is_finite(direction) || !is_finite(origin))
        return false;
    exponent = std::ilogb(size);
    ray.margin = kMargin * (reach + scene_size);
    int z = 0;
    for (int k = 0; k < 3; ++k) {
        double d = std::scalbn(direction[k], -exponent);
        double o = origin[k];
        ray.origin[k] = o;
        ray.direction[k] = d;
        if (std::abs(d) > std::abs(ray.direction[z]))
            z = k;
        ray.inverse[k] = std::abs(d) < 1 / kLargestInverse ? std::copysign(kLargestInverse, d) : 1 / d;
        double outward = 2 * ray.margin + std::abs(o) * 0x1p-22; // the second part outweighs rounding to float
        ray.near_origin[k] = static_cast<float>(ray.inverse[k] < 0 ? o - outward : o + outward);
        ray.far_origin[k] = static_cast<float>(ray.inverse[k] < 0 ? o + outward : o - outward);
        ray.near_inverse[k] = static_cast<float>(ray.inverse[k] * (1 - 0x1p-21));
        ray.far_inverse[k] = static_cast<float>(ray.inverse[k] * (1 + 0x1p-21));
        ray.near_row[k] = 2 * k + (ray.inverse[k] < 0);
        ray.far_row[k] = 2 * k + !(ray.inverse[k] < 0);
    }
    ray.axis_z = z;
    ray.axis_x = (z + 1) % 3;
    ray.axis_y = (z + 2) % 3;
    ray.shear_z = 1 / ray.direction[z];
    ray.shear_x = ray.direction[ray.axis_x] / ray.direction[z];
    ray.shear_y = ray.direction[ray.axis_y] / ray.direction[z];
    ray.against = ray.direction[z] < 0;
    return true;
}

} // namespace

struct Tracer::Tree {
    const Scene* scene = nullptr;
    double size = 0; ///< largest coordinate
    TriangleTree occluding, open;
    const Kernel* kernel = nullptr;

    bool prepared(const Ray& ray, PreparedRay& prepared, int& exponent) const {
        return prepare(ray.origin, ray.direction, size, prepared, exponent);
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
    tree.occluding = make_tree(scene, occluding, job);
    tree.open = make_tree(scene, open, job);
    return tracer;
}

const Scene& Tracer::scene() const { return *tree_->scene; }

std::size_t Tracer::memory_bytes() const { return tree_->occluding.bytes() + tree_->open.bytes(); }

Hit Tracer::first_hit(const Ray& ray) const {
    PreparedRay prepared;
    int exponent;
    Hit hit;
    if (!tree_->prepared(ray, prepared, exponent))
        return hit;
    tree_->kernel->nearest(tree_->occluding.view(), prepared, hit);
    hit.t = std::scalbn(hit.t, -exponent);
    return hit;
}

void Tracer::first_hits(std::span<const Ray> rays, std::span<Hit> hits) const {
    for (std::size_t i = 0; i < rays.size(); ++i)
        hits[i] = first_hit(rays[i]);
}

namespace {

struct Found {
    std::uint32_t object;
    std::uint32_t triangle;
    double t;
};

/// Candidates of one ray; the occluding ones are dropped whenever a nearer one appears.
struct Collector {
    const Scene* scene;
    std::vector<Found>* found;

    void add(double t, std::uint32_t triangle) {
        found->push_back({scene->triangle_objects()[triangle], triangle, t});
    }
    static void nearest(void* self, double t, std::uint32_t triangle, bool, bool) {
        auto& collector = *static_cast<Collector*>(self);
        if (!collector.found->empty() && t < collector.found->back().t)
            collector.found->clear();
        collector.add(t, triangle);
    }
    static void all(void* self, double t, std::uint32_t triangle, bool, bool) {
        static_cast<Collector*>(self)->add(t, triangle);
    }
};

struct Surface {
    Hit best;
    bool front = true, double_sided = true;
    static void add(void* self, double t, std::uint32_t triangle, bool front, bool double_sided) {
        auto& surface = *static_cast<Surface*>(self);
        if (t < surface.best.t || (t == surface.best.t && triangle < surface.best.triangle))
            surface = {{t, triangle}, front, double_sided};
    }
};

} // namespace

Hit Tracer::seen(const Ray& ray, std::vector<std::uint32_t>& triangles) const {
    thread_local std::vector<Found> found;
    found.clear();
    PreparedRay prepared;
    int exponent;
    Hit hit;
    if (!tree_->prepared(ray, prepared, exponent))
        return hit;
    Collector collector{tree_->scene, &found};
    tree_->kernel->nearest_ties(tree_->occluding.view(), prepared, hit, {Collector::nearest, &collector});
    tree_->kernel->all(tree_->open.view(), prepared, hit.t, {Collector::all, &collector});
    std::sort(found.begin(), found.end(), [](const Found& a, const Found& b) {
        return a.object != b.object ? a.object < b.object : a.t != b.t ? a.t < b.t : a.triangle < b.triangle;
    });
    for (std::size_t i = 0; i < found.size(); ++i)
        if (i == 0 || found[i].object != found[i - 1].object)
            triangles.push_back(found[i].triangle);
    hit.t = std::scalbn(hit.t, -exponent);
    return hit;
}

Hit Tracer::nearest_surface(const Ray& ray, bool& back) const {
    back = false;
    PreparedRay prepared;
    int exponent;
    if (!tree_->prepared(ray, prepared, exponent))
        return {};
    Surface surface;
    Hit hit;
    tree_->kernel->surface(tree_->occluding.view(), prepared, hit, {Surface::add, &surface});
    hit.triangle = kNoTriangle; // ties are decided by Surface::add
    tree_->kernel->surface(tree_->open.view(), prepared, hit, {Surface::add, &surface});
    if (!surface.best)
        return {};
    back = !surface.front && !surface.double_sided && tree_->scene->object_of(surface.best.triangle).has(kOccludes);
    surface.best.t = std::scalbn(surface.best.t, -exponent);
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
                    if (tree.blocks[b].triangle[lane] != kNoTriangle && near_lane(tree.blocks[b], lane, ray, limit))
                        found.push_back(tree.blocks[b].triangle[lane]);
        }
    }
}

} // namespace

void Tracer::collect_near_segment(const Vec3d& p, const Vec3d& q, std::vector<std::uint32_t>& found) const {
    found.clear();
    PreparedRay prepared;
    int exponent = 0;
    Vec3d direction = q - p;
    if (largest(direction) == 0)
        direction = {1, 0, 0}; // a point: a ray cut off at once, and boxes grow by the margin
    double end = largest(q - p) == 0 ? 0 : 1;
    if (!prepare(p, direction, tree_->size, prepared, exponent))
        return;
    double limit = std::scalbn(end, exponent) * (1 + 0x1p-40) + prepared.margin;
    collect(tree_->occluding.view(), prepared, limit, found);
    collect(tree_->open.view(), prepared, limit, found);
}

void Tracer::collect_near_ray(const Vec3d& p, const Vec3d& direction, double end,
                              std::vector<std::uint32_t>& found) const {
    found.clear();
    PreparedRay prepared;
    int exponent = 0;
    if (prepare(p, direction, tree_->size, prepared, exponent))
        collect(tree_->occluding.view(), prepared, std::scalbn(end, exponent) * (1 + 0x1p-40) + prepared.margin, found);
}

namespace rays {

const Kernel& best_kernel() {
    const Kernel* avx2 = avx2_kernel();
    return avx2 ? *avx2 : scalar_kernel();
}

} // namespace rays

} // namespace antumbra
