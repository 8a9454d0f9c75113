// More queries with known answers: four slits, holes, boxes with a face missing, and affine maps.
#include "exact/families.hpp"

#include <algorithm>

namespace antumbra::exact::testing {
namespace {

/// A line a(s) = at + s * along, s in [0, 1], in a plane spanned by `along` and `across`.
struct Slit {
    Vec3d at, along, across;
};

Slit random_slit(Random& random, double z) {
    Slit slit;
    double angle = random.uniform(0, 3.14), x = random.uniform(0.3, 0.7), y = random.uniform(0.3, 0.7);
    slit.along = {std::cos(angle), std::sin(angle), random.uniform(-0.3, 0.3)};
    slit.across = cross(normalized(slit.along), normalized(Vec3d{random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2), 1}));
    slit.at = Vec3d{x, y, z} - slit.along * 0.5;
    return slit;
}

/// Positive on one side of the oriented line through p and q, negative on the other: where the line a passes.
double side_of(const Vec3d& p, const Vec3d& d, const Slit& a) { return dot(cross(a.at - p, a.along), d); }

/// Where on a slit the line p + t d comes closest; its parameter and that of the line.
void closest(const Vec3d& p, const Vec3d& d, const Slit& a, double& on_slit, double& on_line) {
    Vec3d n = cross(d, a.along), r = a.at - p;
    on_slit = dot(cross(r, d), n) / dot(n, n);
    on_line = dot(cross(r, a.along), n) / dot(n, n);
}

/// How many lines meet all four slits within their extents; -1 if that is too close to call.
int count_transversals(const Slit (&a)[4]) {
    constexpr int kSteps = 4000;
    int found = 0;
    double last = 0;
    for (int k = 0; k <= kSteps; ++k) {
        // The one line through this point of a[0] that meets a[1] and a[2].
        Vec3d p = a[0].at + a[0].along * (double(k) / kSteps);
        Vec3d d = cross(cross(p - a[1].at, a[1].along), cross(p - a[2].at, a[2].along));
        if (d.z < 0)
            d = -d;
        double now = side_of(p, d, a[3]) / length(d);
        bool crosses = k > 0 && (last < 0) != (now < 0);
        last = now;
        if (!crosses)
            continue;
        double margin = 1, before = 0;
        bool inside = true;
        for (int j = 1; j < 4; ++j) {
            double s, t;
            closest(p, d, a[j], s, t);
            margin = std::min({margin, std::abs(s), std::abs(s - 1)});
            inside &= s > 0 && s < 1 && t > before;
            before = t;
        }
        margin = std::min({margin, double(k) / kSteps, 1 - double(k) / kSteps});
        if (margin < 0.03)
            return -1; // near the end of a slit
        found += inside;
    }
    return found;
}

/// A wall in the slit's plane with an opening along it, `width` wide.
void add_slit_wall(Case& c, const Slit& a, double width) {
    auto at = [&](double along, double across) {
        Vec3d p = a.at + a.along * along + a.across * across;
        return grid(p.x, p.y, p.z);
    };
    const double x[4] = {-2, 0, 1, 3}, y[4] = {-3, -width, width, 3};
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            if (i != 1 || j != 1)
                add_quad(c, at(x[i], y[j]), at(x[i + 1], y[j]), at(x[i + 1], y[j + 1]), at(x[i], y[j + 1]));
}

std::vector<GridPoint> thin_triangle(const Slit& a, double width) {
    Vec3d q = a.at + a.along, m = a.at + a.along * 0.5 + a.across * width;
    return {grid(a.at.x, a.at.y, a.at.z), grid(q.x, q.y, q.z), grid(m.x, m.y, m.z)};
}

TEST(KnownAnswers, FourSlitsAreSeenThroughIffALineMeetsThemAll) {
    Random random(41);
    int seen = 0, hidden = 0;
    for (int k = 0; k < 400 && seen + hidden < 120; ++k) {
        Slit a[4];
        for (int j = 0; j < 4; ++j)
            a[j] = random_slit(random, j);
        // Distance of the nearest miss: a hidden case must be clearly so.
        double least = 1e9;
        for (int step = 0; step <= 400; ++step) {
            Vec3d p = a[0].at + a[0].along * (step / 400.0);
            Vec3d d = cross(cross(p - a[1].at, a[1].along), cross(p - a[2].at, a[2].along));
            least = std::min(least, std::abs(side_of(p, d, a[3])) / length(d));
        }
        int count = count_transversals(a);
        if (count < 0 || (count == 0 && least < 0.1))
            continue;
        Case c;
        c.s = thin_triangle(a[0], 0.002);
        c.t = thin_triangle(a[3], 0.002);
        face_each_other(c);
        add_slit_wall(c, a[1], 0.002);
        add_slit_wall(c, a[2], 0.002);
        EXPECT_EQ(proved_visible(c), count > 0) << "case " << k << ", transversals " << count;
        ++(count > 0 ? seen : hidden);
    }
    EXPECT_GT(seen, 10);
    EXPECT_GT(hidden, 10);
}

TEST(KnownAnswers, AWallIsSeenThroughWhereOneOfItsTrianglesShrinks) {
    Random random(42);
    int tried = 0;
    for (int k = 0; k < 60 && tried < 30; ++k) {
        Case c = square_and_triangle(random);
        GridPoint centre{0, 0, 0};
        for (const GridPoint& corner : c.t)
            centre = centre + corner;
        Vec3d q{double(centre.x) / 3, double(centre.y) / 3, double(centre.z) / 3};
        // A flat wall: a corner of one of its triangles lies well inside the shaft from T's centre.
        constexpr int n = 8;
        const double z = 0.6, low = -1.2, cell = 3.4 / n;
        GridPoint g[n + 1][n + 1];
        for (int i = 0; i <= n; ++i)
            for (int j = 0; j <= n; ++j)
                g[i][j] = grid(low + cell * (i + random.uniform(-0.2, 0.2)), low + cell * (j + random.uniform(-0.2, 0.2)), z);
        std::size_t chosen = SIZE_MAX;
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j) {
                Vec3d v{double(g[i][j].x), double(g[i][j].y), double(g[i][j].z)};
                Vec3d p = q + (v - q) * (q.z / (q.z - v.z));
                if (chosen == SIZE_MAX && p.x > 0.2 * kOne && p.x < 0.8 * kOne && p.y > 0.2 * kOne && p.y < 0.8 * kOne)
                    chosen = c.occluders.size();
                add_quad(c, g[i][j], g[i + 1][j], g[i + 1][j + 1], g[i][j + 1]);
            }
        if (chosen == SIZE_MAX)
            continue;
        ++tried;
        EXPECT_FALSE(proved_visible(c)) << k;
        // Shrunk about its centroid by f: the ring that this leaves is seen through down to single grid units.
        for (double f : {0.5, 1 - 1e-3, 1 - 1e-4}) {
            Case open = c;
            std::vector<GridPoint>& t = open.occluders[chosen].corners;
            GridPoint sum = t[0] + t[1] + t[2];
            for (GridPoint& corner : t)
                for (int axis = 0; axis < 2; ++axis)
                    corner[axis] = std::llround(double(sum[axis]) / 3 + f * (double(corner[axis]) - double(sum[axis]) / 3));
            EXPECT_TRUE(proved_visible(open)) << k << " f " << f;
        }
    }
    EXPECT_GE(tried, 20);
}

