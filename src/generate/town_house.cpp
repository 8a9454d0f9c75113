#include "generate/town_house.hpp"

namespace antumbra::generation {
namespace {

constexpr double kThick = 0.25, kJut = 0.4, kFloor = 0.125;
constexpr double kGround = 2.5, kUpper = 2.25, kSlab = 0.25; // clear heights, and the floor between

/// A hole in a wall, as wide as x, from y = low to high.
struct Opening {
    double left, right, low, high;
};

/// A wall of boxes around its openings (in order along x, not overlapping): from (left, 0) to (right,
/// height), and `thick` deep to the back of the frame's plane z = 0. One object.
void wall(Modeller& modeller, const Frame& frame, const std::string& name, double left, double right,
          double height, std::span<const Opening> openings, double thick = kThick) {
    modeller.begin(name);
    modeller.place(frame);
    double x = left;
    for (const Opening& hole : openings) {
        modeller.box({x, 0, -thick}, {hole.left, height, 0});
        if (hole.low > 0)
            modeller.box({hole.left, 0, -thick}, {hole.right, hole.low, 0});
        modeller.box({hole.left, hole.high, -thick}, {hole.right, height, 0});
        x = hole.right;
    }
    modeller.box({x, 0, -thick}, {right, height, 0});
}

/// Open shutters beside a window, one object.
void shutters(Modeller& modeller, const Frame& frame, const std::string& name, const Opening& hole) {
    double half = std::min((hole.right - hole.left) / 2, 0.6);
    modeller.begin(name);
    modeller.place(frame);
    modeller.box({hole.left - half, hole.low, 0.06}, {hole.left, hole.high, 0.1});
    modeller.box({hole.right, hole.low, 0.06}, {hole.right + half, hole.high, 0.1});
}

constexpr double kBeam = 0.16, kOut = 0.05;

/// Rails at the given heights and posts in front of a wall: one object, 12 triangles a beam.
void timber(Modeller& modeller, const Frame& frame, const std::string& name, double left, double right,
            double height, std::span<const double> rails, std::span<const double> posts) {
    modeller.begin(name);
    modeller.place(frame);
    for (double y : rails)
        modeller.box({left, y, 0}, {right, y + kBeam, kOut});
    for (double x : posts)
        modeller.box({x - kBeam / 2, 0, 0}, {x + kBeam / 2, height - kBeam, kOut * 0.75});
}

/// Two slanting beams from the foot of a wall into its corners, as part of the current object.
void braces(Modeller& modeller, double left, double right, double height) {
    for (int side = 0; side < 2; ++side) {
        double foot = side ? right - 0.65 : left + 0.65, head = side ? right - 0.1 : left + 0.1;
        Vec3d corners[8];
        for (int k = 0; k < 8; ++k)
            corners[k] = {(k & 2 ? head : foot) + (k & 1 ? 0.07 : -0.07), k & 2 ? height - kBeam : kBeam,
                          k & 4 ? kOut * 0.5 : 0.0};
        modeller.hexahedron(corners);
    }
}

struct House {
    Modeller& modeller;
    Frame frame;
    std::string name;
    double width;
    Random random;

