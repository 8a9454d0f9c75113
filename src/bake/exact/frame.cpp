#include "bake/exact/frame.hpp"

#include <algorithm>
#include <bit>
#include <numeric>

namespace antumbra::exact {
namespace {

bool is_zero(const GridPoint& p) { return p.x == 0 && p.y == 0 && p.z == 0; }

/// Keeps the part of `face` in front of `plane`. False if it has no area.
bool clip(Face& face, const GridPlane& plane) {
    std::size_t n = face.corners.size();
    std::vector<Int128> value(n);
    bool positive = false, negative = false;
    for (std::size_t i = 0; i < n; ++i) {
        value[i] = plane.at(face.corners[i]);
        positive |= value[i] > 0;
        negative |= value[i] < 0;
    }
    face.clipped.clear();
    face.edge.clear();
    face.touches.clear();
    face.is_clipped = negative;
    if (!positive)
        return false;
    auto add = [&](const Homogeneous& p, int edge, bool touches) {
        face.clipped.push_back(p);
        face.edge.push_back(edge);
        face.touches.push_back(touches);
    };
    for (std::size_t i = 0; i < n; ++i) {
        std::size_t j = (i + 1) % n;
        const GridPoint &a = face.corners[i], &b = face.corners[j];
        if (value[i] >= 0) {
            // From a corner in the plane with the next one behind it, the polygon goes on along the plane.
            bool leaves = value[i] == 0 && value[j] < 0;
            add({a.x, a.y, a.z, 1}, leaves ? -1 : static_cast<int>(i), value[i] == 0);
        }
        if ((value[i] > 0 && value[j] < 0) || (value[i] < 0 && value[j] > 0)) {
            Integer wa = abs(Integer(value[j])), wb = abs(Integer(value[i]));
            Homogeneous p = {wa * a.x + wb * b.x, wa * a.y + wb * b.y, wa * a.z + wb * b.z, wa + wb};
            make_primitive(p);
            add(p, value[i] > 0 ? -1 : static_cast<int>(i), true);
        }
    }
    return face.clipped.size() >= 3;
}

} // namespace

GridPlane plane_of(std::span<const GridPoint> corners, std::size_t (&triple)[3]) {
    GridPlane plane;
    // In a convex polygon every non-degenerate triple of corners in order has the same orientation.
    for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
        GridPoint n = cross(corners[i] - corners[0], corners[i + 1] - corners[0]);
        if (is_zero(n))
            continue;
        std::int64_t divisor = std::gcd(std::gcd(n.x, n.y), n.z);
        plane.n = {n.x / divisor, n.y / divisor, n.z / divisor};
        plane.c = plane.at(corners[0]);
        triple[0] = 0;
        triple[1] = i;
        triple[2] = i + 1;
        break;
    }
    return plane;
}

namespace {

int bits_of_wide(Int128 value) {
    auto magnitude = static_cast<Unsigned128>(value < 0 ? -value : value);
    auto high = static_cast<std::uint64_t>(magnitude >> 64);
    return static_cast<int>(high != 0 ? 64 + std::bit_width(high) : std::bit_width(static_cast<std::uint64_t>(magnitude)));
}

int bits_of_normal(const GridPlane& plane) {
    int bits = 0;
    for (int k = 0; k < 3; ++k)
        bits = std::max(bits, bits_of_wide(plane.n[k]));
    return bits;
}

int trailing_zeros(Unsigned128 value) {
    auto low = static_cast<std::uint64_t>(value);
    return low != 0 ? std::countr_zero(low) : 64 + std::countr_zero(static_cast<std::uint64_t>(value >> 64));
}

/// Binary; b != 0.
Unsigned128 gcd_of(Unsigned128 a, Unsigned128 b) {
    if (a == 0)
        return b;
    int shift = std::min(trailing_zeros(a), trailing_zeros(b));
    a >>= trailing_zeros(a);
    b >>= trailing_zeros(b);
    while (a != b) {
        if (a < b)
            std::swap(a, b);
        a -= b;
        a >>= trailing_zeros(a);
    }
    return a << shift;
}

/// As meet(), where 128 bits hold all products: nearly always, if one of the planes is a face of a box.
bool meet_small(const GridPlane& a, const GridPlane& b, Six& out) {
    int na = bits_of_normal(a), nb = bits_of_normal(b);
    if (bits_of_wide(b.c) + na > 124 || bits_of_wide(a.c) + nb > 124)
        return false;
    Int128 line[6];
    for (int k = 0; k < 3; ++k) {
        int i = (k + 1) % 3, j = (k + 2) % 3;
        line[k] = static_cast<Int128>(a.n[i]) * b.n[j] - static_cast<Int128>(a.n[j]) * b.n[i];
        line[k + 3] = b.c * a.n[k] - a.c * b.n[k];
    }
    Unsigned128 divisor = 0;
    for (Int128 value : line)
        if (value != 0 && divisor != 1)
            divisor = gcd_of(divisor, static_cast<Unsigned128>(value < 0 ? -value : value));
    for (std::size_t k = 0; k < 6; ++k)
        out[k] = divisor > 1 ? line[k] / static_cast<Int128>(divisor) : line[k];
    return true;
}

} // namespace