TEST(KnownAnswers, ABoxIsSeenIntoThroughItsMissingTriangleOnly) {
    Random random(43);
    const int faces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    auto corner = [](int i) { return grid(i & 1 ? 1 : 0, i & 2 ? 1 : 0, i & 4 ? 1 : 0); };
    for (int missing = 0; missing < 12; ++missing)
        for (int k = 0; k < 4; ++k) {
            Case c;
            Vec3d hole{0, 0, 0};
            for (int t = 0; t < 12; ++t) {
                const int* f = faces[t / 2];
                GridPoint p[3] = {corner(f[0]), corner(f[1 + t % 2]), corner(f[2 + t % 2])};
                if (t != missing)
                    add_triangle(c, p[0], p[1], p[2]);
                else
                    for (const GridPoint& q : p)
                        hole = hole + Vec3d{double(q.x), double(q.y), double(q.z)} / 3.0 / double(kOne);
            }
            Vec3d eye{random.uniform(0.4, 0.6), random.uniform(0.4, 0.6), random.uniform(0.4, 0.6)};
            for (bool through : {true, false}) {
                // Beyond the hole as seen from the eye, or on the other side of the box.
                Vec3d toward = hole - eye, far = through ? eye + toward * 4.0 : eye - toward * 4.0;
                Vec3d u = normalized(cross(toward, Vec3d{0.3, 0.5, 0.8})), v = normalized(cross(toward, u));
                auto triangle = [&](const Vec3d& at) {
                    std::vector<GridPoint> t;
                    for (int i = 0; i < 3; ++i) {
                        Vec3d p = at + u * (0.02 * std::cos(2.1 * i)) + v * (0.02 * std::sin(2.1 * i));
                        t.push_back(grid(p.x, p.y, p.z));
                    }
                    return t;
                };
                c.s = triangle(eye);
                c.t = triangle(far);
                face_each_other(c);
                EXPECT_EQ(proved_visible(c), through) << missing << " " << k;
            }
        }
}

TEST(Metamorphic, AffineMapsOfTheGridChangeNothing) {
    Random random(44);
    for (int k = 0; k < 300; ++k) {
        Case c = tiny_soup(random, 6, 8, k % 2);
        // A product of shears: whole numbers, determinant 1.
        std::int64_t m[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
        for (int shear = 0; shear < 3; ++shear) {
            std::uint32_t from = random.below(3), to = (from + 1 + random.below(2)) % 3;
            std::int64_t by = pick(random, -3, 3);
            for (auto& row : m)
                row[to] += by * row[from];
        }
        auto map = [&](const GridPoint& p) {
            GridPoint q;
            for (int i = 0; i < 3; ++i)
                q[i] = m[i][0] * p.x + m[i][1] * p.y + m[i][2] * p.z;
            return q;
        };
        Case mapped = c;
        for (std::vector<GridPoint>* polygon : {&mapped.s, &mapped.t})
            for (GridPoint& p : *polygon)
                p = map(p);
        for (Polygon& occluder : mapped.occluders)
            for (GridPoint& p : occluder.corners)
                p = map(p);
        EXPECT_EQ(proved_visible(c), proved_visible(mapped)) << k;
    }
}

} // namespace
} // namespace antumbra::exact::testing
