// Walks and tests, generic over a policy that supplies:
//   bool prepare(ray, scene_size, PreparedRay&)      rays::prepare()
//   int  enter(node, ray, limit, distance[kWidth])   bit per child whose box the ray enters at or before the
//   limit int  enter_box(node, child, packet)              bit per ray of a packet that enters this child's
//   box in time int  cover(block, ray, Candidates&)              bit per lane whose triangle the ray's line
//   passes
// Included by one source file per instruction set, after its headers, inside an anonymous namespace, so that
// no two copies can be mixed up by the linker.

/// A float not below t >= 0.
inline float float_above(double t) {
    return static_cast<float>(t) * (1 + 0x1p-22f);
}

/// What a triangle test leaves for the lanes that passed it.
struct alignas(64) Candidates {
    double t[kLanes];
    double area[kLanes]; ///< sign: the turning direction as seen along the ray's main axis
};

/// Clamps t into the stretch of the ray inside the triangle's own box, grown by ray.margin; false if there is
/// none at positive t.
///
/// Why: with this clamp a hit's t lies in the stretch of every box around the triangle, as the walk computes
/// it (see `enter`), so pruning never drops a hit: the answer does not depend on the tree. And it throws out
/// the hits that rounding invents far away from a triangle whose plane holds the ray. It never throws out a
/// ray that passes within the margin of a point of the triangle.
inline bool clamp_to_box(const Block& block, int lane, const PreparedRay& ray, double& t) {
    double enter = 0, leave = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 3; ++k) {
        double a = block.corner[0][k][lane], b = block.corner[1][k][lane], c = block.corner[2][k][lane];
        double low = a < b ? a : b, high = a < b ? b : a;
        low = c < low ? c : low;
        high = c > high ? c : high;
        double at_low = (low - (ray.origin[k] + ray.margin)) * ray.inverse[k];
        double at_high = (high - (ray.origin[k] - ray.margin)) * ray.inverse[k];
        double first = ray.inverse[k] < 0 ? at_high : at_low, last = ray.inverse[k] < 0 ? at_low : at_high;
        enter = first > enter ? first : enter;
        leave = last < leave ? last : leave;
    }
    if (!(enter <= leave) || !(t > 0))
        return false;
    t = t < enter ? enter : t;
    t = t > leave ? leave : t;
    return t > 0;
}

/// Calls consume(index, limit, t, triangle, front, double_sided) for each lane that is hit by the ray of that
/// index; consume returns the ray's new limit.
template <bool all_sides, class Consume>
inline void resolve(const Block& block, const PreparedRay& ray, int index, int lanes,
                    const Candidates& candidates, double& limit, Consume&& consume) {
    while (lanes) {
        int lane = __builtin_ctz(static_cast<unsigned>(lanes));
        lanes &= lanes - 1;
        double t = candidates.t[lane];
        if (!clamp_to_box(block, lane, ray, t) || !(t <= limit))
            continue;
        bool turned = (((block.flipped >> lane) & 1) != 0) != ray.against;
        bool front = (candidates.area[lane] > 0) != turned;
        bool double_sided = ((block.double_sided >> lane) & 1) != 0;
        if (all_sides || front || double_sided)
            limit = consume(index, limit, t, block.triangle[lane], front, double_sided);
    }
}

struct Entry {
    std::uint32_t first, count;
    float distance;
};

inline Entry child_entry(const Node& node, const float* distance, int child) {
    return {node.first[child], node.count[child], distance[child]};
}

/// Removes and returns the lowest set bit.
inline int take_lowest(int& mask) {
    int bit = __builtin_ctz(static_cast<unsigned>(mask));
    mask &= mask - 1;
    return bit;
}

/// Puts the children of a node that the ray enters on the stack, the nearest on top.
inline void push_children(const Node& node, const float* distance, int children, Entry* stack, int& depth) {
    Entry first = child_entry(node, distance, take_lowest(children));
    if (!children) {
        stack[depth++] = first;
        return;
    }
    Entry second = child_entry(node, distance, take_lowest(children));
    bool ordered = first.distance < second.distance;
    int bottom = depth;
    stack[depth++] = ordered ? second : first;
    stack[depth++] = ordered ? first : second;
    while (children) {
        Entry next = child_entry(node, distance, take_lowest(children));
        int place = depth++;
        for (; place > bottom && stack[place - 1].distance < next.distance; --place)
            stack[place] = stack[place - 1];
        stack[place] = next;
    }
}

constexpr int kStackSize = kMaxBvhDepth * (kWidth - 1) + kWidth;
constexpr Entry kRoot{0, 0, 0};

/// Tests the blocks of a leaf; true if the limit may have changed.
template <class Policy, bool all_sides, class Consume>
inline bool test_leaf(const TreeView& tree, const Entry& leaf, const PreparedRay& ray, int index,
                      double& limit, Consume&& consume) {
    bool any = false;
    for (std::uint32_t b = leaf.first; b < leaf.first + leaf.count; ++b) {
        Candidates candidates;
        int lanes = Policy::cover(tree.blocks[b], ray, candidates);
        if (lanes) {
            resolve<all_sides>(tree.blocks[b], ray, index, lanes, candidates, limit, consume);
            any = true;
        }
    }
    return any;
}

