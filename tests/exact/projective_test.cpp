// Projective maps keep lines lines. One that leaves the whole scene on one side of the plane that it sends to infinity
// keeps order along them as well, so that no answer may change.
#include "exact/families.hpp"

namespace antumbra::exact::testing {
namespace {

/// Divides kWhole, so that whole coordinates stay whole.
constexpr std::int64_t kDepths[] = {10, 12, 14, 15, 18, 20, 21, 24, 28, 30};
constexpr std::int64_t kWhole = 2520;

GridPoint point(Random& random, std::size_t from, std::size_t to) {
    std::int64_t x = pick(random, -9, 9), y = pick(random, -9, 9);
    return {x, y, kDepths[from + random.below(std::uint32_t(to - from))]};
}

std::vector<GridPoint> triangle(Random& random, std::size_t from, std::size_t to) {
    std::vector<GridPoint> t(3);
    do
        for (GridPoint& p : t)
            p = point(random, from, to);
    while (!has_area(t));
    return t;
}

/// (x, y, z) to (x/z, y/z, -1/z), as a camera at the origin sees it: determinant +1 and z > 0, so fronts stay fronts.
GridPoint project(const GridPoint& p) {
    EXPECT_EQ(kWhole % p.z, 0);
    return {kWhole / p.z * p.x, kWhole / p.z * p.y, -(kWhole / p.z)};
}

template <class Map>
Case mapped(const Case& c, const Map& map) {
    Case d = c;
    for (auto* polygon : {&d.s, &d.t})
        for (GridPoint& p : *polygon)
            p = map(p);
    for (Polygon& o : d.occluders)
        for (GridPoint& p : o.corners)
            p = map(p);
    return d;
}

Case soup(Random& random) {
    Case c;
    c.s = triangle(random, 0, 3);
    c.t = triangle(random, 7, 10);
    face_each_other(c);
    int count = 4 + int(random.below(12));
    for (int i = 0; i < count; ++i) {
        std::vector<GridPoint> t = triangle(random, 0, 10);
        if (i > 0 && random.below(2)) // a shared edge
            do
                t = {c.occluders.back().corners[1], c.occluders.back().corners[0], point(random, 0, 10)};
            while (!has_area(t));
        c.occluders.push_back({t, random.below(3) != 0});
    }
    return c;
}

/// A closed wall of shared corners across the shaft, or one with a triangle missing.
Case wall(Random& random, bool closed) {
    Case c;
    c.s = triangle(random, 0, 2);
    c.t = triangle(random, 8, 10);
    face_each_other(c);
    GridPoint g[5][5];
    for (int i = 0; i < 5; ++i)
        for (int j = 0; j < 5; ++j)
            g[i][j] = {12 * (i - 2) + pick(random, -3, 3), 12 * (j - 2) + pick(random, -3, 3), kDepths[3 + random.below(4)]};
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j)
            add_quad(c, g[i][j], g[i + 1][j], g[i + 1][j + 1], g[i][j + 1]);
    if (!closed)
        c.occluders.erase(c.occluders.begin() + 10 + random.below(12));
    return c;
}

TEST(Metamorphic, ProjectiveMapsThatKeepTheSceneInFrontChangeNothing) {
    Random random(77);
    int hidden = 0, visible = 0;
    for (int k = 0; k < 900; ++k) {
        Case c = k % 3 ? soup(random) : wall(random, k % 2);
        Case d = mapped(c, project);
        Answer answer = ask(c, fast()).answer;
        ASSERT_NE(answer, Answer::undecided);
        ASSERT_EQ(answer, ask(d, fast()).answer) << k;
        ASSERT_EQ(answer, ask(d, as_published(0)).answer) << k;
        (answer == Answer::hidden ? hidden : visible) += 1;
    }
    EXPECT_GT(hidden, 100);
    EXPECT_GT(visible, 100);
}

TEST(Metamorphic, ProofsHoldAfterAProjectiveMap) {
    Random random(78);
    for (int k = 0; k < 90; ++k) {
        Case c = k % 2 ? soup(random) : wall(random, k % 4 == 0);
        EXPECT_EQ(proved_visible(c), proved_visible(mapped(c, project))) << k;
    }
}

/// A map that turns nothing over must not be mistaken for one that does: with the plane at infinity inside the scene, the law
/// does not hold, which shows that the test above can fail.
TEST(Metamorphic, AMapThatSplitsTheSceneDoesChangeAnswers) {
    Random random(79);
    int changed = 0;
    for (int k = 0; k < 300; ++k) {
        Case c = soup(random);
        Case d = mapped(c, [](const GridPoint& p) { // the plane z = 17, behind S and before T
            std::int64_t w = p.z - 17, whole = 12 * 5 * 7 * 13 * 11; // 7, 5, 3, 2, 1, -1, -3, -4, -7, -11, -13
            return GridPoint{whole / w * p.x, whole / w * p.y, -(whole / w)};
        });
        face_each_other(d);
        changed += ask(c, fast()).answer != ask(d, fast()).answer;
    }
    EXPECT_GT(changed, 0);
}

} // namespace
} // namespace antumbra::exact::testing