Six meet(const GridPlane& a, const GridPlane& b) {
    Six line;
    if (meet_small(a, b, line))
        return line;
    Integer ca = Integer(a.c), cb = Integer(b.c);
    for (int k = 0; k < 3; ++k) {
        int i = (k + 1) % 3, j = (k + 2) % 3;
        auto d = static_cast<std::size_t>(k);
        line[d] = Integer(a.n[i]) * b.n[j] - Integer(a.n[j]) * b.n[i];
        line[d + 3] = cb * a.n[k] - ca * b.n[k];
    }
    make_primitive(line);
    return line;
}

Six line_through(const Homogeneous& p, const Homogeneous& q) {
    Six line;
    for (std::size_t k = 0; k < 3; ++k) {
        std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
        line[k] = p[3] * q[k] - q[3] * p[k];
        line[k + 3] = p[i] * q[j] - p[j] * q[i];
    }
    return line;
}

bool Frame::set(std::span<const GridPoint> s_corners, std::span<const GridPoint> t_corners) {
    Vec3<std::int64_t> low{INT64_MAX, INT64_MAX, INT64_MAX}, high{INT64_MIN, INT64_MIN, INT64_MIN};
    for (std::span<const GridPoint> corners : {s_corners, t_corners})
        for (const GridPoint& p : corners)
            for (int k = 0; k < 3; ++k) {
                low[k] = std::min(low[k], p[k]);
                high[k] = std::max(high[k], p[k]);
            }
    std::int64_t extent = 1;
    for (int k = 0; k < 3; ++k) {
        origin[k] = low[k] + (high[k] - low[k]) / 2;
        extent = std::max({extent, high[k] - origin[k], origin[k] - low[k]});
    }
    scale_bits = 0;
    while ((std::int64_t(1) << scale_bits) < extent)
        ++scale_bits;
    auto place = [&](Face& face, std::span<const GridPoint> corners) {
        face.corners.clear();
        face.half_spaces.clear();
        std::size_t n = corners.size();
        for (std::size_t i = 0; i < n; ++i) { // corners inside an edge would be no vertices of anything
            GridPoint turn = cross(corners[i] - corners[(i + n - 1) % n], corners[(i + 1) % n] - corners[i]);
            if (!is_zero(turn))
                face.corners.push_back(corners[i] - origin);
        }
        face.plane = plane_of(face.corners, face.triple);
        return !is_zero(face.plane.n);
    };
    common = -1;
    lines.clear();
    return place(s, s_corners) && place(t, t_corners) && clip(s, t.plane) && clip(t, s.plane);
}

template <bool F>
void Frame::fill(LineStore<F>& store) {
    common_line = meet(s.plane, t.plane);
    auto add_edges = [&](Face& face, int crossing) {
        std::size_t n = face.clipped.size();
        for (std::size_t i = 0; i < n; ++i) {
            HalfSpace half{};
            if (face.edge[i] >= 0) {
                auto e = static_cast<std::size_t>(face.edge[i]);
                half = store.edge(face.corners[e], face.corners[(e + 1) % face.corners.size()]);
                half.sign *= crossing;
            } else {
                if (common < 0)
                    common = store.hyperplane(dual(common_line));
                // meet(s, t) runs so that the front of S lies to its left in T, seen from T's front. In S it runs
                // the other way round.
                half = {common, &face == &t ? crossing : -crossing};
            }
            face.half_spaces.push_back(half);
        }
    };
    // Lines cross S from its back to its front, and T from its front to its back.
    add_edges(s, 1);
    add_edges(t, -1);
    bool small = !s.is_clipped && !t.is_clipped;
    for (std::size_t i = 0; i < s.clipped.size(); ++i)
        for (std::size_t j = 0; j < t.clipped.size(); ++j) {
            int a = static_cast<int>(i), b = static_cast<int>(j);
            if (small)
                lines.push_back(store.line(pluecker_through(s.corners[i], t.corners[j]), a, b));
            else {
                Six six = line_through(s.clipped[i], t.clipped[j]);
                make_primitive(six);
                lines.push_back(store.line(six, a, b));
            }
        }
}

std::vector<GridPlane> Frame::planes_around() const {
    std::vector<GridPlane> planes;
    auto add = [&](const GridPoint& a, const GridPoint& b, const GridPoint& c) {
        GridPoint corners[3] = {a, b, c};
        std::size_t triple[3];
        GridPlane plane = plane_of(corners, triple);
        bool front = false, back = false;
        for (const Face* face : {&s, &t})
            for (const GridPoint& p : face->corners) {
                Int128 at = plane.at(p);
                front |= at > 0;
                back |= at < 0;
            }
        if (front == back)
            return;
        if (front) {
            plane.n = -plane.n;
            plane.c = -plane.c;
        }
        planes.push_back(plane);
    };
    for (bool swapped : {false, true}) {
        const Face &edges = swapped ? t : s, &tips = swapped ? s : t;
        for (std::size_t i = 0; i < edges.corners.size(); ++i)
            for (const GridPoint& tip : tips.corners)
                add(edges.corners[i], edges.corners[(i + 1) % edges.corners.size()], tip);
    }
    // Behind S no segment begins, behind T none goes on.
    for (const Face* face : {&s, &t}) {
        GridPlane plane = face->plane;
        plane.n = -plane.n;
        plane.c = -plane.c;
        planes.push_back(plane);
    }
    return planes;
}

template void Frame::fill(LineStore<true>&);
template void Frame::fill(LineStore<false>&);

bool Frame::s_touches() const { return std::find(s.touches.begin(), s.touches.end(), true) != s.touches.end(); }
bool Frame::t_touches() const { return std::find(t.touches.begin(), t.touches.end(), true) != t.touches.end(); }

} // namespace antumbra::exact
