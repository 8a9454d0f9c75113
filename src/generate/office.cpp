// The office: storeys of equal plan. A corridor runs along x between two rows of rooms; a lobby with the
// stairs closes its west end. Everything is closed in, so that from a room one sees that room, some corridor
// and, through open doors, slices of other rooms.
//
//        z = -0.25  +--------+------+------+--
//        z = 0      | stairs | room | room |        north rooms
//        z = 5      |        +-door-+-door-+--
//                   | lobby    corridor             2 m wide
//        z = 7.25   |        +-door-+-door-+--
//                   |        | room | room |        south rooms
//        z = 12.5   +--------+------+------+--
#include "generate/furniture.hpp"
#include "generate/kinds.hpp"
#include "generate/plant.hpp"

namespace antumbra::generation {
namespace {

constexpr double kPitch = 3.0, kClear = 2.75; // from floor to floor, to the ceiling
constexpr double kRoomWidth = 4.0, kRoomDepth = 5.0, kWall = 0.125, kOuter = 0.25;
constexpr double kNorthWall = 5.125, kSouthWall = 7.125,
                 kSouth = 12.25; // corridor sides, inner face of the outer wall
constexpr double kLobby = 5.0, kBay = kRoomWidth + kWall;
constexpr double kDoorLeft = 0.5, kDoorRight = 1.4, kDoorHeight = 2.1;
constexpr int kBoards = 4, kBooksPerPlace = 16, kPlacesPerShelf = kBoards + 1;

constexpr std::uint64_t kDefaultTriangles = 120'000, kSmallest = 4'000, kLargest = 50'000'000;
constexpr std::uint32_t kMostStoreys = 200;

struct Office {
    Modeller modeller{"generate office"};
    std::uint64_t seed = 1;
    int storeys = 1, rooms_per_side = 1;
    /// Filled while the rooms are built; then used for what brings the scene to its size.
    struct Place {
        Frame frame;
        std::string name;
        Size free;
    };
    std::vector<Place> book_places, plant_places;

