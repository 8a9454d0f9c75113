// The apartment: a living room with a kitchen along its south wall, and a bedroom behind a doorway. Most of
// the objects are small things inside or behind bigger ones, so that few are seen at a time.
//
//        z = 0  +--window--+----+--window--+
//               | living    inner wall     |
//       window  |                 bedroom  |
//               | kitchen   doorway        |
//      z = 4.4  +-----------door+----------+      x from 0 to 8.625, y up
#include "generate/furniture.hpp"
#include "generate/kinds.hpp"

namespace antumbra::generation {
namespace {

constexpr double kHeight = 2.5, kDepth = 4.4, kWall = 0.25, kSlab = 0.2;
constexpr double kInner = 5.0, kBedroom = 5.125, kEast = 8.625;
constexpr double kDoorHeight = 2.0;

// Quarter turns that let a piece of furniture look away from the wall behind it.
constexpr double kFromNorth = 0, kFromWest = 0.25, kFromSouth = 0.5, kFromEast = 0.75;

struct Apartment {
    Modeller modeller;
    Random random;

    void structure();
    void living_room();
    void dining();
    void kitchen();
    void bedroom();
    void study();
    void cylinder(const Frame& frame, const std::string& name, double radius, double height, int sides);
    void fill(const Frame& frame, const std::string& name, Size free, int count);
};

void Apartment::cylinder(const Frame& frame, const std::string& name, double radius, double height,
                         int sides) {
    modeller.begin(name);
    modeller.place(frame);
    modeller.cylinder(Axis::y, radius, 0, height, sides);
}

/// `count` boxes side by side in a free space.
void Apartment::fill(const Frame& frame, const std::string& name, Size free, int count) {
    double step = free.width / count;
    for (int i = 0; i < count; ++i) {
        Size size{step * random.uniform(0.5, 0.8), free.height * random.uniform(0.3, 0.7),
                  free.depth * random.uniform(0.4, 0.8)};
        double x = (i + 0.5) * step - free.width / 2;
        block(modeller, frame * at({x, 0, free.depth * 0.1}), name + "/thing " + std::to_string(i + 1), size);
    }
}

void Apartment::structure() {
    double west = -kWall, east = kEast + kWall, north = -kWall, south = kDepth + kWall,
           middle = (kInner + kBedroom) / 2;
    modeller.begin("floor");
    modeller.box({west, -kSlab, north}, {east, 0, south});
    modeller.begin("ceiling");
    modeller.box({west, kHeight, north}, {east, kHeight + kSlab, south});
    modeller.begin("wall/north living");
    modeller.ring(Axis::z, {west, 0}, {middle, kHeight}, {1.5, 0.9}, {3.3, 2.1}, north, 0);
    modeller.begin("wall/north bedroom");
    modeller.ring(Axis::z, {middle, 0}, {east, kHeight}, {6.2, 0.9}, {7.6, 2.1}, north, 0);
    modeller.begin("wall/west");
    modeller.ring(Axis::x, {0, 0}, {kHeight, kDepth}, {0.9, 1.2}, {2.1, 2.6}, west, 0);
    modeller.begin("wall/east");
    modeller.box({kEast, 0, 0}, {east, kHeight, kDepth});
    modeller.begin("wall/south bedroom");
    modeller.box({middle, 0, kDepth}, {east, kHeight, south});
    modeller.begin("wall/south living"); // with the hole of the entrance
    Vec2 south_outline[] = {{west, 0}, {4.0, 0},    {4.0, kDoorHeight}, {4.85, kDoorHeight},
                            {4.85, 0}, {middle, 0}, {middle, kHeight},  {west, kHeight}};
    modeller.extrude(Axis::z, south_outline, kDepth, south);
    modeller.begin("wall/inner"); // with the doorway; along x an outline is (y, z)
    Vec2 inner_outline[] = {{0, 0},   {kHeight, 0},       {kHeight, kDepth},  {0, kDepth},
                            {0, 3.1}, {kDoorHeight, 3.1}, {kDoorHeight, 2.2}, {0, 2.2}};
    modeller.extrude(Axis::x, inner_outline, kInner, kBedroom);
    door(modeller, at({4.0, 0, kDepth + 0.1}), "door/entrance", 0.85, kDoorHeight, 0);
    door(modeller, turned({kBedroom + 0.03, 0, 2.2}, 0.75), "door/bedroom", 0.86, kDoorHeight, 0.22);
    window(modeller, at({0, 0, -0.12}), "window/living north", {1.5, 0.9}, {3.3, 2.1});
    window(modeller, at({0, 0, -0.12}), "window/bedroom", {6.2, 0.9}, {7.6, 2.1});
    window(modeller, turned({-0.12, 0, 0}, 0.75), "window/living west", {1.2, 0.9}, {2.6, 2.1});
}

void Apartment::living_room() {
    block(modeller, at({3.0, 0, 0.9}), "living/carpet", {2.2, 0.01, 1.3});
    Frame sofa = turned({3.0, 0, 2.55}, kFromSouth);
    modeller.begin("living/sofa");
    modeller.place(sofa);
    modeller.box({-0.95, 0.05, 0.2}, {0.95, 0.42, 0.85});
    modeller.box({-0.95, 0.05, 0}, {0.95, 0.85, 0.2});
    modeller.box({-1.1, 0.05, 0}, {-0.95, 0.6, 0.85});
    modeller.box({0.95, 0.05, 0}, {1.1, 0.6, 0.85});
    block(modeller, sofa * at({-0.6, 0.42, 0.22}), "living/cushion 1", {0.45, 0.4, 0.12});
    block(modeller, sofa * at({0.55, 0.42, 0.25}), "living/cushion 2", {0.45, 0.35, 0.12});
    desk(modeller, at({3.0, 0.01, 1.2}), "living/coffee table", {1.0, 0.4, 0.35});
    Frame board = at({3.0, 0, 0.02});
    cupboard(modeller, board, "living/low board", {1.5, 0.45, 0.4}, 2);
    fill(board * at({0, kBoard, kBoard}), "living/low board", {1.4, 0.4, 0.36}, 2);
    modeller.begin("living/television");
    modeller.place(board * at({0, 0.45, 0}));
    modeller.box({-0.25, 0, 0.1}, {0.25, 0.05, 0.3});
    modeller.box({-0.55, 0.05, 0.18}, {0.55, 0.7, 0.22});
    // Its back to the inner wall, its side to the north wall.
    shelf(modeller, turned({kInner - 0.01, 0, 0.6}, kFromEast), "living/bookshelf", {1.1, 1.9, 0.28}, 3,
          [&](int place, const Frame& ground, Size free) {
              books(modeller, ground, "living/bookshelf/row " + std::to_string(place + 1), place % 2 ? 3 : 2,
                    -free.width / 2 + 0.02, free.width / 2 - 0.1 * place - 0.1, free.height * 0.9, random);
          });
    lamp(modeller, at({0.35, 0, 0.35}), "living/floor lamp", 1.6, 0.22);
    block(modeller, turned({0.005, 1.3, 0.75}, kFromWest), "living/picture 1", {0.5, 0.6, 0.02});
    block(modeller, turned({kInner - 0.005, 1.4, 1.75}, kFromEast), "living/picture 2", {0.7, 0.5, 0.02});
}

void Apartment::dining() {
    Frame board = turned({0.75, 0, 1.9}, kFromWest) * at({0, 0, -0.4});
    table(modeller, board, "dining/table", {1.2, 0.75, 0.8});
    int number = 0;
    for (double x : {-0.3, 0.3})
        for (int side = 0; side < 2; ++side) {
            ++number;
            std::string n = std::to_string(number);
            Frame seat = side == 0 ? board * at({x, 0, -0.28}) : board * turned({x, 0, 1.12}, 0.5);
            chair(modeller, seat, "dining/chair " + n);
            modeller.begin("dining/plate " + n);
            modeller.place(board * at({x, 0.75, side == 0 ? 0.18 : 0.62}));
            Vec2 profile[2] = {{0.07, 0}, {0.12, 0.02}};
            modeller.lathe(Axis::y, profile, 5);
        }
    modeller.begin("dining/bowl");
    modeller.place(board * at({0, 0.75, 0.4}));
    Vec2 bowl[4] = {{0.06, 0}, {0.15, 0.08}, {0.13, 0.08}, {0.05, 0.02}};
    modeller.lathe(Axis::y, bowl, 5);
    for (int i = 0; i < 3; ++i) {
        modeller.begin("dining/fruit " + std::to_string(i + 1));
        modeller.place(board * turned({0, 0.75, 0.4}, i / 3.0));
        modeller.octahedron({0.045, 0.055, 0}, {0.035, 0.035, 0.035});
    }
}

void Apartment::kitchen() {
    // Along the south wall from the west: three cupboards, drawers, stove, refrigerator.
    auto along = [&](double x, double y) { return turned({x, y, kDepth - 0.01}, kFromSouth); };
    for (int i = 0; i < 3; ++i) {
        std::string name = "kitchen/cupboard " + std::to_string(i + 1);
        Frame place = along(0.31 + 0.6 * i, 0);
        cupboard(modeller, place, name, {0.6, 0.85, 0.55}, 1);
        for (int pot = 0; pot < 3; ++pot)
            cylinder(place * at({-0.16 + 0.16 * pot, kBoard, 0.15 + 0.1 * pot}),
                     name + "/pot " + std::to_string(pot + 1), 0.07, random.uniform(0.1, 0.3), 6);
    }
    drawers(
        modeller, along(2.11, 0), "kitchen/drawers", {0.6, 0.85, 0.57}, 3,
        [&](int, const std::string& name, const Frame& ground, Size free) { fill(ground, name, free, 2); });
    block(modeller, along(1.21, 0.85), "kitchen/worktop", {2.4, 0.04, 0.6});
    modeller.begin("kitchen/sink");
    modeller.place(along(0.9, 0.89));
    modeller.open_box({-0.25, 0, 0.1}, {0.25, 0.06, 0.5}, kBoard, Axis::y);
    block(modeller, along(2.71, 0), "kitchen/stove", {0.6, 0.89, 0.58});
    cylinder(along(2.6, 0.89) * at({0, 0, 0.25}), "kitchen/stove pot", 0.11, 0.16, 5);
    Frame cold = along(3.36, 0);
    cupboard(modeller, cold, "kitchen/refrigerator", {0.6, 1.7, 0.58}, 1);
    for (int level = 0; level < 3; ++level) {
        std::string name = "kitchen/refrigerator/level " + std::to_string(level + 1);
        double y = kBoard + 0.55 * level;
        if (level > 0)
            block(modeller, cold * at({0, y - 0.01, kBoard}), name + " board", {0.56, 0.01, 0.5});
        fill(cold * at({0, y, kBoard}), name, {0.5, 0.5, 0.5}, level == 1 ? 1 : 2);
    }
    for (int i = 0; i < 2; ++i) {
        std::string name = "kitchen/wall cupboard " + std::to_string(i + 1);
        Frame place = along(0.46 + 0.9 * i, 1.45);
        cupboard(modeller, place, name, {0.9, 0.6, 0.32}, 1);
        for (int cup = 0; cup < 3; ++cup)
            block(modeller, place * at({-0.25 + 0.25 * cup, kBoard, 0.1}),
                  name + "/cup " + std::to_string(cup + 1), {0.09, 0.11, 0.09});
    }
}

void Apartment::bedroom() {
    Frame bed = turned({kEast - 0.01, 0, 2.2}, kFromEast);
    modeller.begin("bedroom/bed");
    modeller.place(bed);
    modeller.box({-0.8, 0, 0}, {0.8, 0.95, 0.05});
    modeller.box({-0.8, 0.25, 0.05}, {0.8, 0.45, 2.05});
    modeller.box({-0.8, 0, 2.05}, {0.8, 0.5, 2.1});
    block(modeller, bed * at({0, 0.45, 0.6}), "bedroom/duvet", {1.5, 0.08, 1.4});
    block(modeller, bed * at({-0.38, 0.45, 0.08}), "bedroom/pillow 1", {0.6, 0.12, 0.4});
    block(modeller, bed * at({0.38, 0.45, 0.08}), "bedroom/pillow 2", {0.6, 0.12, 0.4});
    block(modeller, bed * at({-0.3, 0, 0.6}), "bedroom/box under bed 1", {0.5, 0.2, 0.7});
    block(modeller, bed * at({0.35, 0, 0.9}), "bedroom/box under bed 2", {0.5, 0.18, 0.7});
    for (int side = 0; side < 2; ++side) {
        std::string name = "bedroom/nightstand " + std::to_string(side + 1);
        Frame place = bed * at({side ? 1.06 : -1.06, 0, 0});
        drawers(
            modeller, place, name, {0.45, 0.4, 0.4}, 1,
            [&](int, const std::string& own, const Frame& ground, Size free) { fill(ground, own, free, 1); });
        lamp(modeller, place * at({0, 0.4, 0.2}), name + "/lamp", 0.45, 0.13);
    }
    Frame wardrobe = turned({7.4, 0, kDepth - 0.01}, kFromSouth);
    cupboard(modeller, wardrobe, "bedroom/wardrobe", {1.8, 2.1, 0.6}, 2);
    block(modeller, wardrobe * at({0, 1.75, 0.3}), "bedroom/wardrobe/rod", {1.76, 0.03, 0.03});
    for (int i = 0; i < 4; ++i)
        block(modeller, wardrobe * at({-0.6 + 0.3 * i, 0.7, 0.1}),
              "bedroom/wardrobe/coat " + std::to_string(i + 1), {0.08, random.uniform(0.8, 1), 0.45});
    fill(wardrobe * at({0, kBoard, kBoard}), "bedroom/wardrobe", {1.7, 0.5, 0.5}, 2);
    drawers(modeller, turned({7.4, 0, 0.02}, kFromNorth), "bedroom/chest", {1.0, 0.85, 0.45}, 4,
            [&](int i, const std::string& own, const Frame& ground, Size free) {
                fill(ground, own, free, 1 + i % 2);
            });
    block(modeller, at({6.9, 0, 1.0}), "bedroom/carpet", {1.6, 0.01, 0.5});
}

void Apartment::study() {
    // In the bedroom's north-west corner.
    Frame place = turned({kBedroom + 0.01, 0, 0.65}, kFromWest);
    desk(modeller, place, "study/desk", {1.2, 0.74, 0.6});
    chair(modeller, place * turned({0, 0, 1.05}, 0.5), "study/chair");
    modeller.begin("study/screen");
    modeller.place(place * at({0, 0.74, 0.1}));
    modeller.box({-0.12, 0, 0}, {0.12, 0.1, 0.15});
    modeller.box({-0.3, 0.1, 0.05}, {0.3, 0.48, 0.08});
    block(modeller, place * at({0, 0.74, 0.35}), "study/keyboard", {0.44, 0.02, 0.15});
    lamp(modeller, place * at({-0.48, 0.74, 0.2}), "study/lamp", 0.4, 0.1);
    books(modeller, place * at({0, 0.74, 0}), "study", 2, 0.4, 0.5, 0.28, random);
    // Beside the doorway, its back to the inner wall.
    shelf(modeller, turned({kBedroom + 0.01, 0, 3.85}, kFromWest), "study/bookshelf", {0.8, 1.5, 0.28}, 2,
          [&](int row, const Frame& ground, Size free) {
              books(modeller, ground, "study/bookshelf/row " + std::to_string(row + 1), 2,
                    -free.width / 2 + 0.02, free.width / 2 - 0.2, free.height * 0.85, random);
          });
    block(modeller, turned({kBedroom + 0.005, 1.3, 1.6}, kFromWest), "study/mirror", {0.5, 0.8, 0.02});
}

/// The same flat again and again, as the paper made its apartment block: six storeys, then the next column.
RawScene block_of(const RawScene& flat, std::uint32_t copies) {
    // Whole multiples of the grid, so that all flats are exactly alike; storeys are 6 mm apart, columns 1.9
    // m.
    constexpr double kStorey = 2.90625, kColumn = 11;
    RawScene block;
    block.source = flat.source;
    for (std::uint32_t c = 0; c < copies; ++c) {
        Vec3d offset{c / 6 * kColumn, c % 6 * kStorey, 0};
        auto first_vertex = static_cast<std::uint32_t>(block.positions.size());
        auto first_triangle = static_cast<std::uint32_t>(block.triangles.size());
        for (const Vec3d& p : flat.positions)
            block.positions.push_back(p + offset);
        for (const TriangleIndices& t : flat.triangles)
            block.triangles.push_back({t[0] + first_vertex, t[1] + first_vertex, t[2] + first_vertex});
        for (RawObject object : flat.objects) {
            object.id.node = static_cast<std::int32_t>(block.objects.size());
            object.name = "flat " + std::to_string(c + 1) + "/" + object.name;
            object.first_triangle += first_triangle;
            block.objects.push_back(std::move(object));
        }
    }
    return block;
}

} // namespace

Result<RawScene> apartment(const GenerateOptions& options) {
    constexpr std::uint32_t kMostCopies = 10'000;
    if (options.triangles)
        return Status(ErrorCode::usage, "the apartment has one size; leave out the wanted triangles");
    if (options.copies < 1 || options.copies > kMostCopies)
        return Status(ErrorCode::usage,
                      "an apartment block has 1 to 10000 copies, not " + std::to_string(options.copies));
    Apartment apartment{Modeller("generate apartment"), Random(options.seed, 0x61706172)};
    apartment.structure();
    apartment.living_room();
    apartment.dining();
    apartment.kitchen();
    apartment.bedroom();
    apartment.study();
    RawScene flat = apartment.modeller.finish();
    return options.copies == 1 ? std::move(flat) : block_of(flat, options.copies);
}

} // namespace antumbra::generation
