// The machine: a closed housing like a copier's, full of parts that are seen only through its gratings or
// from within. In metres, standing on y = 0:
//
//   y 0.98..1.08  upper deck: springs, levers        x from 0 to 1.2
//   y 0.36..0.96  rollers between two side plates,   z from 0 (front) to 0.7 (back)
//                 gears behind the rear plate
//   y 0.02..0.34  lower deck: circuit boards, motors, cables
#include "generate/kinds.hpp"
#include "generate/modeller.hpp"

#include "base/random.hpp"

namespace antumbra::generation {
namespace {

constexpr std::size_t kParts = 1726;
constexpr std::size_t kTriangles = 455'806; // the paper's 455,807, made even: closed solids have no odd count
constexpr double kWidth = 1.2, kHeight = 1.1, kDepth = 0.7, kPanel = 0.01;

struct Machine {
    Modeller modeller{"generate machine", kFineGrid};
    std::uint64_t seed = 1;

    void panel(const std::string& name, const Vec3d& low, const Vec3d& high);
    void grating(const Frame& frame, const std::string& name, double width, double height, int slats);
    void housing();
    void gear(const Frame& frame, const std::string& name, double radius, int teeth);
    void gears();
    void rollers();
    void spring(const Frame& frame, const std::string& name, double radius, double length, int turns);
    void springs();
    void board(const Frame& frame, const std::string& name, int board_number, Random random);
    void boards();
    void motors();
    void cables();
    void screw(const Frame& frame, const std::string& name);
    void screws(std::size_t count);
    void dial();
};

void Machine::panel(const std::string& name, const Vec3d& low, const Vec3d& high) {
    modeller.begin(name);
    modeller.place({});
    modeller.box(low, high);
}

/// A frame in the xy plane from (0, 0) with inclined slats; outside is +z.
void Machine::grating(const Frame& frame, const std::string& name, double width, double height, int slats) {
    constexpr double kRim = 0.015;
    modeller.begin(name);
    modeller.place(frame);
    modeller.ring(Axis::z, {0, 0}, {width, height}, {kRim, kRim}, {width - kRim, height - kRim}, -kPanel, 0);
    double step = (height - 2 * kRim) / slats;
    for (int i = 0; i < slats; ++i) {
        double y = kRim + i * step;
        // A slat covers half of its step; the corners are numbered as Box3::corner.
        Vec3d corners[8];
        for (int k = 0; k < 8; ++k)
            corners[k] = {k & 1 ? width - kRim : kRim,
                          y + (k & 2 ? 0.5 * step : 0.25 * step) + (k & 4 ? -0.2 * step : 0.2 * step),
                          k & 4 ? -0.002 : -kPanel + 0.002};
        modeller.hexahedron(corners);
    }
}

void Machine::housing() {
    double w = kWidth, h = kHeight, d = kDepth, p = kPanel;
    panel("housing/bottom", {0, 0, 0}, {w, p, d});
    panel("housing/top left", {0, h - p, 0}, {0.8, h, d});
    grating(Frame{{0.8, h, d}, {1, 0, 0}, {0, 0, -1}, {0, 1, 0}}, "housing/top grating", 0.4, d, 32);
    // Sides, between bottom and top; seen from outside the local x axis runs to the right.
    panel("housing/front lower", {0, p, 0}, {w, 0.7, p});
    panel("housing/front upper", {0, 0.7, 0}, {0.7, h - p, p});
    grating(Frame{{w, 0.7, 0}, {-1, 0, 0}, {0, 1, 0}, {0, 0, -1}}, "housing/front grating", w - 0.7,
            h - p - 0.7, 24);
    panel("housing/back upper", {0, 0.45, d - p}, {w, h - p, d});
    panel("housing/back lower", {0, p, d - p}, {0.5, 0.45, d});
    grating(Frame{{0.5, p, d}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, "housing/back grating", w - 0.5, 0.45 - p,
            28);
    panel("housing/left upper", {0, 0.4, p}, {p, h - p, d - p});
    grating(Frame{{0, p, p}, {0, 0, 1}, {0, 1, 0}, {-1, 0, 0}}, "housing/left grating", d - 2 * p, 0.4 - p,
            24);
    panel("housing/right", {w - p, p, p}, {w, h - p, d - p});
    for (int i = 0; i < 4; ++i) {
        modeller.begin("housing/foot " + std::to_string(i + 1));
        modeller.place(at({i & 1 ? w - 0.1 : 0.1, -0.03, i & 2 ? d - 0.1 : 0.1}));
        modeller.cylinder(Axis::y, 0.03, 0, 0.03, 24);
    }
    panel("frame/plate front", {0.03, 0.36, 0.045}, {w - 0.03, 0.96, 0.05});
    panel("frame/plate back", {0.03, 0.36, 0.56}, {w - 0.03, 0.96, 0.565});
    panel("frame/deck lower", {p, 0.345, p}, {w - p, 0.355, d - p});
    panel("frame/deck upper", {p, 0.965, p}, {0.85, 0.97, d - p});
}

/// Teeth, a hub and an axle.
void Machine::gear(const Frame& frame, const std::string& name, double radius, int teeth) {
    modeller.begin(name);
    modeller.place(frame);
    std::vector<Vec2> outline;
    double share[4] = {0.0, 0.25, 0.5, 0.75}, out[4] = {0.88, 1, 1, 0.88};
    for (int t = 0; t < teeth; ++t)
        for (int k = 0; k < 4; ++k) {
            double turns = (t + share[k]) / teeth;
            outline.push_back({radius * out[k] * cosine(turns), radius * out[k] * sine(turns)});
        }
    modeller.star(Axis::z, outline, 0, 0.012);
    modeller.cylinder(Axis::z, radius * 0.3, 0.012, 0.02, 25);
    modeller.cylinder(Axis::z, 0.005, 0.02, 0.03, 16);
}

/// Two layers on the back of the rear plate, each gear between its neighbours.
void Machine::gears() {
    for (int layer = 0; layer < 2; ++layer)
        for (int row = 0; row < 6; ++row)
            for (int column = 0; column < 12; ++column) {
                Random random(seed, static_cast<std::uint64_t>(layer * 100 + row * 12 + column), 0x67656172);
                double shift = row % 2 ? 0.024 : 0;
                Vec3d centre{0.085 + 0.092 * column + shift, 0.415 + 0.096 * row, layer ? 0.605 : 0.568};
                int teeth = 20 + 4 * ((row * 5 + column * 3 + layer) % 4);
                gear(at(centre), "gears/gear " + std::to_string(layer * 72 + row * 12 + column + 1),
                     random.uniform(0.03, 0.044), teeth);
            }
}

void Machine::rollers() {
    for (int row = 0; row < 6; ++row)
        for (int column = 0; column < 12; ++column) {
            Random random(seed, static_cast<std::uint64_t>(row * 12 + column), 0x726f6c6c);
            double r = random.uniform(0.015, 0.04), shaft = 0.006;
            modeller.begin("rollers/roller " + std::to_string(row * 12 + column + 1));
            modeller.place(at({0.085 + 0.094 * column, 0.41 + 0.1 * row, 0}));
            Vec2 profile[] = {{shaft, 0.052}, {shaft, 0.08}, {r, 0.08}, {r, 0.2},      {r * 0.9, 0.21},
                              {r * 0.9, 0.4}, {r, 0.41},     {r, 0.53}, {shaft, 0.53}, {shaft, 0.558}};
            modeller.lathe(Axis::z, profile, 36);
        }
}

/// A coil about +z: a tube along a helix, 14 points a turn.
void Machine::spring(const Frame& frame, const std::string& name, double radius, double length, int turns) {
    modeller.begin(name);
    modeller.place(frame);
    std::vector<Vec3d> path;
    int points = turns * 14 + 1;
    for (int i = 0; i < points; ++i)
        path.push_back({radius * cosine(i / 14.0), radius * sine(i / 14.0), length * i / (points - 1)});
    double thick[] = {radius * 0.18};
    modeller.tube(path, thick, 5);
}

void Machine::springs() {
    int number = 0;
    for (int row = 0; row < 5; ++row)
        for (int column = 0; column < 16; ++column) {
            Random random(seed, static_cast<std::uint64_t>(++number), 0x73707269);
            Frame frame{{0.04 + 0.05 * column, 1.02 + random.uniform(-0.02, 0.02), 0.06 + 0.125 * row}};
            double radius = random.uniform(0.008, 0.018), stretched = random.uniform(0.05, 0.1);
            spring(frame, "springs/spring " + std::to_string(number), radius, stretched, 6 + number % 5);
            // A lever that the spring pulls.
            modeller.begin("springs/lever " + std::to_string(number));
            modeller.place(frame * turned({0, 0.03, 0.1}, random.uniform(-0.05, 0.05)));
            Vec2 outline[] = {{-0.004, -0.02}, {0.004, -0.02}, {0.006, 0.01}, {0.002, 0.02}, {-0.006, 0.01}};
            modeller.extrude(Axis::z, outline, 0, 0.006);
        }
}

/// A plate in the xy plane, 0.42 by 0.28, with chips and capacitors on +z.
void Machine::board(const Frame& frame, const std::string& name, int board_number, Random random) {
    modeller.begin(name);
    modeller.place(frame);
    modeller.box({0, 0, 0}, {0.42, 0.28, 0.003});
    int number = 0;
    for (int row = 0; row < 4; ++row)
        for (int column = 0; column < 6; ++column) {
            ++number;
            double x = 0.04 + 0.068 * column, y = 0.04 + 0.066 * row;
            modeller.place(frame * at({x, y, 0.003}));
            if ((number + row + board_number) % 3 == 0) { // standing on the plate
                modeller.begin(name + "/capacitor " + std::to_string(number));
                double r = random.uniform(0.008, 0.016), h = random.uniform(0.02, 0.04);
                Vec2 profile[] = {{r, 0},        {r, h * 0.15}, {r * 0.92, h * 0.2},
                                  {r, h * 0.25}, {r, h},        {r * 0.8, h + 0.002}};
                modeller.lathe(Axis::z, profile, 24);
                continue;
            }
            modeller.begin(name + "/chip " + std::to_string(number));
            double half = random.uniform(0.018, 0.026);
            modeller.box({-half, -0.012, 0.003}, {half, 0.012, 0.009});
            for (int pin = 0; pin < 10; ++pin)
                for (int side = 0; side < 2; ++side) {
                    double px = -half + (pin + 0.3) * half / 5, py = side ? 0.012 : -0.018;
                    modeller.box({px, py, 0}, {px + half / 12, py + 0.006, 0.006});
                }
        }
}

void Machine::boards() {
    for (int i = 0; i < 8; ++i) {
        // Upright, square to x; local x runs toward the front.
        Frame frame{{0.07 + 0.075 * i, 0.03, 0.6}, {0, 0, -1}, {0, 1, 0}, {1, 0, 0}};
        board(frame, "boards/board " + std::to_string(i + 1), i,
              Random(seed, static_cast<std::uint64_t>(i), 0x626f6172));
    }
}

void Machine::motors() {
    for (int i = 0; i < 12; ++i) {
        Random random(seed, static_cast<std::uint64_t>(i), 0x6d6f746f);
        modeller.begin("motors/motor " + std::to_string(i + 1));
        modeller.place(at({0.74 + 0.14 * (i % 3), 0.1 + 0.14 * (i / 3 % 2), i / 6 ? 0.38 : 0.1}));
        double r = random.uniform(0.045, 0.06);
        std::vector<Vec2> profile = {{r * 0.8, 0}, {r, 0.01}};
        for (int rib = 0; rib < 8; ++rib) {
            double z = 0.02 + 0.016 * rib;
            for (auto [radius, along] : {std::pair{r, z}, {r * 0.9, z}, {r * 0.9, z + 0.008}, {r, z + 0.008}})
                profile.push_back({radius, along});
        }
        profile.insert(profile.end(), {{r, 0.16}, {r * 0.3, 0.165}, {0.006, 0.165}, {0.006, 0.2}});
        modeller.lathe(Axis::z, profile, 41);
    }
}

/// From a board over the motors up to the deck, in one smooth bend each.
void Machine::cables() {
    for (int i = 0; i < 64; ++i) {
        Random random(seed, static_cast<std::uint64_t>(i), 0x6361626c);
        Vec3d a{0.08 + 0.075 * (i % 8), 0.06 + 0.03 * (i / 8), 0.17},
            d{0.3 + 0.0135 * i, 0.335, random.uniform(0.02, 0.16)};
        Vec3d b = a + Vec3d{0.02, random.uniform(0, 0.05), -0.18},
              c = d + Vec3d{random.uniform(-0.2, 0), -0.12, 0.02};
        std::vector<Vec3d> path;
        for (int k = 0; k <= 48; ++k) { // a cubic Bezier curve
            double t = k / 48.0, s = 1 - t;
            path.push_back(a * (s * s * s) + b * (3 * s * s * t) + c * (3 * s * t * t) + d * (t * t * t));
        }
        double thick[] = {random.uniform(0.002, 0.004)};
        modeller.begin("cables/cable " + std::to_string(i + 1));
        modeller.place({});
        modeller.tube(path, thick, 6);
    }
}

/// Head with a cross slot's worth of facets, shaft and point: along -z, the head on z = 0.
void Machine::screw(const Frame& frame, const std::string& name) {
    modeller.begin(name);
    modeller.place(frame);
    Vec2 profile[] = {{0, -0.016},     {0.002, -0.013}, {0.002, -0.002},
                      {0.005, -0.002}, {0.005, 0.001},  {0.003, 0.0025}};
    modeller.lathe(Axis::z, profile, 10);
}

/// In rows along the edges of panels, plates and decks.
void Machine::screws(std::size_t count) {
    struct Row {
        Frame frame; // of the first screw; the row runs along its x axis
        double length;
    };
    auto row = [](Vec3d from, Vec3d along, Vec3d out, double length) {
        return Row{{from, along, cross(out, along), out}, length};
    };
    Vec3d x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
    double w = kWidth, h = kHeight, d = kDepth;
    std::vector<Row> rows = {
        row({0.02, 0.03, 0}, x, -z, w - 0.04),     row({0.02, 0.68, 0}, x, -z, w - 0.04),
        row({0.02, h - 0.03, 0}, x, -z, 0.66),     row({0.02, 0.47, d}, x, z, w - 0.04),
        row({0.02, h - 0.03, d}, x, z, w - 0.04),  row({0.02, 0.03, d}, x, z, 0.46),
        row({0, 0.42, 0.03}, z, -x, d - 0.06),     row({0, h - 0.03, 0.03}, z, -x, d - 0.06),
        row({w, 0.03, 0.03}, z, x, d - 0.06),      row({w, h - 0.03, 0.03}, z, x, d - 0.06),
        row({0.02, h, 0.02}, x, y, 0.76),          row({0.02, h, d - 0.02}, x, y, 0.76),
        row({0.05, 0.365, 0.045}, x, -z, w - 0.1), row({0.05, 0.95, 0.045}, x, -z, w - 0.1),
        row({0.05, 0.365, 0.565}, x, z, w - 0.1),  row({0.05, 0.95, 0.565}, x, z, w - 0.1),
        row({0.04, 0.355, 0.03}, x, y, w - 0.1),   row({0.04, 0.355, 0.68}, x, y, w - 0.1),
        row({0.04, 0.97, 0.03}, x, y, 0.78),       row({0.04, 0.97, 0.66}, x, y, 0.78),
    };
    for (std::size_t i = 0; i < count; ++i) {
        const Row& r = rows[i % rows.size()];
        std::size_t in_row = (count - i % rows.size() + rows.size() - 1) / rows.size(), k = i / rows.size();
        double along = in_row > 1 ? r.length * double(k) / double(in_row - 1) : 0;
        screw(r.frame * at({along, 0, 0}), "screws/screw " + std::to_string(i + 1));
    }
}

/// A pointed knob on the front: its number of sides (2 s - 2 triangles) brings the sum to kTriangles.
void Machine::dial() {
    auto sides = static_cast<int>((kTriangles - modeller.triangle_count() + 2) / 2);
    modeller.begin("housing/dial");
    modeller.place(at({0.35, 0.9, 0}));
    Vec2 profile[] = {{0, -0.03}, {0.05, 0}};
    modeller.lathe(Axis::z, profile, sides);
}

} // namespace

Result<RawScene> machine(const GenerateOptions& options) {
    if (options.triangles && options.triangles != kTriangles)
        return Status(ErrorCode::usage, "the machine has one size, " + std::to_string(kTriangles) +
                                            " triangles; leave out the wanted triangles");
    Machine machine;
    machine.seed = options.seed;
    machine.housing();
    machine.gears();
    machine.rollers();
    machine.springs();
    machine.boards();
    machine.motors();
    machine.cables();
    machine.screws(kParts - 1 - machine.modeller.object_count());
    machine.dial();
    return machine.modeller.finish();
}

} // namespace antumbra::generation
