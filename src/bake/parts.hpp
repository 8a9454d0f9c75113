// Parts of a sharded bake: which units belong to one, and what its file says about it.
#pragma once

#include <antumbra/bake.hpp>

#include <nlohmann/json.hpp>

namespace antumbra {

/// Leaves the units of one shard, in their order.
inline void keep_shard(std::vector<std::uint64_t>& units, const Shard& shard) {
    std::size_t kept = 0;
    for (std::size_t unit = shard.index; unit < units.size(); unit += shard.count)
        units[kept++] = units[unit];
    units.resize(kept);
}

/// A hash of all units of a bake, before keep_shard(): parts of one bake agree on it.
inline std::uint64_t plan_of(std::span<const std::uint64_t> units) {
    std::uint64_t hash = 0xcbf29ce484222325u; // FNV-1a over words
    for (std::uint64_t unit : units)
        hash = (hash ^ unit) * 0x100000001b3u;
    return hash;
}

/// What PvsData::options_json says. `options` are equal in all parts of a bake; the numbers in `counts`, and in objects
/// within, add up; those called most_.. are greatest values.
struct PartDescription {
    Shard shard;
    std::uint64_t plan = 0; ///< plan_of() the units of all shards
    nlohmann::ordered_json options, counts;
};

/// Of a whole bake (one shard): the options and the counts in one object. Of a part: {"shard": {"index", "count", "plan"},
/// "options", "counts"}.
std::string describe_part(const PartDescription& part);

} // namespace antumbra
