#include "bake/resumable.hpp"
#include "base/bytes.hpp"
#include "mos/choose_list.hpp"

#include <antumbra/bake.hpp>

#include <chrono>
#include <ctime>
#include <mutex>

namespace antumbra {
namespace {

constexpr std::uint64_t kMostPoints = 1u << 20;

Status check(const MosOptions& options) {
    auto usage = [](const char* text) { return Status(ErrorCode::usage, std::string("minimum occluder sets: ") + text); };
    std::uint64_t points = 1;
    for (std::uint32_t count : options.grid) {
        if (count < 1 || count > kMostPoints)
            return usage("the grid needs 1 to 1048576 points along each axis");
        points *= count;
    }
    if (points > kMostPoints)
        return usage("the grid has more than 1048576 points");
    if (options.resolution < 8 || options.resolution > 1024)
        return usage("a picture has 8 to 1024 pixels along its side");
    if (options.limit < 1 || options.layers < 1 || options.sets_per_occludee < 1)
        return usage("at least one occluder, one layer and one set per occludee are needed");
    for (double weight : {options.occludee_weight, options.primitive_weight, options.size_weight})
        if (!(weight >= 0 && std::isfinite(weight)))
            return usage("a weight is negative or not finite");
    if (!(options.polygon_weight > 0 && std::isfinite(options.polygon_weight)))
        return usage("the weight of a polygon must be above 0");
    return {};
}

std::string key_of(const Scene& scene, const OccluderSet& occluders, const MosOptions& o, const OccluderDatabase& grid) {
    std::string key = "mos 1 " + to_hex(scene.fingerprint()) + " " + std::to_string(occluders.polygons.size());
    for (std::uint64_t value : {std::uint64_t(o.criterion), std::uint64_t(o.selection), std::uint64_t(o.limit),
                                std::uint64_t(o.resolution), std::uint64_t(o.least_primitives),
                                std::uint64_t(o.most_primitives), std::uint64_t(o.least_pixels), std::uint64_t(o.layers),
                                std::uint64_t(o.sets_per_occludee), std::uint64_t(o.work_per_occludee)})
        key += " " + std::to_string(value);
    for (double value : {o.occludee_weight, o.primitive_weight, o.polygon_weight, o.size_weight, grid.origin.x,
                         grid.origin.y, grid.origin.z, grid.step.x, grid.step.y, grid.step.z})
        key += " " + std::to_string(std::bit_cast<std::uint64_t>(value));
    for (std::uint32_t count : grid.count)
        key += " " + std::to_string(count);
    return key;
}

/// Points in the middles of the cells of a grid over the region.
OccluderDatabase grid_over(const Scene& scene, const MosOptions& options) {
    OccluderDatabase database;
    database.count = options.grid;
    Box3d region = to_double(scene.local_bounds());
    if (!options.region.empty())
        region = {scene.to_local(options.region.min), scene.to_local(options.region.max)};
    for (int axis = 0; axis < 3; ++axis) {
        double size = region.max[axis] - region.min[axis];
        double count = options.grid[static_cast<std::size_t>(axis)];
        database.step[axis] = size > 0 ? size / count : 1;
        database.origin[axis] = region.min[axis] + (size > 0 ? database.step[axis] / 2 : 0);
    }
    return database;
}

/// Six lists of one point: their lengths, then their polygons.
using Lists = std::array<std::vector<std::uint32_t>, OccluderDatabase::kDirections>;

Payload encode(const Lists& lists) {
    ByteWriter out;
    for (const std::vector<std::uint32_t>& list : lists)
        out.u32(static_cast<std::uint32_t>(list.size()));
    for (const std::vector<std::uint32_t>& list : lists)
        for (std::uint32_t polygon : list)
            out.u32(polygon);
    return std::move(out.bytes);
}

bool decode(std::span<const std::byte> bytes, std::size_t polygons, Lists& lists) {
    std::size_t total = 0;
    if (bytes.size() < 4 * lists.size())
        return false;
    for (std::size_t d = 0; d < lists.size(); ++d) {
        std::size_t length = load_u32(bytes, 4 * d);
        if (length > bytes.size())
            return false;
        lists[d].resize(length);
        total += length;
    }
    if (bytes.size() != 4 * (lists.size() + total))
        return false;
    std::size_t at = 4 * lists.size();
    for (std::vector<std::uint32_t>& list : lists)
        for (std::uint32_t& polygon : list) {
            polygon = load_u32(bytes, at);
            at += 4;
            if (polygon >= polygons)
                return false;
        }
    return true;
}

} // namespace

Result<OccluderDatabase> build_occluder_database(const Scene& scene, const OccluderSet& occluders,
                                                 const MosOptions& options, const Job& job,
                                                 MosStatistics* statistics) {
    if (Status status = check(options); !status)
        return status;
    auto start = std::chrono::steady_clock::now();
    std::clock_t cpu = std::clock();
    OccluderDatabase database = grid_over(scene, options);
    const std::vector<Occludee> occludees = find_occludees(scene, options);
    double extent = length(to_double(scene.local_bounds().max) - to_double(scene.local_bounds().min));
    MosStatistics counts;
    std::mutex mutex; // sums do not depend on the order
    Units units;
    units.stage = "minimum occluder sets";
    units.unit_name = "points";
    for (std::size_t p = 0; p < database.points(); ++p)
        units.ids.push_back(p);
    units.compute = [&](std::size_t p) {
        Lists lists;
        MosStatistics own;
        for (std::uint32_t d = 0; d < OccluderDatabase::kDirections; ++d)
            lists[d] = choose_list(occluders, occludees, picture_of(database.point(p), d, options.resolution, extent),
                                   options, &own);
        std::lock_guard lock(mutex);
        counts.pictures += own.pictures;
        counts.occludees += own.occludees;
        counts.uncovered += own.uncovered;
        counts.sets += own.sets;
        counts.searches_cut += own.searches_cut;
        return encode(lists);
    };
    units.acceptable = [&](std::size_t, std::span<const std::byte> bytes) {
        Lists lists;
        return decode(bytes, occluders.polygons.size(), lists);
    };
    BakeOptions checkpoint;
    checkpoint.checkpoint = options.checkpoint;
    checkpoint.resume = options.resume;
    Result<UnitResults> results = run_units(units, key_of(scene, occluders, options, database), checkpoint, job);
    if (!results)
        return results.status();
    database.first.assign(1, 0);
    for (const Payload& payload : results->payloads) {
        Lists lists;
        if (!decode(payload, occluders.polygons.size(), lists))
            return Status(ErrorCode::internal, "minimum occluder sets: a finished point cannot be read back; please report this");
        for (const std::vector<std::uint32_t>& list : lists) {
            database.polygons.insert(database.polygons.end(), list.begin(), list.end());
            database.first.push_back(static_cast<std::uint32_t>(database.polygons.size()));
        }
    }
    counts.points_resumed = results->resumed;
    counts.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    counts.cpu_seconds = double(std::clock() - cpu) / CLOCKS_PER_SEC;
    if (statistics)
        *statistics = counts;
    return database;
}

} // namespace antumbra
