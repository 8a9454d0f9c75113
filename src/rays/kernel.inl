// Walks and tests, generic over a policy that supplies:
//   int  enter(node, ray, limit, distance[kWidth])   bit per child whose box the ray enters at or before
//   `limit` int  cover(block, ray, Candidates&)              bit per lane whose triangle the ray's line
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

/// Calls consume(t, triangle, front, double_sided) for each lane that is hit; consume returns the new limit.
template <bool all_sides, class Consume>
inline void resolve(const Block& block, const PreparedRay& ray, int lanes, const Candidates& candidates,
                    double& limit, Consume&& consume) {
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
            limit = consume(t, block.triangle[lane], front, double_sided);
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

/// Front to back through the tree; `consume` as in resolve().
template <class Policy, bool all_sides, class Consume>
inline void walk(const TreeView& tree, const PreparedRay& ray, double limit, Consume&& consume) {
    if (!tree.nodes)
        return;
    Entry stack[kMaxBvhDepth * (kWidth - 1) + kWidth];
    int depth = 0;
    float limit_above = float_above(limit);
    Entry entry{0, 0, 0};
    for (;;) {
        if (entry.count == 0) {
            const Node& node = tree.nodes[entry.first];
            alignas(64) float distance[kWidth];
            int children = Policy::enter(node, ray, limit_above, distance);
            if (children)
                push_children(node, distance, children, stack, depth);
        } else {
            for (std::uint32_t b = entry.first; b < entry.first + entry.count; ++b) {
                Candidates candidates;
                int lanes = Policy::cover(tree.blocks[b], ray, candidates);
                if (lanes) {
                    resolve<all_sides>(tree.blocks[b], ray, lanes, candidates, limit, consume);
                    limit_above = float_above(limit);
                }
            }
        }
        do {
            if (depth == 0)
                return;
            entry = stack[--depth];
        } while (entry.distance > limit_above);
    }
}

template <class Policy>
void nearest(const TreeView& tree, const PreparedRay& ray, Hit& best) {
    walk<Policy, false>(tree, ray, best.t, [&](double t, std::uint32_t triangle, bool, bool) {
        if (t < best.t || triangle < best.triangle)
            best = {t, triangle};
        return best.t;
    });
}

template <class Policy, bool all_sides>
void nearest_reported(const TreeView& tree, const PreparedRay& ray, Hit& best, const HitSink& sink) {
    walk<Policy, all_sides>(tree, ray, best.t,
                            [&](double t, std::uint32_t triangle, bool front, bool double_sided) {
                                if (t < best.t || triangle < best.triangle)
                                    best = {t, triangle};
                                sink.add(sink.self, t, triangle, front, double_sided);
                                return best.t;
                            });
}

template <class Policy>
void all(const TreeView& tree, const PreparedRay& ray, double limit, const HitSink& sink) {
    walk<Policy, false>(tree, ray, limit,
                        [&](double t, std::uint32_t triangle, bool front, bool double_sided) {
                            sink.add(sink.self, t, triangle, front, double_sided);
                            return limit;
                        });
}

template <class Policy>
void first_hits(const TreeView& tree, double scene_size, std::span<const Ray> rays, std::span<Hit> hits) {
    for (std::size_t i = 0; i < rays.size(); ++i) {
        PreparedRay ray;
        Hit hit;
        if (Policy::prepare(rays[i], scene_size, ray)) {
            nearest<Policy>(tree, ray, hit);
            hit.t *= ray.unit;
        }
        hits[i] = hit;
    }
}

template <class Policy>
constexpr Kernel make_kernel(const char* name) {
    return {name,
            Policy::prepare,
            first_hits<Policy>,
            nearest<Policy>,
            nearest_reported<Policy, false>,
            all<Policy>,
            nearest_reported<Policy, true>};
}