/// One ray, front to back through the subtree below `entry`; `consume` as in resolve(). Returns the last
/// limit.
template <class Policy, bool all_sides, class Consume>
inline double walk(const TreeView& tree, Entry entry, const PreparedRay& ray, int index, double limit,
                   Consume&& consume) {
    Entry stack[kStackSize];
    int depth = 0;
    float limit_above = float_above(limit);
    for (;;) {
        if (entry.count == 0) {
            const Node& node = tree.nodes[entry.first];
            alignas(64) float distance[kWidth];
            int children = Policy::enter(node, ray, limit_above, distance);
            if (children)
                push_children(node, distance, children, stack, depth);
        } else if (test_leaf<Policy, all_sides>(tree, entry, ray, index, limit, consume)) {
            limit_above = float_above(limit);
        }
        do {
            if (depth == 0)
                return limit;
            entry = stack[--depth];
        } while (entry.distance > limit_above);
    }
}

/// Rays that run alike, and one that stands for all: a box that any of them enters is entered by that one,
/// and no later. (The nearest of moved origins and the smallest of inverses bound the way to the first planes
/// from below, the farthest and the largest that to the last planes from above.)
struct alignas(64) Packet {
    float near_origin[3][kPacket], far_origin[3][kPacket], near_inverse[3][kPacket], far_inverse[3][kPacket];
    float limit_above[kPacket]; ///< -1 for unused places
    PreparedRay bounds;         ///< only what `enter` reads
    float farthest;             ///< the largest of limit_above
    const PreparedRay* rays;
    int first, count; ///< rays[first .. first + count)

    Packet(const PreparedRay* all, int begin, int rays_count, const double* limits)
        : rays(all), first(begin), count(rays_count) {
        const PreparedRay& one = rays[first];
        for (int k = 0; k < 3; ++k) {
            bool down = one.inverse[k] < 0;
            bounds.near_row[k] = one.near_row[k];
            bounds.far_row[k] = one.far_row[k];
            for (int i = 0; i < kPacket; ++i) {
                const PreparedRay& ray = rays[first + (i < count ? i : 0)];
                near_origin[k][i] = ray.near_origin[k];
                far_origin[k][i] = ray.far_origin[k];
                near_inverse[k][i] = ray.near_inverse[k];
                far_inverse[k][i] = ray.far_inverse[k];
            }
            bounds.near_origin[k] = down ? smallest(near_origin[k]) : largest(near_origin[k]);
            bounds.far_origin[k] = down ? largest(far_origin[k]) : smallest(far_origin[k]);
            bounds.near_inverse[k] = down ? largest(near_inverse[k]) : smallest(near_inverse[k]);
            bounds.far_inverse[k] = down ? smallest(far_inverse[k]) : largest(far_inverse[k]);
        }
        for (int i = 0; i < kPacket; ++i)
            limit_above[i] = i < count ? float_above(limits[first + i]) : -1;
        farthest = largest(limit_above);
    }
    static float smallest(const float (&x)[kPacket]) {
        float result = x[0];
        for (float value : x)
            result = value < result ? value : result;
        return result;
    }
    static float largest(const float (&x)[kPacket]) {
        float result = x[0];
        for (float value : x)
            result = value > result ? value : result;
        return result;
    }
};

/// All rays of a packet through the tree. Where only few of them enter a box, they go on alone.
template <class Policy, bool all_sides, class Consume>
inline void walk_packet(const TreeView& tree, Packet& packet, double* limits, Consume&& consume) {
    constexpr int kFew = 2;
    struct PacketEntry {
        Entry entry;
        std::uint32_t parent;
        int child;
    };
    PacketEntry stack[kStackSize];
    int depth = 0;
    std::uint32_t inner = 0; // the node whose children come next
    for (;;) {
        const Node& node = tree.nodes[inner];
        alignas(64) float distance[kWidth];
        int bottom = depth;
        for (int children = Policy::enter(node, packet.bounds, packet.farthest, distance); children;) {
            int child = take_lowest(children);
            PacketEntry next{child_entry(node, distance, child), inner, child};
            int place = depth++;
            for (; place > bottom && stack[place - 1].entry.distance < next.entry.distance; --place)
                stack[place] = stack[place - 1];
            stack[place] = next;
        }
        for (;;) {
            if (depth == 0)
                return;
            PacketEntry next = stack[--depth];
            if (next.entry.distance > packet.farthest)
                continue;
            int active = Policy::enter_box(tree.nodes[next.parent], next.child, packet);
            if (!active)
                continue;
            bool few = __builtin_popcount(static_cast<unsigned>(active)) <= kFew;
            if (!few && next.entry.count == 0) {
                inner = next.entry.first;
                break;
            }
            while (active) {
                int i = take_lowest(active), index = packet.first + i;
                const PreparedRay& ray = packet.rays[index];
                if (next.entry.count)
                    test_leaf<Policy, all_sides>(tree, next.entry, ray, index, limits[index], consume);
                else
                    limits[index] =
                        walk<Policy, all_sides>(tree, next.entry, ray, index, limits[index], consume);
                packet.limit_above[i] = float_above(limits[index]);
            }
            packet.farthest = Packet::largest(packet.limit_above);
        }
    }
}