    double half() const { return width / 2; }
    void shell();
    void upper_shell();
    void roof();
    void kitchen();
    void workshop();
    void chamber();
    void jugs(const Frame& ground, const std::string& own, double free, int count);
};

void House::shell() {
    double h = half(), d = kTownHouseDepth;
    block(modeller, frame * at({0, 0, -d}), name + "/floor", {width, kFloor, d});
    Frame base = frame * at({0, kFloor, 0});
    Opening front[] = {{-h + 0.6, -h + 1.6, 0, 2.0}, {0.2, h - 0.9, 0.9, 2.0}},
            back[] = {{-0.6, 0.6, 1.0, 1.9}};
    wall(modeller, base, name + "/wall front", -h, h, kGround, front);
    wall(modeller, base * turned({0, 0, -d}, 0.5), name + "/wall back", -h, h, kGround, back);
    for (int side = 0; side < 2; ++side) {
        modeller.begin(name + (side ? "/wall right" : "/wall left"));
        modeller.place(base);
        double x = side ? h - kThick : -h;
        modeller.box({x, 0, -d + kThick}, {x + kThick, kGround, -kThick});
    }
    Opening doorway[] = {{0.3, 1.2, 0, 1.95}};
    wall(modeller, base * at({0, 0, -d / 2}), name + "/wall inner", -h + kThick, h - kThick, kGround, doorway,
         0.125);
    double turns = random.below(2) ? random.uniform(0.1, 0.24) : 0;
    door(modeller, base * at({-h + 0.6, 0, -0.12}), name + "/door", 1.0, 2.0, turns);
    shutters(modeller, base, name + "/shutters", front[1]);
    double posts[] = {-h + 0.1, -h + 0.45, -h + 1.75, 0.0, h - 0.75, h - 0.1};
    double lintel[] = {kGround - kBeam};
    timber(modeller, base, name + "/timber ground", -h, h, kGround, lintel, posts);
    block(modeller, base * at({-h + 1.1, -0.1, 0.05}), name + "/step", {1.2, 0.1, 0.35});
}

void House::upper_shell() {
    double h = half(), d = kTownHouseDepth;
    Frame base = frame * at({0, kFloor + kGround, 0});
    modeller.begin(name + "/floor upper"); // with the hole for the ladder; along y an outline is (z, x)
    modeller.place(base);
    modeller.ring(Axis::y, {-d, -h}, {kJut, h}, {-d + 0.5, h - 1.3}, {-d + 1.5, h - 0.5}, 0, kSlab);
    base = base * at({0, kSlab, 0});
    Opening front[] = {{-h + 0.7, -h + 1.7, 0.8, 1.8}, {h - 1.7, h - 0.7, 0.8, 1.8}},
            back[] = {{-0.5, 0.5, 0.8, 1.7}};
    Frame jut = base * at({0, 0, kJut});
    wall(modeller, jut, name + "/wall upper front", -h, h, kUpper, front);
    wall(modeller, base * turned({0, 0, -d}, 0.5), name + "/wall upper back", -h, h, kUpper, back);
    for (int side = 0; side < 2; ++side) {
        modeller.begin(name + (side ? "/wall upper right" : "/wall upper left"));
        modeller.place(base);
        double x = side ? h - kThick : -h;
        modeller.box({x, 0, -d + kThick}, {x + kThick, kUpper, kJut - kThick});
    }
    for (int i = 0; i < 2; ++i)
        shutters(modeller, jut, name + "/shutters upper " + std::to_string(i + 1), front[i]);
    double rails[] = {0, 0.6, kUpper - kBeam}, posts[] = {-h + 0.1, -0.75, 0.75, h - 0.1};
    timber(modeller, jut, name + "/timber upper", -h, h, kUpper, rails, posts);
    braces(modeller, -h, h, kUpper);
    timber(modeller, base * turned({0, 0, -d}, 0.5), name + "/timber back", -h, h, kUpper, rails, posts);
    braces(modeller, -h, h, kUpper);
    modeller.begin(name + "/ladder");
    modeller.place(frame * at({h - 0.9, kFloor, -d + 1.4}));
    for (double x : {-0.3, 0.25})
        modeller.box({x, 0, -0.05}, {x + 0.05, kGround + 1, 0});
    for (int rung = 0; rung < 9; ++rung)
        modeller.box({-0.25, 0.25 + 0.3 * rung, -0.04}, {0.25, 0.29 + 0.3 * rung, -0.01});
}

void House::roof() {
    constexpr int kRows = 9;
    double h = half(), d = kTownHouseDepth, ridge = random.uniform(2.8, 3.8), middle = (kJut - d) / 2;
    double y = kFloor + kGround + kSlab + kUpper;
    Frame base = frame * at({0, y, 0});
    modeller.begin(name + "/roof"); // along x an outline is (y, z)
    modeller.place(base);
    Vec2 outline[] = {{0, -d}, {ridge, middle}, {0, kJut}};
    modeller.extrude(Axis::x, outline, -h, h);
    modeller.begin(name + "/tiles"); // rows of boards upon the slopes, each a little over the next lower
    for (int side = 0; side < 2; ++side)
        for (int row = 0; row < kRows; ++row) {
            double eave = side ? -d - 0.3 : kJut + 0.3, low = double(row) / kRows,
                   high = double(row + 1) / kRows;
            auto point = [&](double share, double lift) {
                return Vec3d{0, -0.2 + (ridge + 0.25) * share + lift, eave + (middle - eave) * share};
            };
            Vec3d a = point(low, 0.14), b = point(high, 0.06);
            Vec3d corners[8];
            for (int k = 0; k < 8; ++k) { // z must grow with bit 2
                const Vec3d& end = ((k & 4) != 0) == (side == 0) ? a : b;
                corners[k] = end + Vec3d{k & 1 ? h + 0.05 : -h - 0.05, k & 2 ? 0.05 : 0.0, 0};
            }
            modeller.hexahedron(corners);
        }
    modeller.begin(name + "/chimney");
    modeller.place(base * at({-h + 0.8, 0, middle - 0.6}));
    modeller.box({-0.35, 0.1, -0.35}, {0.35, ridge + 0.9, 0.35});
    modeller.box({-0.45, ridge + 0.9, -0.45}, {0.45, ridge + 1.05, 0.45});
}

void House::jugs(const Frame& ground, const std::string& own, double free, int count) {
    for (int i = 0; i < count; ++i)
        jug(modeller, ground * at({(i + 0.5) * free / count - free / 2, 0, 0.15}),
            own + "/jug " + std::to_string(i + 1), random.uniform(0.15, 0.3));
}

/// The room at the back of the ground floor.
void House::kitchen() {
    double h = half(), d = kTownHouseDepth;
    std::string own = name + "/kitchen";
    Frame room = frame * at({0, kFloor, 0});
    Frame left = room * turned({-h + kThick + 0.01, 0, -d * 0.75}, 0.25);
    modeller.begin(own + "/hearth");
    modeller.place(left);
    Vec2 arch[] = {{-0.9, 0}, {-0.6, 0}, {-0.6, 1.1},    {0.6, 1.1},
                   {0.6, 0},  {0.9, 0},  {0.9, kGround}, {-0.9, kGround}};
    modeller.extrude(Axis::z, arch, 0, 0.9);
    jug(modeller, left * at({0, 0, 0.4}), own + "/kettle", 0.45);
    Frame right = room * turned({h - kThick - 0.01, 0, -d * 0.68}, 0.75);
    shelf(modeller, right, own + "/shelf", {1.4, 1.8, 0.32}, 2,
          [&](int place, const Frame& ground, Size free) {
              jugs(ground, own + "/shelf/row " + std::to_string(place + 1), free.width, 4);
          });
    table(modeller, room * at({0.1, 0, -d + 2.3}), own + "/table", {1.3, 0.75, 0.8});
    desk(modeller, room * at({0.1, 0, -d + 3.2}), own + "/bench", {1.2, 0.45, 0.3});
    jug(modeller, room * at({0.1, 0.75, -d + 2.7}), own + "/jug on the table", 0.25);
    for (int i = 0; i < 2; ++i)
        barrel(modeller, room * at({-h + 0.75 + 0.75 * i, 0, -d + 0.75}),
               own + "/barrel " + std::to_string(i + 1), 0.9);
}

/// The room at the front of the ground floor.
void House::workshop() {
    double h = half(), d = kTownHouseDepth;
    std::string own = name + "/workshop";
    Frame room = frame * at({0, kFloor, 0});
    table(modeller, room * at({h - 1.6, 0, -1.3}), own + "/counter", {1.8, 0.85, 0.7});
    chair(modeller, room * at({h - 1.4, 0, -2.1}), own + "/chair");
    Frame right = room * turned({h - kThick - 0.01, 0, -d * 0.37}, 0.75);
    shelf(modeller, right, own + "/shelf", {1.2, 1.8, 0.32}, 2,
          [&](int place, const Frame& ground, Size free) {
              jugs(ground, own + "/shelf/row " + std::to_string(place + 1), free.width, 3);
          });
    Frame left = room * turned({-h + kThick + 0.01, 0, -d * 0.36}, 0.25);
    modeller.begin(own + "/chest");
    modeller.place(left);
    modeller.open_box({-0.6, 0, 0}, {0.6, 0.55, 0.55}, 0.04, Axis::y);
    modeller.begin(own + "/chest/lid");
    modeller.box({-0.6, 0.55, 0}, {0.6, 0.6, 0.55});
    for (int i = 0; i < 2; ++i)
        block(modeller, left * at({-0.25 + 0.5 * i, 0.04, 0.1}),
              own + "/chest/cloth " + std::to_string(i + 1), {0.35, random.uniform(0.15, 0.4), 0.35});
    for (int i = 0; i < 3; ++i)
        barrel(modeller, room * at({-h + 0.65 + 0.7 * i, 0, -d / 2 + 0.45}),
               own + "/barrel " + std::to_string(i + 1), random.uniform(0.7, 0.95));
}

/// The upper floor, one room.
void House::chamber() {
    double h = half(), d = kTownHouseDepth;
    std::string own = name + "/chamber";
    Frame room = frame * at({0, kFloor + kGround + kSlab, 0});
    for (int i = 0; i < 2; ++i) {
        Frame bed = room * turned({-h + kThick + 0.02, 0, -1.6 - 3.2 * i}, 0.25);
        std::string n = " " + std::to_string(i + 1);
        modeller.begin(own + "/bed" + n);
        modeller.place(bed);
        modeller.box({-0.6, 0, 0}, {0.6, 1.1, 0.06});
        modeller.box({-0.6, 0.3, 0.06}, {0.6, 0.5, 1.9});
        modeller.box({-0.6, 0, 1.9}, {0.6, 0.7, 1.96});
        block(modeller, bed * at({0, 0.5, 0.5}), own + "/blanket" + n, {1.1, 0.08, 1.3});
        block(modeller, bed * at({0, 0.5, 0.1}), own + "/pillow" + n, {0.7, 0.12, 0.35});
        jug(modeller, bed * at({0.85, 0, 0.3}), own + "/pot" + n, 0.3);
    }
    cupboard(modeller, room * turned({h - kThick - 0.01, 0, -d * 0.35}, 0.75), own + "/cupboard",
             {1.3, 1.8, 0.5}, 2);
    Frame inside = room * turned({h - kThick - 0.03, kBoard, -d * 0.35}, 0.75);
    for (int i = 0; i < 3; ++i)
        block(modeller, inside * at({-0.4 + 0.4 * i, 0, 0.02}),
              own + "/cupboard/clothes " + std::to_string(i + 1), {0.3, random.uniform(0.5, 1.5), 0.4});
    table(modeller, room * at({0.8, 0, -d + 2.4}), own + "/table", {1.0, 0.72, 0.7});
    chair(modeller, room * turned({0.8, 0, -d + 3.4}, 0.5), own + "/chair");
    jugs(room * at({0.8, 0.72, -d + 2.6}), own + "/table", 0.9, 3);
}

} // namespace

void jug(Modeller& modeller, const Frame& frame, const std::string& name, double height) {
    modeller.begin(name);
    modeller.place(frame);
    double r = height * 0.35;
    Vec2 profile[] = {{r * 0.7, 0},       {r, height * 0.35}, {r * 0.6, height * 0.75},
                      {r * 0.75, height}, {r * 0.65, height}, {r * 0.5, height * 0.75}};
    modeller.lathe(Axis::y, profile, 10);
}

void barrel(Modeller& modeller, const Frame& frame, const std::string& name, double height) {
    modeller.begin(name);
    modeller.place(frame);
    double r = height * 0.36;
    Vec2 profile[] = {{r * 0.8, 0},
                      {r * 0.95, height * 0.25},
                      {r, height * 0.5},
                      {r * 0.95, height * 0.75},
                      {r * 0.8, height}};
    modeller.lathe(Axis::y, profile, 10);
}

void town_house(Modeller& modeller, const Frame& frame, const std::string& name, double width,
                Random random) {
    House house{modeller, frame, name, width, random};
    house.shell();
    house.upper_shell();
    house.roof();
    house.kitchen();
    house.workshop();
    house.chamber();
}

} // namespace antumbra::generation
