// A CullScene as chunks of a .pvs file, and back. Byte layout: docs/format.md, section 6. To add a chunk: encode it in
// prepare_chunks(), decode it in CullScene::open().
#include "base/parallel.hpp"
#include "cull/first_hit_sets.hpp"
#include "cull/scene_data.hpp"
#include "cull/set_cells.hpp"

#include <utility>

namespace antumbra {
namespace {

constexpr const char* kOccluders = "OCCL";
constexpr const char* kGroups = "OGRP";
constexpr const char* kTrees = "CTRE";
constexpr const char* kSets = "OSET";
constexpr const char* kMinimumSets = "MOSD";

/// Families of chunk OSET.
enum SetFamily : std::uint32_t {
    kGridFronts = 1, kGridBacks = 2, kGridFirstHits = 3, ///< as they were before cells were a tree; read, not written
    kFronts = 4, ///< best first; read, not written
    kBacks = 5, kFirstHits = 6,
    kFrontChanges = 7, ///< by number, in fewer bytes
};

PvsChunk encode_trees(const CullScene::Data& data) {
    ByteWriter out;
    encode_tree(data.binary, data.order, out);
    encode_tree(data.patches.binary, data.patches.order, out);
    return {kTrees, std::move(out.bytes)};
}

PvsChunk encode_sets(const OccluderSets& fronts, const OccluderSets& backs, const OccluderSets& first_hits) {
    ByteWriter out;
    const std::pair<std::uint32_t, const OccluderSets*> families[] = {{kFrontChanges, &fronts}, {kBacks, &backs}, {kFirstHits, &first_hits}};
    out.u32(static_cast<std::uint32_t>(!fronts.empty()) + !backs.empty() + !first_hits.empty());
    for (auto [kind, sets] : families)
        if (!sets->empty()) {
            out.u32(kind);
            kind == kFrontChanges ? sets->encode_changes(out) : sets->encode(out);
        }
    return {kSets, std::move(out.bytes)};
}

Status corrupt(const char* chunk, const char* what) {
    return {ErrorCode::corrupt,
            std::string("chunk '") + chunk + "': " + what + "; the file is damaged, prepare it again"};
}

#ifndef ANTUMBRA_SHIPPED_METHODS_ONLY
/// Whoever uses a set relies on that: see OccluderSetsOptions.
bool may_be_in_sets(const OccluderPolygon& polygon) { return polygon.count <= OccluderSetsOptions{}.most_corners; }

Status decode_sets(std::span<const std::byte> bytes, CullScene::Data& data) {
    if (bytes.size() < 4)
        return corrupt(kSets, "it is too short");
    std::size_t at = 4;
    for (std::uint32_t family = 0, families = load_u32(bytes, 0); family < families; ++family) {
        if (bytes.size() - at < 4)
            return corrupt(kSets, "it ends too early");
        std::uint32_t kind = load_u32(bytes, at);
        at += 4;
        if (kind < kGridFronts || kind > kFrontChanges)
            return corrupt(kSets, "it has a family of an unknown kind");
        bool first_hits = kind == kFirstHits || kind == kGridFirstHits;
        std::size_t items = first_hits ? data.groups.groups.size() : data.occluders.polygons.size();
        Result<OccluderSets> sets = kind < kFronts          ? OccluderSets::decode_grid(bytes, at, items)
                                    : kind == kFrontChanges ? OccluderSets::decode_changes(bytes, at, items)
                                                            : OccluderSets::decode(bytes, at, items);
        if (!sets)
            return sets.status();
        for (std::uint32_t polygon : sets->members())
            if (!first_hits && !may_be_in_sets(data.occluders.polygons[polygon]))
                return corrupt(kSets, "a set has a polygon of too many corners");
        bool backs = kind == kBacks || kind == kGridBacks;
        (first_hits ? data.first_hit_sets : backs ? data.back_sets : data.front_sets) = std::move(*sets);
    }
    return at == bytes.size() ? Status() : corrupt(kSets, "its size is wrong");
}
#endif

OccluderSets make_sets(const CullScene::Data& data, const SpaceCells& cells, const OccluderSetsOptions& options, const Job& job) {
    if (cells.nodes.empty())
        return {};
    std::vector<std::vector<std::uint32_t>> members(std::size_t(cells.leaves) * OccluderSets::kDirections);
    OccluderSetMaker maker(data.occluders, cells, options);
    std::vector<OccluderSetMaker::Memory> memories(worker_count(job), OccluderSetMaker::Memory(maker));
    parallel_for(cells.leaves, job, [&](std::size_t leaf, unsigned worker) {
        maker.make(static_cast<std::uint32_t>(leaf), memories[worker],
                   std::span(members).subspan(leaf * OccluderSets::kDirections, OccluderSets::kDirections));
    });
    return OccluderSets::of_members(cells, members);
}

Status decode_trees(std::span<const std::byte> bytes, CullScene::Data& data) {
    std::size_t at = 0;
    Result<std::vector<BinaryNode>> binary = decode_tree(bytes, at, data.bounds, data.order);
    if (!binary)
        return binary.status();
    data.binary = std::move(*binary);
    data.patches = lay_out_patches(data);
    binary = decode_tree(bytes, at, items_of(data), data.patches.order);
    if (!binary)
        return binary.status();
    data.patches.binary = std::move(*binary);
    return at == bytes.size() ? Status() : corrupt(kTrees, "its size is wrong");
}

} // namespace

Result<std::vector<PvsChunk>> prepare_chunks(const CullScene& scene, const PrepareOptions& options,
                                             const Job& job) {
    const CullScene::Data& data = scene.data();
    Result<std::vector<std::byte>> occluders = encode_occluders(data.occluders);
    if (!occluders)
        return occluders.status();
    std::vector<PvsChunk> chunks;
    chunks.push_back({kOccluders, std::move(*occluders)});
    chunks.push_back({kGroups, encode_groups(data.groups)});
    chunks.push_back(encode_trees(data));
    if (!data.tree_box.empty() && options.per_set > 0) {
        SetCells cells = choose_set_cells(data, options.pvs, options.leaves);
        OccluderSetsOptions sets;
        sets.per_set = options.per_set;
        sets.is_seen = cells.is_seen;
        sets.order = OccluderSetsOptions::Order::by_number;
        OccluderSets fronts = make_sets(data, cells.cells, sets, job);
        sets.order = OccluderSetsOptions::Order::best_first;
        sets.shown = OccluderSetsOptions::Shown::backs; // what turns its front to the viewer turns its back to the object
        // What hides an object from a viewer elsewhere need not be seen from where the object is.
        sets.is_seen = nullptr;
        OccluderSets backs = make_sets(data, cells_of_objects(data, options.detail_leaves), sets, job);
        if (options.first_hit_leaves != options.leaves)
            cells = choose_set_cells(data, options.pvs, options.first_hit_leaves);
        chunks.push_back(encode_sets(
            fronts, backs, find_first_hit_sets(data, cells.cells, options.per_set, cells.is_seen, job)));
        if (job.cancelled())
            return Status(ErrorCode::cancelled, "stopped while looking for occluder sets");
    }
    return chunks;
}

PvsChunk occluder_database_chunk(const OccluderDatabase& database) {
    return {kMinimumSets, encode_occluder_database(database)};
}

Result<CullScene> CullScene::open(const Pvs& pvs) {
    std::vector<Box3f> bounds;
    std::vector<std::uint32_t> flags, triangles;
    for (std::uint32_t o = 0; o < pvs.object_count(); ++o) {
        PvsObject object = pvs.object(o);
        bounds.push_back(object.bounds);
        flags.push_back(object.flags);
        triangles.push_back(object.triangle_count);
    }
    CullSceneInput input;
    input.bounds = bounds;
    input.flags = flags;
    input.triangles = triangles;
    input.origin = pvs.origin();
    auto data = std::make_shared<Data>();
    take_objects(input, *data);
    if (pvs.has_chunk(kOccluders)) {
        Result<OccluderSet> occluders = decode_occluders(pvs.chunk(kOccluders));
        if (!occluders)
            return occluders.status();
        data->occluders = std::move(*occluders);
    }
    if (pvs.has_chunk(kTrees)) {
        if (Status status = decode_trees(pvs.chunk(kTrees), *data); !status)
            return status;
    } else {
        build_trees(*data);
    }
    if (pvs.has_chunk(kGroups)) {
        Result<ConvexGroups> groups = decode_groups(pvs.chunk(kGroups), data->occluders);
        if (!groups)
            return groups.status();
        data->groups = std::move(*groups);
    } else {
        data->groups = find_convex_groups(data->occluders, kMostGroups);
    }
#ifndef ANTUMBRA_SHIPPED_METHODS_ONLY // nobody asks them there
    if (pvs.has_chunk(kSets))
        if (Status status = decode_sets(pvs.chunk(kSets), *data); !status)
            return status;
    if (pvs.has_chunk(kMinimumSets)) {
        Result<OccluderDatabase> database =
            decode_occluder_database(pvs.chunk(kMinimumSets), data->occluders.polygons.size());
        if (!database)
            return database.status();
        data->minimum_sets = std::move(*database);
    }
#endif
    finish(*data);
    CullScene scene;
    scene.data_ = std::move(data);
    return scene;
}

} // namespace antumbra
