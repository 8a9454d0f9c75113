// Queries whose answer is known without the solver (design: exact-visibility, part 2 section 7; part 1.5).
#include "exact/families.hpp"

namespace antumbra::exact::testing {
namespace {

TEST(KnownAnswers, NothingInBetweenIsVisible) {
    Random random(1);
    for (int k = 0; k < 20; ++k)
        EXPECT_TRUE(proved_visible(square_and_triangle(random)));
}

TEST(KnownAnswers, PolygonsThatTurnTheirBacksAreHidden) {
    Case c;
    c.s = {grid(0, 0, 0), grid(0, 1, 0), grid(1, 1, 0)};
    c.t = {grid(0, 0, 2), grid(1, 1, 2), grid(0, 1, 2)};
    face_each_other(c);
    EXPECT_TRUE(proved_visible(c));
    std::swap(c.t[0], c.t[1]);
    EXPECT_FALSE(proved_visible(c));
    std::swap(c.t[0], c.t[1]);
    std::swap(c.s[0], c.s[1]);
    EXPECT_FALSE(proved_visible(c));
}

TEST(KnownAnswers, ClosedJitteredWallsHide) {
    Random random(2);
    for (int n = 1; n <= 8; ++n)
        for (int k = 0; k < 4; ++k) {
            Case c = square_and_triangle(random);
            add_wall(c, random, n, random.uniform(0.4, 0.9));
            EXPECT_FALSE(proved_visible(c, n <= 4 ? with_certificate() : fast())) << "n " << n;
        }
}

/// The point where the segment from a random point of S to the centre of T is at height z.
GridPoint point_in_shaft(const Case& c, Random& random, double z) {
    double p[3] = {random.uniform(0.3, 0.6), random.uniform(0.3, 0.6), 0}, q[3] = {0, 0, 0};
    for (const GridPoint& corner : c.t)
        for (int k = 0; k < 3; ++k)
            q[k] += static_cast<double>(corner[k]) / kOne / 3;
    double t = z / q[2];
    return grid(p[0] + (q[0] - p[0]) * t, p[1] + (q[1] - p[1]) * t, z);
}

TEST(KnownAnswers, AGapOfOneGridUnitIsSeenAndClosedItIsNot) {
    Random random(3);
    for (int k = 0; k < 30; ++k) {
        Case c = square_and_triangle(random);
        Grid g = add_wall(c, random, 4, 0.6);
        GridPoint inside = point_in_shaft(c, random, 0.6);
        for (Polygon& o : c.occluders)
            for (GridPoint& corner : o.corners)
                if (corner == g[2][2])
                    corner = inside;
        // The wall stays closed although the moved corner may fold it.
        Case open = c;
        for (Polygon& o : open.occluders) {
            GridPoint* moved = nullptr;
            GridPoint sum{0, 0, 0};
            for (GridPoint& corner : o.corners) {
                sum += corner;
                if (corner == inside)
                    moved = &corner;
            }
            if (!moved)
                continue;
            GridPoint d = sum - inside - inside - inside;
            moved->x += d.x > 0 ? 1 : -1;
            moved->y += d.y > 0 ? 1 : -1;
            break;
        }
        EXPECT_FALSE(proved_visible(c)) << k;
        EXPECT_TRUE(proved_visible(open)) << k;
    }
}

TEST(KnownAnswers, AnAxisAlignedWallThatEndsExactlyWithTheShaftHides) {
    for (int n = 1; n <= 4; ++n)
        for (int k = 0; k < 8; ++k) {
            Case c;
            c.s = {{0, 0, 0}, {kOne, 0, 0}, {kOne, kOne, 0}, {0, kOne, 0}};
            std::int64_t z = 2 * kOne, x = (k & 1) * kOne, y = (k >> 1 & 1) * kOne;
            c.t = {{x, y, z}, {x, y + kOne, z}, {x + kOne, y + kOne, z}, {x + kOne, y, z}};
            std::int64_t reach = k & 4 ? kOne + kOne / 2 : 2 * kOne;
            for (int i = 0; i < n; ++i)
                for (int j = 0; j < n; ++j) {
                    auto at = [&](int a, int b) { return GridPoint{reach * a / n, reach * b / n, kOne}; };
                    add_quad(c, at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
                }
            EXPECT_FALSE(proved_visible(c)) << n << " " << k;
        }
}

TEST(KnownAnswers, ATJunctionHidesUnlessItsVertexIsOneUnitOff) {
    Random random(4);
    for (int off : {0, 1, -1})
        for (int k = 0; k < 12; ++k) {
            Case c = square_and_triangle(random);
            std::int64_t z = std::llround(random.uniform(0.4, 0.8) * kOne) & ~1;
            std::int64_t x = std::llround(random.uniform(0.3, 0.5) * kOne) & ~3;
            std::int64_t low = -4 * kOne, high = 6 * kOne;
            std::int64_t rise = std::llround(random.uniform(-0.1, 0.1) * kOne) * 4;
            GridPoint a{x, low, z}, b{x, high, z + rise}, middle{x + off, (low + high) / 2, z + rise / 2};
            GridPoint right_low{high, low, z}, right_high{high, high, z + rise}, right{high, middle.y, middle.z};
            add_quad(c, {low, low, z}, a, b, {low, high, z + rise});
            add_quad(c, a, right_low, right, middle);
            add_quad(c, middle, right, right_high, b);
            // The sliver a, middle, b lies at the middle of y, far outside of the shaft unless it reaches it: it is
            // as long as the wall, so the shaft crosses it wherever its width is not zero.
            EXPECT_EQ(proved_visible(c), off > 0) << off << " " << k;
        }
}

TEST(KnownAnswers, AnUmbrellaHidesWhateverTheNumberOfItsRibs) {
    Random random(5);
    for (int ribs = 3; ribs < 12; ++ribs)
        for (int k = 0; k < 3; ++k) {
            Case c = square_and_triangle(random);
            GridPoint hub = grid(random.uniform(0.3, 0.7), random.uniform(0.3, 0.7), random.uniform(0.4, 0.8));
            std::vector<GridPoint> rim;
            for (int i = 0; i < ribs; ++i)
                // The coordinates must stay below 2^24: a rim seven units out, nearly level, around the whole shaft.
                rim.push_back(grid(0.5 + 7 * std::cos(6.2831853 * i / ribs), 0.5 + 7 * std::sin(6.2831853 * i / ribs),
                                   random.uniform(0.5, 0.7)));
            for (int i = 0; i < ribs; ++i)
                add_triangle(c, hub, rim[static_cast<std::size_t>(i)], rim[static_cast<std::size_t>((i + 1) % ribs)]);
            EXPECT_FALSE(proved_visible(c)) << ribs;
        }
}

TEST(KnownAnswers, GrazingLinesAreSeenThroughAGapOfOneUnitOnly) {
    // S on z = 0, T upright beyond it, reaching down to `low`; a wall between them whose foot is at z = gap.
    for (int low : {0, -1, 1})
        for (int gap : {0, 1, -5})
            for (int k = 0; k < 12; ++k) {
                Case c;
                c.s = {{0, 0, 0}, {kOne, 0, 0}, {kOne, kOne, 0}, {0, kOne, 0}};
                std::int64_t x = 2 * kOne + (k % 2) * 12345, foot = low * kOne / 4, lean = k / 4 % 2 ? 1000 + k : 0;
                c.t = {{x, 0, foot}, {x, kOne, foot}, {x + lean, kOne, kOne}, {x + lean, 0, kOne}};
                face_each_other(c);
                std::int64_t wall = kOne + kOne / 2, bottom = gap < 0 ? gap * kOne : gap;
                int parts = k % 3 + 1;
                for (int i = 0; i < parts; ++i) {
                    std::int64_t y0 = -7 * kOne + i * 15 * kOne / parts, y1 = -7 * kOne + (i + 1) * 15 * kOne / parts;
                    add_quad(c, {wall, y0, bottom}, {wall, y1, bottom}, {wall, y1, 4 * kOne}, {wall, y0, 4 * kOne});
                }
                EXPECT_EQ(proved_visible(c), gap > 0 && low <= 0) << low << " " << gap << " " << k;
            }
}

TEST(KnownAnswers, FacesThatBothTouchTheCommonLine) {
    // S ends on the line x = 2, z = 0 and so does T; a wall between them reaches the line, or ends one unit short.
    for (int gap : {0, 1})
        for (int k = 0; k < 6; ++k) {
            Case c;
            c.s = {{kOne, 0, 0}, {2 * kOne, 0, 0}, {2 * kOne, kOne, 0}, {kOne, kOne, 0}};
            std::int64_t y = 2 * kOne + k * 1000;
            c.t = {{2 * kOne, y, 0}, {2 * kOne, y + kOne, 0}, {2 * kOne, y + kOne, kOne}, {2 * kOne, y, kOne}};
            face_each_other(c);
            std::int64_t w = kOne + kOne / 2, right = 2 * kOne - gap;
            add_quad(c, {-7 * kOne, w, 0}, {right, w, 0}, {right, w, 7 * kOne}, {-7 * kOne, w, 7 * kOne});
            EXPECT_EQ(proved_visible(c), gap > 0) << k;
        }
}

using certify::Rational;
using Polygon2 = std::vector<std::array<Rational, 2>>;

/// Keeps a x + b y >= c.
Polygon2 cut(const Polygon2& p, const Rational& a, const Rational& b, const Rational& c) {
    Polygon2 out;
    for (std::size_t i = 0; i < p.size(); ++i) {
        const auto &u = p[i], &v = p[(i + 1) % p.size()];
        Rational at_u = a * u[0] + b * u[1] - c, at_v = a * v[0] + b * v[1] - c;
        if (at_u >= 0)
            out.push_back(u);
        if (at_u * at_v < 0) {
            Rational t = at_u / (at_u - at_v);
            out.push_back({u[0] + (v[0] - u[0]) * t, u[1] + (v[1] - u[1]) * t});
        }
    }
    return out;
}

bool has_area(const Polygon2& p) {
    Rational sum = 0;
    for (std::size_t i = 0; i < p.size(); ++i) {
        const auto &u = p[i], &v = p[(i + 1) % p.size()];
        sum += u[0] * v[1] - u[1] * v[0];
    }
    return sum != 0;
}

/// Is there an open set of (u, s) in [0, one]^2 with low1 < u (1 - z1) + s z1 < high1 and low2 < .. z2 .. < high2?
/// Heights as parts of one; all numbers in grid units.
bool passes(std::int64_t z1, std::int64_t low1, std::int64_t high1, std::int64_t z2, std::int64_t low2,
            std::int64_t high2) {
    Rational one = kOne;
    Polygon2 p = {{0, 0}, {one, 0}, {one, one}, {0, one}};
    std::int64_t z[2] = {z1, z2}, low[2] = {low1, low2}, high[2] = {high1, high2};
    for (int k = 0; k < 2; ++k) {
        Rational s = Rational(z[k]) / one, u = 1 - s;
        p = cut(p, u, s, low[k]);
        p = cut(p, -u, -s, -high[k]);
    }
    return has_area(p);
}

Case two_unit_squares() {
    Case c;
    c.s = {{0, 0, 0}, {kOne, 0, 0}, {kOne, kOne, 0}, {0, kOne, 0}};
    c.t = {{0, 0, kOne}, {0, kOne, kOne}, {kOne, kOne, kOne}, {kOne, 0, kOne}};
    return c;
}

TEST(KnownAnswers, TwoHalfPlanesFollowTheLinearProgram) {
    Random random(6);
    std::int64_t far = 15 * kOne;
    for (int k = 0; k < 100; ++k) {
        Case c = two_unit_squares();
        std::int64_t z1 = std::llround(random.uniform(0.1, 0.45) * kOne);
        std::int64_t z2 = std::llround(random.uniform(0.55, 0.9) * kOne);
        std::int64_t a = std::llround(random.uniform(0.2, 0.9) * kOne);
        // Lines with x(z1) > a have x(z2) > x0, the value along the line from (a at z1) to the far corner.
        Polygon2 p = {{0, 0}, {kOne, 0}, {kOne, kOne}, {0, kOne}};
        Rational s1 = Rational(z1) / kOne, s2 = Rational(z2) / kOne, least = far;
        for (const auto& v : cut(p, 1 - s1, s1, a))
            least = std::min(least, Rational(v[0] * (1 - s2) + v[1] * s2));
        std::int64_t b = static_cast<std::int64_t>(numerator(least) / denominator(least)) + k % 5 - 2;
        add_quad(c, {-far, -far, z1}, {a, -far, z1}, {a, far, z1}, {-far, far, z1});
        add_quad(c, {b, -far, z2}, {far, -far, z2}, {far, far, z2}, {b, far, z2});
        EXPECT_EQ(proved_visible(c), passes(z1, a, far, z2, -far, b)) << k;
    }
}

/// A wall at height z with a rectangular hole.
void add_pinhole(Case& c, std::int64_t z, const std::int64_t (&low)[2], const std::int64_t (&high)[2]) {
    std::int64_t far = 3 * kOne;
    add_quad(c, {-far, -far, z}, {far, -far, z}, {far, low[1], z}, {-far, low[1], z});
    add_quad(c, {-far, high[1], z}, {far, high[1], z}, {far, far, z}, {-far, far, z});
    add_quad(c, {-far, low[1], z}, {low[0], low[1], z}, {low[0], high[1], z}, {-far, high[1], z});
    add_quad(c, {high[0], low[1], z}, {far, low[1], z}, {far, high[1], z}, {high[0], high[1], z});
}

TEST(KnownAnswers, PinholePairsFollowOneLinearProgramPerAxis) {
    Random random(7);
    int visible = 0;
    for (int k = 0; k < 60; ++k) {
        Case c = two_unit_squares();
        std::int64_t z[2] = {std::llround(random.uniform(0.2, 0.4) * kOne), std::llround(random.uniform(0.6, 0.8) * kOne)};
        std::int64_t low[2][2], high[2][2]; // [wall][axis]
        for (int wall = 0; wall < 2; ++wall)
            for (int axis = 0; axis < 2; ++axis) {
                low[wall][axis] = std::llround(random.uniform(0.05, 0.9) * kOne);
                high[wall][axis] = low[wall][axis] + 1 + random.below(kOne / 20);
            }
        add_pinhole(c, z[0], low[0], high[0]);
        add_pinhole(c, z[1], low[1], high[1]);
        bool expected = true;
        for (int axis = 0; axis < 2; ++axis)
            expected &= passes(z[0], low[0][axis], high[0][axis], z[1], low[1][axis], high[1][axis]);
        visible += expected;
        EXPECT_EQ(proved_visible(c), expected) << k;
    }
    EXPECT_GT(visible, 5);
    EXPECT_LT(visible, 55);
}

TEST(KnownAnswers, TheTargetsOwnPlaneTiledWithTrianglesHidesNothing) {
    Case c;
    c.s = {grid(0, 0, 0), grid(1, 0, 0), grid(1, 1, 0), grid(0, 1, 0)};
    c.t = {grid(0.2, 0.2, 1), grid(0.2, 0.8, 1), grid(0.8, 0.2, 1)};
    add_quad(c, grid(-2, -2, 1), grid(2, -2, 1), grid(2, 2, 1), grid(-2, 2, 1));
    EXPECT_TRUE(proved_visible(c));
    add_quad(c, grid(-2, -2, 0), grid(2, -2, 0), grid(2, 2, 0), grid(-2, 2, 0)); // and that of the source
    EXPECT_TRUE(proved_visible(c));
}

TEST(KnownAnswers, AnOccluderThatEndsExactlyOnTheTargetsPlane) {
    Case c;
    c.s = {grid(0, 0, 0), grid(1, 0, 0), grid(1, 1, 0), grid(0, 1, 0)};
    c.t = {grid(1.5, 0, 1), grid(1.5, 1, 1), grid(2.5, 0, 1)};
    // An upright fin below the target's edge, as high as its plane; lines to points just behind it graze its top.
    add_quad(c, grid(1.5, -5, -1), grid(1.5, 6, -1), grid(1.5, 6, 1), grid(1.5, -5, 1));
    EXPECT_FALSE(proved_visible(c));
    for (Polygon& o : c.occluders)
        for (GridPoint& p : o.corners)
            p.z -= p.z == kOne ? 1 : 0;
    EXPECT_TRUE(proved_visible(c));
}

TEST(KnownAnswers, AnOccluderOnTheTargetsEdge) {
    Case c;
    c.s = {grid(0, 0, 0), grid(1, 0, 0), grid(1, 1, 0), grid(0, 1, 0)};
    c.t = {grid(0, 0, 1), grid(0, 1, 1), grid(1, 0, 1)};
    add_triangle(c, c.t[1], c.t[2], grid(0.5, 0.5, 0.25)); // hangs from the long edge
    EXPECT_TRUE(proved_visible(c));
}

/// The six sides of a box as triangles, outside faces counter-clockwise.
void add_box(Case& c, GridPoint a, GridPoint b, bool both_sides = true, bool inward = false) {
    auto corner = [&](int i) { return GridPoint{i & 1 ? b.x : a.x, i & 2 ? b.y : a.y, i & 4 ? b.z : a.z}; };
    const int faces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    for (const auto& f : faces) {
        std::size_t first = c.occluders.size();
        add_quad(c, corner(f[0]), corner(f[1]), corner(f[2]), corner(f[3]));
        for (std::size_t k = first; k < c.occluders.size(); ++k) {
            c.occluders[k].both_sides = both_sides;
            if (inward)
                std::swap(c.occluders[k].corners[0], c.occluders[k].corners[1]);
        }
    }
}

TEST(KnownAnswers, FromInsideAClosedBoxNothingOutsideIsSeen) {
    Random random(8);
    for (int k = 0; k < 10; ++k) {
        Case c = square_and_triangle(random);
        add_box(c, grid(-1, -1, -1), grid(1.2, 1.2, 0.4));
        EXPECT_FALSE(proved_visible(c));
        c.occluders.erase(c.occluders.end() - 2); // half of the lid
        c.t = {grid(0, -0.5, 2), grid(1, -0.4, 2), grid(0.5, 0.6, 2)};
        face_each_other(c);
        EXPECT_TRUE(proved_visible(c));
    }
}

TEST(Sidedness, ASingleSidedWallBlocksFromItsFrontOnly) {
    Random random(9);
    for (int k = 0; k < 10; ++k) {
        Case c = square_and_triangle(random);
        add_wall(c, random, 3, 0.6);
        for (Polygon& o : c.occluders) {
            o.both_sides = false;
            face_towards(o.corners, c.s);
        }
        EXPECT_FALSE(proved_visible(c));
        for (Polygon& o : c.occluders)
            std::reverse(o.corners.begin(), o.corners.end());
        EXPECT_TRUE(proved_visible(c));
    }
}

TEST(Sidedness, ARoomIsSeenFromOutsideThroughTheBacksOfItsWalls) {
    Case c;
    c.s = {grid(0, 0, 0), grid(1, 0, 0), grid(1, 1, 0), grid(0, 1, 0)};
    c.t = {grid(0.2, 0.2, 2), grid(0.2, 0.8, 2), grid(0.8, 0.2, 2)};
    face_each_other(c);
    add_box(c, grid(-1, -1, 1), grid(2, 2, 3), false, true); // fronts inward
    EXPECT_TRUE(proved_visible(c));
    Case outward = c;
    outward.occluders.clear();
    add_box(outward, grid(-1, -1, 1), grid(2, 2, 3), false, false);
    EXPECT_FALSE(proved_visible(outward));
    // From inside it is the other way round.
    std::swap(c.s, c.t);
    std::swap(outward.s, outward.t);
    EXPECT_FALSE(proved_visible(c));
    EXPECT_TRUE(proved_visible(outward));
}

TEST(KnownAnswers, TheLargestCoordinates) {
    std::int64_t far = (1 << 23) - 1;
    Case c;
    c.s = {{-far, -far, -far}, {far, -far, -far}, {far, far, -far}, {-far, far, -far}};
    c.t = {{-far, -far, far}, {-far, far, far}, {far, far, far}, {far, -far, far}};
    add_quad(c, {-far, -far, 1}, {far, -far, 2}, {far, far, 1}, {-far, far, 0});
    EXPECT_FALSE(proved_visible(c));
    c.occluders[0].corners[1].z += 1; // no longer planar with its neighbour, still sharing the diagonal
    EXPECT_FALSE(proved_visible(c));
    c.occluders[0].corners[1].x -= 1; // a crack at the rim of the shaft
    EXPECT_TRUE(proved_visible(c));
}

} // namespace
} // namespace antumbra::exact::testing
