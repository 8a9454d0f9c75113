#include "generate/modeller.hpp"

namespace antumbra::generation {
namespace {

/// sin(x * quarter turn) for x in [0, 1]: the Taylor series, whose terms beyond the 25th power vanish in
/// double.
double sine_of_quarter(double x) {
    constexpr double kHalfPi = 1.5707963267948966;
    double angle = x * kHalfPi, square = angle * angle;
    double sum = 0;
    for (int n = 25; n >= 3; n -= 2)
        sum = -(sum + 1) * square / (double(n) * (n - 1));
    return angle * (sum + 1);
}

Vec3d oriented(Axis axis, Vec2 p, double along) {
    int k = static_cast<int>(axis);
    Vec3d v;
    v[k] = along;
    v[(k + 1) % 3] = p.x;
    v[(k + 2) % 3] = p.y;
    return v;
}

double area(Vec2 a, Vec2 b, Vec2 c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

bool inside(Vec2 p, Vec2 a, Vec2 b, Vec2 c) {
    return area(a, b, p) >= 0 && area(b, c, p) >= 0 && area(c, a, p) >= 0;
}

/// Ear clipping, O(n^3) at worst, for the few corners of a wall or a roof. `visit(i, j, k)` takes corner
/// numbers.
template <class Visit>
void triangulate(std::span<const Vec2> outline, Visit&& visit) {
    std::vector<std::uint32_t> left(outline.size());
    for (std::uint32_t i = 0; i < left.size(); ++i)
        left[i] = i;
    while (left.size() >= 3) {
        std::size_t n = left.size(), ear = n;
        for (std::size_t i = 0; i < n && ear == n; ++i) {
            std::uint32_t a = left[(i + n - 1) % n], b = left[i], c = left[(i + 1) % n];
            bool is_ear = area(outline[a], outline[b], outline[c]) > 0;
            for (std::uint32_t other : left)
                if (is_ear && other != a && other != b && other != c)
                    is_ear = !inside(outline[other], outline[a], outline[b], outline[c]);
            if (is_ear)
                ear = i;
        }
        assert(ear < n && "the outline must be simple and counter-clockwise");
        if (ear == n)
            ear = 0; // keeps the solid closed even so
        visit(left[(ear + n - 1) % n], left[ear], left[(ear + 1) % n]);
        left.erase(left.begin() + static_cast<std::ptrdiff_t>(ear));
    }
}

} // namespace

double sine(double turns) {
    double quarters = (turns - std::floor(turns)) * 4;
    int quadrant = static_cast<int>(quarters);
    double x = quarters - quadrant;
    switch (quadrant & 3) {
    case 0:
        return x == 0 ? 0 : sine_of_quarter(x);
    case 1:
        return x == 0 ? 1 : sine_of_quarter(1 - x);
    case 2:
        return x == 0 ? 0 : -sine_of_quarter(x);
    default:
        return x == 0 ? -1 : -sine_of_quarter(1 - x);
    }
}

double cosine(double turns) {
    return sine(turns + 0.25);
}

Frame at(const Vec3d& origin) {
    return {origin};
}

Frame turned(const Vec3d& origin, double turns) {
    double s = sine(turns), c = cosine(turns);
    return {origin, {c, 0, -s}, {0, 1, 0}, {s, 0, c}};
}

Frame looking(const Vec3d& origin, const Vec3d& direction) {
    Frame frame;
    frame.origin = origin;
    frame.z = direction / length(direction);
    // The helper axis is the one that the direction follows least.
    Vec3d helper = std::abs(frame.z.y) < 0.9 ? Vec3d{0, 1, 0} : Vec3d{1, 0, 0};
    Vec3d x = cross(helper, frame.z);
    frame.x = x / length(x);
    frame.y = cross(frame.z, frame.x);
    return frame;
}

Modeller::Modeller(std::string source, double grid) : grid_(grid) {
    scene_.source = std::move(source);
}

void Modeller::begin(std::string name, std::uint32_t flags) {
    RawObject object;
    object.id.node = static_cast<std::int32_t>(scene_.objects.size());
    object.id.primitive = 0;
    object.name = std::move(name);
    object.flags = flags;
    object.first_triangle = static_cast<std::uint32_t>(scene_.triangles.size());
    scene_.objects.push_back(std::move(object));
}

std::uint32_t Modeller::vertex(const Vec3d& local) {
    Vec3d world = frame_.apply(local);
    auto snap = [&](double value) { return std::floor(value / grid_ + 0.5) * grid_; };
    scene_.positions.push_back({snap(world.x), snap(world.y), snap(world.z)});
    return static_cast<std::uint32_t>(scene_.positions.size() - 1);
}

void Modeller::triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    scene_.triangles.push_back({a, b, c});
    ++scene_.objects.back().triangle_count;
}

void Modeller::quad(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    triangle(a, b, c);
    triangle(a, c, d);
}

void Modeller::fan(std::span<const std::uint32_t> ring, bool reversed) {
    for (std::size_t i = 1; i + 1 < ring.size(); ++i)
        reversed ? triangle(ring[0], ring[i + 1], ring[i]) : triangle(ring[0], ring[i], ring[i + 1]);
}

/// Joins two rings that run counter-clockwise seen from above.
void Modeller::band(std::span<const std::uint32_t> lower, std::span<const std::uint32_t> upper) {
    for (std::size_t i = 0; i < lower.size(); ++i) {
        std::size_t j = (i + 1) % lower.size();
        quad(lower[i], lower[j], upper[j], upper[i]);
    }
}

void Modeller::box(const Vec3d& low, const Vec3d& high) {
    Vec3d corners[8];
    for (int i = 0; i < 8; ++i)
        corners[i] = Box3d{low, high}.corner(i);
    hexahedron(corners);
}

void Modeller::hexahedron(std::span<const Vec3d> corners) {
    std::uint32_t v[8];
    for (std::size_t i = 0; i < 8; ++i)
        v[i] = vertex(corners[i]);
    quad(v[0], v[4], v[6], v[2]);
    quad(v[1], v[3], v[7], v[5]);
    quad(v[0], v[1], v[5], v[4]);
    quad(v[2], v[6], v[7], v[3]);
    quad(v[0], v[2], v[3], v[1]);
    quad(v[4], v[5], v[7], v[6]);
}

void Modeller::open_box(const Vec3d& low, const Vec3d& high, double thickness, Axis open) {
    int k = static_cast<int>(open), a = (k + 1) % 3, b = (k + 2) % 3;
    // Four rings: outer bottom, outer top, inner top, inner bottom, each counter-clockwise seen from +axis.
    auto ring = [&](double along, double inset) {
        std::array<std::uint32_t, 4> v{};
        Vec2 l{low[a] + inset, low[b] + inset}, h{high[a] - inset, high[b] - inset};
        Vec2 corners[4] = {{l.x, l.y}, {h.x, l.y}, {h.x, h.y}, {l.x, h.y}};
        for (std::size_t i = 0; i < 4; ++i)
            v[i] = vertex(oriented(open, corners[i], along));
        return v;
    };
    auto bottom = ring(low[k], 0), top = ring(high[k], 0), rim = ring(high[k], thickness),
         ground = ring(low[k] + thickness, thickness);
    fan(bottom, true);
    band(bottom, top);
    band(top, rim);
    band(rim, ground);
    fan(ground, false);
}

void Modeller::ring(Axis axis, Vec2 outer_low, Vec2 outer_high, Vec2 hole_low, Vec2 hole_high, double low,
                    double high) {
    auto loop = [&](Vec2 l, Vec2 h, double along) {
        std::array<std::uint32_t, 4> v{};
        Vec2 corners[4] = {{l.x, l.y}, {h.x, l.y}, {h.x, h.y}, {l.x, h.y}};
        for (std::size_t i = 0; i < 4; ++i)
            v[i] = vertex(oriented(axis, corners[i], along));
        return v;
    };
    auto bottom = loop(outer_low, outer_high, low), top = loop(outer_low, outer_high, high),
         hole_top = loop(hole_low, hole_high, high), hole_bottom = loop(hole_low, hole_high, low);
    band(bottom, top);
    band(top, hole_top);
    band(hole_top, hole_bottom);
    band(hole_bottom, bottom);
}

void Modeller::extrude(Axis axis, std::span<const Vec2> outline, double low, double high) {
    std::vector<std::uint32_t> bottom, top;
    for (Vec2 p : outline)
        bottom.push_back(vertex(oriented(axis, p, low)));
    for (Vec2 p : outline)
        top.push_back(vertex(oriented(axis, p, high)));
    band(bottom, top);
    triangulate(outline, [&](std::uint32_t i, std::uint32_t j, std::uint32_t k) {
        triangle(top[i], top[j], top[k]);
        triangle(bottom[i], bottom[k], bottom[j]);
    });
}

void Modeller::star(Axis axis, std::span<const Vec2> outline, double low, double high) {
    std::vector<std::uint32_t> bottom, top;
    for (Vec2 p : outline)
        bottom.push_back(vertex(oriented(axis, p, low)));
    for (Vec2 p : outline)
        top.push_back(vertex(oriented(axis, p, high)));
    std::uint32_t below = vertex(oriented(axis, {}, low)), above = vertex(oriented(axis, {}, high));
    band(bottom, top);
    for (std::size_t i = 0; i < outline.size(); ++i) {
        std::size_t j = (i + 1) % outline.size();
        triangle(above, top[i], top[j]);
        triangle(below, bottom[j], bottom[i]);
    }
}

void Modeller::lathe(Axis axis, std::span<const Vec2> profile, int sides) {
    std::vector<std::uint32_t> previous;
    std::uint32_t pole = 0;
    bool after_pole = false;
    for (std::size_t p = 0; p < profile.size(); ++p) {
        double radius = profile[p].x, height = profile[p].y;
        if (radius == 0) {
            pole = vertex(oriented(axis, {}, height));
            after_pole = p == 0;
            for (std::size_t i = 0; !after_pole && i < previous.size(); ++i)
                triangle(previous[i], previous[(i + 1) % previous.size()], pole);
            continue;
        }
        std::vector<std::uint32_t> ring;
        for (int i = 0; i < sides; ++i) {
            // Half a step of turn lays a side, not a corner, toward the axes.
            double turns = (i + 0.5) / sides;
            ring.push_back(vertex(oriented(axis, {radius * cosine(turns), radius * sine(turns)}, height)));
        }
        if (after_pole)
            for (std::size_t i = 0; i < ring.size(); ++i)
                triangle(ring[(i + 1) % ring.size()], ring[i], pole);
        else if (p == 0)
            fan(ring, true);
        else
            band(previous, ring);
        after_pole = false;
        if (p + 1 == profile.size())
            fan(ring, false);
        previous = std::move(ring);
    }
}

void Modeller::cylinder(Axis axis, double radius, double low, double high, int sides) {
    Vec2 profile[2] = {{radius, low}, {radius, high}};
    lathe(axis, profile, sides);
}

void Modeller::tube(std::span<const Vec3d> path, std::span<const double> radii, int sides) {
    // The side axis is carried along the path (parallel transport), so that the tube never twists.
    Vec3d direction = path[1] - path[0];
    Vec3d side = looking(path[0], direction).x;
    std::vector<std::uint32_t> previous;
    for (std::size_t p = 0; p < path.size(); ++p) {
        std::size_t before = p == 0 ? 0 : p - 1, after = p + 1 == path.size() ? p : p + 1;
        direction = normalized(path[after] - path[before]);
        side = normalized(side - direction * dot(side, direction));
        Vec3d up = cross(direction, side);
        double radius = radii[radii.size() == 1 ? 0 : p];
        std::vector<std::uint32_t> ring;
        for (int i = 0; i < sides; ++i) {
            double turns = (i + 0.5) / sides;
            ring.push_back(vertex(path[p] + side * (radius * cosine(turns)) + up * (radius * sine(turns))));
        }
        p == 0 ? fan(ring, true) : band(previous, ring);
        if (p + 1 == path.size())
            fan(ring, false);
        previous = std::move(ring);
    }
}

void Modeller::octahedron(const Vec3d& centre, const Vec3d& radii) {
    Vec3d x{radii.x, 0, 0}, y{0, radii.y, 0}, z{0, 0, radii.z};
    std::uint32_t equator[4] = {vertex(centre + x), vertex(centre - z), vertex(centre - x),
                                vertex(centre + z)};
    std::uint32_t top = vertex(centre + y), bottom = vertex(centre - y);
    for (std::size_t i = 0; i < 4; ++i) {
        triangle(equator[i], equator[(i + 1) % 4], top);
        triangle(equator[(i + 1) % 4], equator[i], bottom);
    }
}

void Modeller::leaf(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    triangle(vertex(a), vertex(b), vertex(c));
}

} // namespace antumbra::generation
