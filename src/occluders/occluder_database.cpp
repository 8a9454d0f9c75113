#include <antumbra/occluder_database.hpp>

#include "base/bytes.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace antumbra {

Vec3d OccluderDatabase::point(std::size_t index) const {
    std::size_t i = index % count[0], j = index / count[0] % count[1], k = index / count[0] / count[1];
    return {origin.x + step.x * double(i), origin.y + step.y * double(j), origin.z + step.z * double(k)};
}

std::size_t OccluderDatabase::nearest(const Vec3d& eye) const {
    std::size_t index = 0;
    for (int axis = 2; axis >= 0; --axis) {
        auto most = double(count[static_cast<std::size_t>(axis)] - 1);
        double place = std::clamp((eye[axis] - origin[axis]) / step[axis] + 0.5, 0.0, most); // NaN stays NaN
        index = index * count[static_cast<std::size_t>(axis)] + static_cast<std::size_t>(place > 0 ? place : 0);
    }
    return index;
}

std::span<const std::uint32_t> OccluderDatabase::list(std::size_t point, std::uint32_t direction) const {
    std::size_t at = point * kDirections + direction;
    if (at + 1 >= first.size())
        return {};
    return {polygons.data() + first[at], first[at + 1] - first[at]};
}

Vec3d OccluderDatabase::direction(std::uint32_t index) {
    Vec3d way;
    way[static_cast<int>(index / 2)] = index % 2 ? -1 : 1;
    return way;
}

Status check_occluder_database(const OccluderDatabase& database, std::size_t polygon_count) {
    auto corrupt = [](const std::string& what) {
        return Status(ErrorCode::corrupt, "occluder database: " + what + "; prepare it again");
    };
    constexpr std::uint32_t kMostPerAxis = 1u << 20;
    for (int axis = 0; axis < 3; ++axis) {
        std::uint32_t count = database.count[static_cast<std::size_t>(axis)];
        if (count < 1 || count > kMostPerAxis || !std::isfinite(database.origin[axis]) ||
            !std::isfinite(database.step[axis]) || !(database.step[axis] > 0))
            return corrupt("the grid makes no sense along axis " + std::to_string(axis));
    }
    if (database.first.size() != database.points() * OccluderDatabase::kDirections + 1 || database.first[0] != 0 ||
        database.first.back() != database.polygons.size())
        return corrupt("the lists do not cover the grid");
    for (std::size_t i = 1; i < database.first.size(); ++i)
        if (database.first[i] < database.first[i - 1])
            return corrupt("list " + std::to_string(i - 1) + " ends before it begins");
    for (std::size_t i = 0; i < database.polygons.size(); ++i)
        if (database.polygons[i] >= polygon_count)
            return corrupt("entry " + std::to_string(i) + " names a polygon that does not exist");
    return {};
}

std::vector<std::byte> encode_occluder_database(const OccluderDatabase& database) {
    ByteWriter out;
    for (std::uint32_t count : database.count)
        out.u32(count);
    out.u32(OccluderDatabase::kDirections);
    for (const Vec3d* vector : {&database.origin, &database.step})
        for (int axis = 0; axis < 3; ++axis)
            out.f64((*vector)[axis]);
    for (std::size_t i = 0; i + 1 < database.first.size(); ++i) {
        out.varint(database.first[i + 1] - database.first[i]);
        for (std::uint32_t k = database.first[i]; k < database.first[i + 1]; ++k)
            out.varint(database.polygons[k]);
    }
    return std::move(out.bytes);
}

Result<OccluderDatabase> decode_occluder_database(std::span<const std::byte> bytes, std::size_t polygon_count) {
    auto corrupt = [](const char* what) {
        return Status(ErrorCode::corrupt, std::string("occluder database: ") + what + "; prepare it again");
    };
    constexpr std::size_t kHead = 16 + 48;
    if (bytes.size() < kHead)
        return corrupt("it is too short");
    OccluderDatabase database;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        database.count[axis] = load_u32(bytes, 4 * axis);
        database.origin[int(axis)] = load_f64(bytes, 16 + 8 * axis);
        database.step[int(axis)] = load_f64(bytes, 40 + 8 * axis);
    }
    if (load_u32(bytes, 12) != OccluderDatabase::kDirections)
        return corrupt("it has another number of directions");
    // Each list takes a byte at least: a count that the bytes cannot hold is refused before anything is made.
    std::size_t left = bytes.size() - kHead, lists = OccluderDatabase::kDirections;
    for (std::uint32_t count : database.count) {
        if (count == 0 || lists > left / count)
            return corrupt("it has fewer lists than grid points");
        lists *= count;
    }
    std::size_t at = kHead;
    database.first.assign(1, 0);
    for (std::size_t i = 0; i < lists; ++i) {
        std::uint64_t length = 0, polygon = 0;
        if (!read_varint(bytes, at, length) || length > bytes.size() - at)
            return corrupt("a list ends too early");
        for (std::uint64_t k = 0; k < length; ++k) {
            if (!read_varint(bytes, at, polygon) || polygon >= polygon_count)
                return corrupt("a list names a polygon that does not exist");
            database.polygons.push_back(static_cast<std::uint32_t>(polygon));
        }
        database.first.push_back(static_cast<std::uint32_t>(database.polygons.size()));
    }
    if (at != bytes.size())
        return corrupt("its size is wrong");
    if (Status status = check_occluder_database(database, polygon_count); !status)
        return status;
    return database;
}

} // namespace antumbra