/// Fewer rays are better off alone.
constexpr int kWorthwhile = 5;

/// Whether two rays run alike enough to share a walk; a matter of speed only, but for the signs.
inline bool run_alike(const PreparedRay& a, const PreparedRay& b) {
    constexpr double kSpread = 0.125;
    return a.axis_z == b.axis_z && a.near_row[0] == b.near_row[0] && a.near_row[1] == b.near_row[1] &&
           a.near_row[2] == b.near_row[2] && std::abs(a.shear_x - b.shear_x) <= kSpread &&
           std::abs(a.shear_y - b.shear_y) <= kSpread;
}

/// Walks the tree with all rays, neighbours that run alike together.
template <class Policy, bool all_sides, class Consume>
inline void trace(const TreeView& tree, const PreparedRay* rays, int count, double* limits,
                  Consume&& consume) {
    if (!tree.nodes)
        return;
    for (int begin = 0; begin < count;) {
        int end = begin + 1;
        while (end < count && end < begin + kPacket && run_alike(rays[begin], rays[end]))
            ++end;
        if (end - begin >= kWorthwhile) {
            Packet packet(rays, begin, end - begin, limits);
            walk_packet<Policy, all_sides>(tree, packet, limits, consume);
        } else {
            for (int i = begin; i < end; ++i)
                limits[i] = walk<Policy, all_sides>(tree, kRoot, rays[i], i, limits[i], consume);
        }
        begin = end;
    }
}

template <class Policy, bool all_sides>
void nearest(const TreeView& tree, const PreparedRay* rays, int count, double* limits, const HitSink& sink) {
    trace<Policy, all_sides>(
        tree, rays, count, limits,
        [&](int index, double, double t, std::uint32_t triangle, bool front, bool double_sided) {
            sink.add(sink.self, index, t, triangle, front, double_sided);
            return t;
        });
}

template <class Policy>
void all(const TreeView& tree, const PreparedRay* rays, int count, double* limits, const HitSink& sink) {
    trace<Policy, false>(
        tree, rays, count, limits,
        [&](int index, double limit, double t, std::uint32_t triangle, bool front, bool double_sided) {
            sink.add(sink.self, index, t, triangle, front, double_sided);
            return limit;
        });
}

template <class Policy>
void first_hits_of_bundle(const TreeView& tree, double scene_size, const Ray* rays, int ray_count,
                          Hit* hits) {
    PreparedRay prepared[kBatch];
    double limits[kBatch];
    std::uint32_t best[kBatch];
    int place[kBatch];
    int count = 0;
    for (int i = 0; i < ray_count; ++i) {
        hits[i] = {};
        limits[count] = hits[i].t;
        best[count] = kNoTriangle;
        place[count] = i;
        count += Policy::prepare(rays[i], scene_size, prepared[count]);
    }
    trace<Policy, false>(tree, prepared, count, limits,
                         [&](int index, double limit, double t, std::uint32_t triangle, bool, bool) {
                             if (t < limit || triangle < best[index])
                                 best[index] = triangle;
                             return t;
                         });
    for (int i = 0; i < count; ++i)
        hits[place[i]] = {limits[i] * prepared[i].unit, best[i]};
}

template <class Policy>
void first_hit(const TreeView& tree, double scene_size, const Ray& source, Hit& hit) {
    PreparedRay ray;
    hit = {};
    if (!Policy::prepare(source, scene_size, ray) || !tree.nodes)
        return;
    auto consume = [&](int, double limit, double t, std::uint32_t triangle, bool, bool) {
        if (t < limit || triangle < hit.triangle)
            hit.triangle = triangle;
        return t;
    };
    hit.t = walk<Policy, false>(tree, kRoot, ray, 0, hit.t, consume) * ray.unit;
}

/// Less than about 10 degrees apart: worth preparing together.
inline bool look_alike(const Ray& a, const Ray& b) {
    double both = dot(a.direction, b.direction);
    return both > 0 && both * both > 0.97 * (dot(a.direction, a.direction) * dot(b.direction, b.direction));
}

template <class Policy>
void first_hits(const TreeView& tree, double scene_size, std::span<const Ray> rays, std::span<Hit> hits) {
    for (std::size_t begin = 0; begin < rays.size();) {
        std::size_t end = begin + 1;
        while (end < rays.size() && end < begin + kBatch && look_alike(rays[begin], rays[end]))
            ++end;
        if (end - begin >= kWorthwhile)
            first_hits_of_bundle<Policy>(tree, scene_size, &rays[begin], static_cast<int>(end - begin),
                                         &hits[begin]);
        else
            for (std::size_t i = begin; i < end; ++i)
                first_hit<Policy>(tree, scene_size, rays[i], hits[i]);
        begin = end;
    }
}

template <class Policy>
constexpr Kernel make_kernel(const char* name) {
    return {name,        Policy::prepare,      first_hits<Policy>, nearest<Policy, false>,
            all<Policy>, nearest<Policy, true>};
}
