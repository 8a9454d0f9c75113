// Exact queries between two polygons: CPU microseconds at growing numbers of effective occluders, filtered and in integers
// side by side, with the answers beside the times (Nirenstein, Blake, Gain 2002, figure 4).
//
// usage: bench_exact [SECONDS per family, default 10]
#include "base/random.hpp"
#include "bake/exact/query.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>

using namespace antumbra;
using namespace antumbra::exact;

namespace {

constexpr double kOne = 1 << 20;
/// Of this thread: other work on the machine does not count.
double cpu_seconds() {
    timespec now{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) * 1e-9;
}

GridPoint grid(double x, double y, double z) { return {std::llround(x * kOne), std::llround(y * kOne), std::llround(z * kOne)}; }

struct Case {
    std::vector<GridPoint> s, t;
    std::vector<certify::Polygon> occluders;
};

void add(Case& c, GridPoint a, GridPoint b, GridPoint d) { c.occluders.push_back({{a, b, d}, true}); }

Case ends(Random& random, double size) {
    Case c;
    c.s = {grid(0, 0, 0), grid(1, 0, 0), grid(1, 1, 0), grid(0, 1, 0)};
    double x = random.uniform(-0.5, 1), y = random.uniform(-0.5, 1), z = random.uniform(1.5, 3);
    c.t = {grid(x - size, y - size, z), grid(x, y + size, z + 0.3), grid(x + size, y - size, z - 0.1)};
    return c;
}

/// A closed jittered wall of n x n cells.
Case wall(Random& random, int n) {
    Case c = ends(random, 0.5);
    std::vector<std::vector<GridPoint>> g;
    double low = -1.2, cell = 3.4 / n;
    for (int i = 0; i <= n; ++i) {
        g.emplace_back();
        for (int j = 0; j <= n; ++j) {
            bool rim = i == 0 || j == 0 || i == n || j == n;
            auto shake = [&](double by) { return rim ? 0.0 : random.uniform(-by, by); };
            double x = low + cell * i + shake(0.25 * cell), y = low + cell * j + shake(0.25 * cell);
            g.back().push_back(grid(x, y, 0.65 + shake(0.1)));
        }
    }
    for (std::size_t i = 0; i + 1 < g.size(); ++i)
        for (std::size_t j = 0; j + 1 < g.size(); ++j) {
            add(c, g[i][j], g[i + 1][j], g[i + 1][j + 1]);
            add(c, g[i][j], g[i + 1][j + 1], g[i][j + 1]);
        }
    return c;
}

/// n triangles around one hub.
Case umbrella(Random& random, int n) {
    Case c = ends(random, 0.5);
    GridPoint hub = grid(random.uniform(0.3, 0.7), random.uniform(0.3, 0.7), 0.6);
    std::vector<GridPoint> rim;
    for (int k = 0; k < n; ++k)
        rim.push_back(grid(0.5 + 7 * std::cos(6.2831853 * k / n), 0.5 + 7 * std::sin(6.2831853 * k / n), random.uniform(0.5, 0.7)));
    for (std::size_t k = 0; k < rim.size(); ++k)
        add(c, hub, rim[k], rim[(k + 1) % rim.size()]);
    return c;
}

/// n loose leaves that together may hide the target.
Case leaves(Random& random, int n) {
    Case c = ends(random, 0.1);
    double size = std::min(1.2, 4 / std::sqrt(static_cast<double>(n)));
    for (int k = 0; k < n; ++k) {
        double p[9];
        double x = random.uniform(-0.6, 1.4), y = random.uniform(-0.6, 1.4), z = random.uniform(0.15, 1.25);
        for (int i = 0; i < 9; ++i)
            p[i] = (i % 3 == 0 ? x : i % 3 == 1 ? y : z) + random.uniform(-size, size) * (i % 3 == 2 ? 0.3 : 1);
        add(c, grid(p[0], p[1], p[2]), grid(p[3], p[4], p[5]), grid(p[6], p[7], p[8]));
    }
    return c;
}

struct Row {
    double microseconds = 0;
    std::uint64_t queries = 0, hidden = 0, effective = 0, pieces = 0;
};

Row run(const std::vector<Case>& cases, bool filtered, double seconds) {
    Query query;
    QueryOptions options;
    options.filtered = filtered;
    options.rays = filtered ? 8 : 0;
    options.start = filtered ? Start::automatic : Start::prism_or_hull;
    Row row;
    double start = cpu_seconds();
    for (const Case& c : cases) {
        OccluderList list(c.occluders);
        QueryResult result = query.run(c.s, c.t, list, options);
        ++row.queries;
        row.hidden += result.answer == Answer::hidden;
        row.effective += result.blockers.size();
        row.pieces += result.counters.pieces;
        if (cpu_seconds() - start > seconds)
            break;
    }
    row.microseconds = (cpu_seconds() - start) * 1e6 / static_cast<double>(row.queries);
    return row;
}

void family(const char* name, Case (*make)(Random&, int), std::initializer_list<int> sizes, double seconds) {
    std::printf("%-9s %6s %9s %8s %9s %8s %8s %8s\n", name, "size", "effective", "pieces", "us", "oracle", "ratio", "hidden");
    double sx = 0, sy = 0, sxx = 0, sxy = 0;
    int points = 0;
    for (int n : sizes) {
        Random random(static_cast<std::uint64_t>(n));
        std::vector<Case> cases;
        for (int k = 0; k < 200; ++k)
            cases.push_back(make(random, n));
        double share = seconds / static_cast<double>(sizes.size()) / 2;
        Row fast = run(cases, true, share), plain = run(cases, false, share);
        double effective = static_cast<double>(fast.effective) / static_cast<double>(fast.queries);
        std::printf("%-9s %6d %9.1f %8.1f %9.1f %8.0f %8.1f %7.0f%%\n", "", n, effective,
                    static_cast<double>(fast.pieces) / static_cast<double>(fast.queries), fast.microseconds,
                    plain.microseconds, plain.microseconds / fast.microseconds,
                    100.0 * static_cast<double>(fast.hidden) / static_cast<double>(fast.queries));
        if (effective > 1.5) {
            double x = std::log(effective), y = std::log(fast.microseconds);
            sx += x;
            sy += y;
            sxx += x * x;
            sxy += x * y;
            ++points;
        }
    }
    if (points > 1)
        std::printf("%-9s microseconds grow as effective occluders to the power %.2f (published 1.15)\n\n", "",
                    (points * sxy - sx * sy) / (points * sxx - sx * sx));
}

} // namespace

int main(int argc, char** argv) {
    double seconds = argc > 1 ? std::atof(argv[1]) : 10;
    family("walls", wall, {1, 2, 3, 4, 6, 8, 11, 15}, seconds);
    family("umbrellas", umbrella, {4, 6, 8, 12, 16, 24}, seconds);
    family("leaves", leaves, {10, 30, 100, 300}, seconds);
}