    double east() const { return kLobby + kWall + rooms_per_side * kBay; } // where the last partition ends
    void plan(std::uint64_t triangles, std::uint32_t wanted_storeys);
    void slabs(double y, const std::string& name, bool hole);
    void lobby(double y, const std::string& name, bool stairs);
    void room(const Frame& frame, const std::string& name, double left, double right, double corridor_left,
              double corridor_right, Random random);
    void furnish(const Frame& frame, const std::string& name, Random& random);
    void storey(int level);
    void fill(std::uint64_t triangles, std::uint32_t wanted_plants);
};

/// As many rooms as the size asks for, in a building of sensible proportions.
void Office::plan(std::uint64_t triangles, std::uint32_t wanted_storeys) {
    // Of each room's 1,820 triangles about 560 are walls and furniture, 730 plants and 530 books.
    double rooms = std::max(2.0, double(triangles) / 1820);
    storeys = wanted_storeys > 0 ? static_cast<int>(wanted_storeys)
                                 : std::max(1, static_cast<int>(std::sqrt(rooms) / 3 + 0.5));
    rooms_per_side = std::max(1, static_cast<int>(rooms / (2.0 * storeys) + 0.5));
}

/// The floor of a storey (or the roof) at height y: one slab per bay of two rooms.
void Office::slabs(double y, const std::string& name, bool hole) {
    double low = y - (kPitch - kClear), north = -kOuter, south = kSouth + kOuter, joint = kLobby + kWall / 2;
    modeller.place({});
    modeller.begin(name + "/slab lobby");
    if (hole) // along y an outline is (z, x)
        modeller.ring(Axis::y, {north, -kOuter}, {south, joint}, {1, 0.75}, {2.5, 4.5}, low, y);
    else
        modeller.box({-kOuter, low, north}, {joint, y, south});
    for (int i = 0; i < rooms_per_side; ++i) {
        double right = i + 1 == rooms_per_side ? east() + kOuter : joint + (i + 1) * kBay;
        modeller.begin(name + "/slab " + std::to_string(i + 1));
        modeller.box({joint + i * kBay, low, north}, {right, y, south});
    }
}

void Office::lobby(double y, const std::string& name, bool stairs) {
    double joint = kLobby + kWall / 2;
    modeller.place(at({0, y, 0}));
    modeller.begin(name + "/wall west");
    modeller.box({-kOuter, 0, 0}, {0, kClear, kSouth});
    modeller.begin(name + "/wall east");
    modeller.box({east(), 0, 0}, {east() + kOuter, kClear, kSouth});
    modeller.begin(name + "/wall lobby north");
    modeller.ring(Axis::z, {-kOuter, 0}, {joint, kClear}, {1, 0.9}, {4, 2.2}, -kOuter, 0);
    modeller.begin(name + "/wall lobby south");
    modeller.ring(Axis::z, {-kOuter, 0}, {joint, kClear}, {1, 0.9}, {4, 2.2}, kSouth, kSouth + kOuter);
    window(modeller, at({0, y, -0.125}), name + "/window lobby north", {1, 0.9}, {4, 2.2});
    window(modeller, at({0, y, kSouth + 0.125}), name + "/window lobby south", {1, 0.9}, {4, 2.2});
    modeller.place(at({0, y, 0}));
    for (int side = 0; side < 2; ++side) {
        modeller.begin(name + "/wall lobby " + (side ? "south partition" : "north partition"));
        double z = side ? kSouthWall + kWall : 0;
        modeller.box({kLobby, 0, z}, {kLobby + kWall, kClear, z + kRoomDepth});
    }
    for (double z : {6.0, 8.5, 11.0})
        plant_places.push_back({at({0.6, y, z}), "", {}});
    if (!stairs)
        return;
    constexpr int kSteps = 16;
    constexpr double kRise = kPitch / kSteps, kTread = 0.25, kFoot = 0.5;
    std::vector<Vec2> outline = {{kFoot, 0}, {kFoot + kTread, 0}, {kFoot + kSteps * kTread, kPitch - kRise}};
    for (int i = kSteps; i > 0; --i) {
        outline.push_back({kFoot + i * kTread, i * kRise});
        outline.push_back({kFoot + (i - 1) * kTread, i * kRise});
    }
    modeller.begin(name + "/stairs");
    modeller.extrude(Axis::z, outline, 1.125, 2.375);
    modeller.place(at({0, y + kPitch, 0}));
    modeller.begin(name + "/railing");
    for (double z : {0.95, 2.5}) {
        modeller.box({0.75, 0.9, z}, {4.5, 0.95, z + 0.05});
        for (double x : {0.75, 4.45})
            modeller.box({x, 0, z}, {x + 0.05, 0.9, z + 0.05});
    }
}

/// `frame`: x from 0 to kRoomWidth along the facade, z from the window (0) to the corridor (kRoomDepth). The
/// outer wall reaches from x = left to right, the wall of the corridor likewise.
void Office::room(const Frame& frame, const std::string& name, double left, double right,
                  double corridor_left, double corridor_right, Random random) {
    modeller.place(frame);
    modeller.begin(name + "/wall window");
    modeller.ring(Axis::z, {left, 0}, {right, kClear}, {0.8, 0.9}, {3.2, 2.2}, -kOuter, 0);
    modeller.begin(name + "/wall corridor");
    Vec2 outline[] = {{corridor_left, 0},        {kDoorLeft, 0},         {kDoorLeft, kDoorHeight},
                      {kDoorRight, kDoorHeight}, {kDoorRight, 0},        {corridor_right, 0},
                      {corridor_right, kClear},  {corridor_left, kClear}};
    modeller.extrude(Axis::z, outline, kRoomDepth, kRoomDepth + kWall);
    window(modeller, frame * at({0, 0, -0.125}), name + "/window", {0.8, 0.9}, {3.2, 2.2});
    // Half of the doors are closed; the others stand at any angle.
    double turns = random.below(2) ? random.uniform(0.05, 0.24) : 0;
    door(modeller, frame * at({kDoorLeft, 0, kRoomDepth + 0.0625}), name + "/door", kDoorRight - kDoorLeft,
         kDoorHeight, turns);
    furnish(frame, name, random);
}

void Office::furnish(const Frame& frame, const std::string& name, Random& random) {
    desk(modeller, frame * at({2, 0, 0.1}), name + "/desk", {1.6, 0.74, 0.75});
    modeller.begin(name + "/screen");
    modeller.place(frame * at({2 + random.uniform(-0.3, 0.3), 0.74, 0.25}));
    modeller.box({-0.12, 0, 0}, {0.12, 0.1, 0.15});
    modeller.box({-0.3, 0.1, 0.05}, {0.3, 0.48, 0.08});
    block(modeller, frame * at({2, 0.74, 0.55}), name + "/keyboard", {0.44, 0.02, 0.15});
    double turn = random.uniform(-0.1, 0.1), aside = random.uniform(-0.2, 0.2);
    chair(modeller, frame * turned({2 + aside, 0, 1.6}, 0.5 + turn), name + "/chair");
    block(modeller, frame * at({2, kClear - 0.06, 2.4}), name + "/lamp", {1.2, 0.06, 0.2});
    for (int i = 0; i < 2; ++i) {
        std::string own = name + "/shelf " + std::to_string(i + 1);
        Frame wall = frame * turned({0.0078125, 0, 2.2 + 1.25 * i}, 0.25);
        shelf(modeller, wall, own, {1.2, 2.1, 0.3}, kBoards, [&](int place, const Frame& ground, Size free) {
            book_places.push_back({ground, own + "/row " + std::to_string(place + 1), free});
        });
    }
    Frame east = frame * turned({kRoomWidth - 0.0078125, 0, 2.0}, 0.75);
    cupboard(modeller, east, name + "/cupboard", {1.0, 1.2, 0.4}, 2);
    for (int i = 0; i < 2; ++i)
        block(modeller, east * at({0, kBoard + 0.5 * i, 0.05}),
              name + "/cupboard/box " + std::to_string(i + 1),
              {random.uniform(0.4, 0.9), random.uniform(0.2, 0.45), 0.3});
    if (random.below(5) < 2) {
        Frame middle = frame * at({2.5, 0, 3.0});
        table(modeller, middle, name + "/meeting table", {1.0, 0.74, 0.7});
        chair(modeller, middle * turned({0, 0, 1.15}, 0.5), name + "/visitor 1");
        chair(modeller, middle * turned({-0.95, 0, 0.35}, 0.25), name + "/visitor 2");
    }
    plant_places.push_back({frame * at({3.5, 0, 4.5}), "", {}});
    plant_places.push_back({frame * at({0.5, 0, 0.6}), "", {}});
    plant_places.push_back({frame * at({3.5, 0, 0.6}), "", {}});
    // In the corridor, between the doors.
    plant_places.push_back({frame * at({2.75, 0, kRoomDepth + kWall + 0.5}), "", {}});
}

void Office::storey(int level) {
    double y = level * kPitch;
    std::string name = "storey " + std::to_string(level + 1);
    slabs(y, name, level > 0);
    lobby(y, name, level + 1 < storeys);
    for (int i = 0; i < rooms_per_side; ++i) {
        bool last = i + 1 == rooms_per_side;
        double x = kLobby + kWall + i * kBay, half = kWall / 2;
        for (int side = 0; side < 2; ++side) {
            std::string own = name + (side ? "/south " : "/north ") + std::to_string(i + 1);
            Random random(seed, (std::uint64_t(level) << 32) | static_cast<std::uint32_t>(2 * i + side),
                          0x6f666669);
            double end = kRoomWidth + (last ? kWall + kOuter : half),
                   corridor_end = kRoomWidth + (last ? kWall : half);
            if (side == 0)
                room(at({x, y, 0}), own, -half, end, -half, corridor_end, random);
            else // turned half around: left and right change places
                room(turned({x + kRoomWidth, y, kSouth}, 0.5), own, kRoomWidth - end, kRoomWidth + half,
                     kRoomWidth - corridor_end, kRoomWidth + half, random);
            modeller.place(at({x, y, side ? kSouthWall + kWall : 0}));
            modeller.begin(own + "/partition");
            modeller.box({kRoomWidth, 0, 0}, {kRoomWidth + kWall, kClear, kRoomDepth});
        }
    }
}

/// Plants and books until `triangles` are reached.
void Office::fill(std::uint64_t triangles, std::uint32_t wanted_plants) {
    std::uint64_t left = triangles > modeller.triangle_count() ? triangles - modeller.triangle_count() : 0;
    std::uint64_t most_books = book_places.size() * kBooksPerPlace;
    std::uint64_t plants = left * 6 / 10 / kPlantTriangles;
    // What the shelves cannot take becomes plants.
    if (left - plants * kPlantTriangles > most_books * 12)
        plants = (left - most_books * 12) / kPlantTriangles + 1;
    plants = std::min<std::uint64_t>({plants, plant_places.size(), left / kPlantTriangles});
    if (wanted_plants > 0)
        plants = wanted_plants;
    std::uint64_t all_books = std::min((left - std::min(left, plants * kPlantTriangles)) / 12, most_books);
    Random random(seed, 0x706c616e, 0x6f666669);
    for (std::uint64_t i = 0; i < plants; ++i) { // a random choice without repetition
        auto other = i + random.below(static_cast<std::uint32_t>(plant_places.size() - i));
        std::swap(plant_places[i], plant_places[other]);
        // Eight shapes in four directions, so that a file can share their meshes.
        Frame frame = plant_places[i].frame * turned({}, random.below(4) * 0.25);
        plant(modeller, frame, "plant " + std::to_string(i + 1), Random(seed, random.below(8), 0x706c616e));
    }
    for (std::uint64_t i = 0; i < book_places.size(); ++i) {
        const Place& place = book_places[i];
        auto count =
            static_cast<int>(all_books * (i + 1) / book_places.size() - all_books * i / book_places.size());
        if (count > 0) {
            Random own(seed, i, 0x626f6f6b);
            double used = place.free.width * std::min(0.95, 0.07 * count) * own.uniform(0.8, 1);
            books(modeller, place.frame, place.name, count, -place.free.width / 2 + 0.01,
                  -place.free.width / 2 + 0.01 + used, place.free.height * 0.9, own);
        }
    }
}

} // namespace

Result<RawScene> office(const GenerateOptions& options) {
    std::uint64_t triangles = options.triangles ? options.triangles : kDefaultTriangles;
    if (triangles < kSmallest || triangles > kLargest)
        return Status(ErrorCode::usage, "an office has from " + std::to_string(kSmallest) + " to " +
                                            std::to_string(kLargest) + " triangles, not " +
                                            std::to_string(triangles));
    Office office;
    office.seed = options.seed;
    if (options.storeys > kMostStoreys)
        return Status(ErrorCode::usage, "an office has at most " + std::to_string(kMostStoreys) + " storeys, not " +
                                            std::to_string(options.storeys));
    office.plan(triangles, options.storeys);
    for (int level = 0; level < office.storeys; ++level)
        office.storey(level);
    office.slabs(office.storeys * kPitch, "roof", false);
    if (options.plants > office.plant_places.size())
        return Status(ErrorCode::usage, "an office of this size has room for " +
                                            std::to_string(office.plant_places.size()) + " plants, not " +
                                            std::to_string(options.plants) + "; give it more --triangles or --storeys");
    office.fill(triangles, options.plants);
    return office.modeller.finish();
}

} // namespace antumbra::generation
