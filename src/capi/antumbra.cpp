// The only C++ that knows the C header: checks arguments, copies, and passes on.
#include "capi/shared.hpp"

#define STRING(x) #x
#define VERSION_TEXT(major, minor, patch) STRING(major) "." STRING(minor) "." STRING(patch)

struct ant_cursor {
    const antumbra::Pvs* pvs;
    antumbra::PvsCursor cursor;
    antumbra::capi::Told told;
};

namespace {

using antumbra::ErrorCode;
using antumbra::Result;
using antumbra::Status;
using antumbra::Vec3d;
using namespace antumbra::capi;

static_assert(ANT_USAGE == int(ErrorCode::usage) && ANT_IO == int(ErrorCode::io));
static_assert(ANT_CORRUPT == int(ErrorCode::corrupt) && ANT_UNSUPPORTED == int(ErrorCode::unsupported));
static_assert(ANT_LIMIT == int(ErrorCode::limit) && ANT_MISMATCH == int(ErrorCode::mismatch));
static_assert(ANT_CANCELLED == int(ErrorCode::cancelled) && ANT_INTERNAL == int(ErrorCode::internal));
static_assert(ANT_EXACT == int(antumbra::Guarantee::exact));
static_assert(ANT_CONSERVATIVE == int(antumbra::Guarantee::conservative));
static_assert(ANT_AGGRESSIVE == int(antumbra::Guarantee::aggressive));
static_assert(ANT_APPROXIMATE == int(antumbra::Guarantee::approximate));

bool has_answer(const ant_cursor* cursor) { return cursor && cursor->cursor.cell != -2; }

} // namespace

extern "C" {

const char* ant_version_text(void) { return VERSION_TEXT(ANT_VERSION_MAJOR, ANT_VERSION_MINOR, ANT_VERSION_PATCH); }

uint32_t ant_version_format(void) { return antumbra::kPvsFormatVersion; }

const char* ant_status_name(ant_status status) {
    static const char* const names[] = {"ok",          "usage", "io",       "corrupt",   "unsupported",
                                        "limit",       "mismatch", "cancelled", "internal"};
    auto index = static_cast<std::size_t>(status);
    return index < std::size(names) ? names[index] : "unknown";
}

const char* ant_guarantee_name(ant_guarantee guarantee) {
    return antumbra::to_string(static_cast<antumbra::Guarantee>(guarantee));
}

ant_status ant_pvs_open_memory(const void* bytes, size_t size, ant_pvs** pvs, char* error, size_t error_size) {
    if (pvs)
        *pvs = nullptr;
    if (!pvs || (!bytes && size > 0))
        return answer({ErrorCode::usage, "ant_pvs_open_memory: a needed pointer is NULL"}, error, error_size);
    Result<antumbra::Pvs> opened = antumbra::Pvs::open({static_cast<const std::byte*>(bytes), size});
    if (!opened)
        return answer(opened.status(), error, error_size);
    *pvs = new ant_pvs(std::move(*opened));
    return answer({}, error, error_size);
}

ant_status ant_pvs_open_file(const char* path, ant_pvs** pvs, char* error, size_t error_size) {
    if (pvs)
        *pvs = nullptr;
    if (!pvs || !path)
        return answer({ErrorCode::usage, "ant_pvs_open_file: a needed pointer is NULL"}, error, error_size);
#ifdef ANTUMBRA_NO_FILES
    return answer({ErrorCode::unsupported, "ant_pvs_open_file: this build has no file system; read the bytes and "
                                           "call ant_pvs_open_memory"}, error, error_size);
#else
    Result<antumbra::MappedFile> file = antumbra::MappedFile::open(path);
    if (!file)
        return answer(file.status(), error, error_size);
    Result<antumbra::Pvs> opened = antumbra::Pvs::open(file->bytes());
    if (!opened)
        return answer(opened.status().in(path), error, error_size);
    *pvs = new ant_pvs(std::move(*opened));
    (*pvs)->file = std::move(*file);
    return answer({}, error, error_size);
#endif
}

void ant_pvs_close(ant_pvs* pvs) { delete pvs; }

ant_status ant_pvs_describe(const ant_pvs* pvs, ant_pvs_info* info) {
    // The first struct ever published had the fields up to tree_nodes.
    if (!pvs || !info || info->struct_size < sizeof(ant_pvs_info))
        return ANT_USAGE;
    const antumbra::Pvs& source = pvs->pvs;
    info->guarantee = static_cast<ant_guarantee>(source.guarantee());
    info->object_count = source.object_count();
    info->cell_count = source.grid().cells();
    std::copy(source.grid().count.begin(), source.grid().count.end(), info->grid_count);
    info->sides = source.sides();
    copy(source.grid().bounds.min, info->grid_min);
    copy(source.grid().bounds.max, info->grid_max);
    copy(source.origin(), info->origin);
    std::copy(source.scene_fingerprint().begin(), source.scene_fingerprint().end(), info->scene_fingerprint);
    info->structure_fingerprint = source.structure_fingerprint();
    info->file_bytes = source.file_bytes();
    info->visibility_bytes = source.visibility_bytes();
    info->volume_count = source.volumes().cells();
    info->tree_nodes = source.tree().nodes.size();
    return ANT_OK;
}

ant_status ant_pvs_read_text(const ant_pvs* pvs, ant_text which, char* buffer, size_t capacity, size_t* length) {
    if (!pvs || !length)
        return ANT_USAGE;
    switch (which) {
    case ANT_TEXT_METHOD:
        return read_text(pvs->pvs.method(), buffer, capacity, length);
    case ANT_TEXT_TOOL_VERSION:
        return read_text(pvs->pvs.tool_version(), buffer, capacity, length);
    case ANT_TEXT_OPTIONS:
        return read_text(pvs->pvs.options_json(), buffer, capacity, length);
    }
    return ANT_USAGE;
}

ant_status ant_object_describe(const ant_pvs* pvs, uint32_t object, ant_object* description) {
    if (!pvs || !description || object >= pvs->pvs.object_count())
        return ANT_USAGE;
    antumbra::PvsObject source = pvs->pvs.object(object);
    antumbra::Box3d bounds = pvs->pvs.object_bounds(object);
    *description = {source.node, source.primitive, source.instance, source.flags, source.triangle_count, {}, {}};
    copy(bounds.min, description->bounds_min);
    copy(bounds.max, description->bounds_max);
    return ANT_OK;
}

ant_status ant_object_read_name(const ant_pvs* pvs, uint32_t object, char* buffer, size_t capacity, size_t* length) {
    if (!pvs || !length || object >= pvs->pvs.object_count())
        return ANT_USAGE;
    return read_text(pvs->pvs.object_name(object), buffer, capacity, length);
}

ant_status ant_pvs_count_clusters(const ant_pvs* pvs, uint32_t* count) {
    if (!pvs || !count)
        return ANT_USAGE;
    *count = pvs->pvs.cluster_count();
    return ANT_OK;
}

#ifndef ANTUMBRA_WITHOUT_CLUSTERS
ant_status ant_object_read_clusters(const ant_pvs* pvs, uint32_t object, uint32_t* clusters, size_t capacity, size_t* count) {
    if (!pvs || !count || object >= pvs->pvs.object_count() || pvs->pvs.cluster_count() == 0)
        return ANT_USAGE;
    // A damaged file may claim any number of triangles: what the caller has room for bounds the memory.
    constexpr std::size_t kBehind = std::size_t(1) << 24; // that close cracks, behind those of the file
    std::size_t most = clusters ? std::min<std::size_t>(capacity, 0xFFFFFFFFu - kBehind) + kBehind : 0;
    antumbra::PvsTriangles triangles = pvs->pvs.triangles_of(object, std::uint32_t(most));
    ant_status status = check_buffer(clusters, capacity, triangles.in_file);
    if (status == ANT_USAGE)
        return status;
    *count = triangles.in_file;
    if (status != ANT_OK || !clusters)
        return status;
    if (triangles.cluster.size() < triangles.in_file)
        return ANT_LIMIT;
    std::copy_n(triangles.cluster.begin(), triangles.in_file, clusters);
    return ANT_OK;
}
#endif

ant_status ant_cell_describe(const ant_pvs* pvs, uint64_t cell, ant_cell* description) {
    if (!pvs || !description)
        return ANT_USAGE;
    const antumbra::ViewTree& tree = pvs->pvs.tree();
    bool is_leaf = cell < tree.nodes.size() && tree.nodes[std::size_t(cell)].axis == antumbra::ViewNode::kLeaf;
    if (!is_leaf && cell >= pvs->pvs.grid().cells())
        return ANT_USAGE;
    std::uint32_t row = is_leaf ? tree.nodes[std::size_t(cell)].link : pvs->pvs.cell_row(cell);
    antumbra::Box3d box =
        is_leaf ? tree.spatial_box(tree.region(static_cast<std::uint32_t>(cell))) : pvs->pvs.grid().cell(cell);
    description->kind = row == antumbra::kCellNotBaked ? ANT_CELL_NOT_BAKED
                        : row == antumbra::kCellSolid  ? ANT_CELL_SOLID
                                                       : ANT_CELL_BAKED;
    copy(box.min, description->min);
    copy(box.max, description->max);
    return ANT_OK;
}

ant_status ant_cell_find(const ant_pvs* pvs, const double point[3], int64_t* cell) {
    if (!pvs || !point || !cell)
        return ANT_USAGE;
    const antumbra::ViewTree& tree = pvs->pvs.tree();
    *cell = tree.nodes.empty() ? pvs->pvs.grid().find(vector(point)) : tree.find_leaf(vector(point));
    return ANT_OK;
}

ant_status ant_cursor_create(const ant_pvs* pvs, ant_cursor** cursor) {
    if (cursor)
        *cursor = nullptr;
    if (!pvs || !cursor)
        return ANT_USAGE;
    *cursor = new ant_cursor{&pvs->pvs, {}, {}};
    return ANT_OK;
}

void ant_cursor_destroy(ant_cursor* cursor) { delete cursor; }

ant_status ant_cursor_query(ant_cursor* cursor, const double eye[3], int* changed) {
    if (!cursor || !eye)
        return ANT_USAGE;
    bool differs = cursor->pvs->query(vector(eye), cursor->cursor);
    if (changed)
        *changed = differs ? 1 : 0;
    return ANT_OK;
}

ant_status ant_cursor_query_range(ant_cursor* cursor, const double eye_min[3], const double eye_max[3],
                                  const double direction[3], const double up[3], double tan_half_fov_y, double aspect,
                                  int* changed) {
    if (!cursor || !eye_min || !eye_max)
        return ANT_USAGE;
    antumbra::Box3d eyes{vector(eye_min), vector(eye_max)};
    antumbra::ViewRange range{eyes, true, {}};
    if (direction)
        range = antumbra::camera_range(eyes, vector(direction), up ? vector(up) : Vec3d{0, 1, 0}, tan_half_fov_y, aspect);
    bool differs = cursor->pvs->query_range(range, cursor->cursor);
    if (changed)
        *changed = differs ? 1 : 0;
    return ANT_OK;
}

ant_status ant_cursor_sees_box(const ant_cursor* cursor, const double box_min[3], const double box_max[3],
                               int* visible) {
    if (!has_answer(cursor) || !box_min || !box_max || !visible)
        return ANT_USAGE;
    *visible = cursor->pvs->is_box_visible({vector(box_min), vector(box_max)}, cursor->cursor) ? 1 : 0;
    return ANT_OK;
}

ant_status ant_cursor_sees_cluster(const ant_cursor* cursor, uint32_t cluster, int* visible) {
    if (!has_answer(cursor) || !visible || cluster >= cursor->pvs->cluster_count())
        return ANT_USAGE;
    *visible = cursor->pvs->is_cluster_visible(cluster, cursor->cursor) ? 1 : 0;
    return ANT_OK;
}

ant_status ant_cursor_read_cluster_bits(const ant_cursor* cursor, uint8_t* bytes, size_t capacity, size_t* count) {
    if (!has_answer(cursor) || !count)
        return ANT_USAGE;
    std::uint32_t clusters = cursor->pvs->cluster_count();
    std::size_t needed = (std::size_t(clusters) + 7) / 8;
    ant_status status = check_buffer(bytes, capacity, needed);
    if (status == ANT_USAGE)
        return status;
    *count = needed;
    if (status != ANT_OK || !bytes)
        return status;
    std::fill_n(bytes, needed, std::uint8_t(0));
    for (std::uint32_t c = 0; c < clusters; ++c)
        bytes[c / 8] |= static_cast<std::uint8_t>(cursor->pvs->is_cluster_visible(c, cursor->cursor) << c % 8);
    return ANT_OK;
}

ant_status ant_cursor_describe(const ant_cursor* cursor, ant_answer* answer) {
    if (!has_answer(cursor) || !answer)
        return ANT_USAGE;
    const antumbra::PvsCursor& source = cursor->cursor;
    answer->cell = source.cell;
    auto guarantee = static_cast<ant_guarantee>(cursor->pvs->guarantee());
    // A union over several cells, or bounds in place of geometry, lists too much: what was exact is conservative then,
    // and what missed something is approximate. All objects at once is always conservative.
    bool may_miss = guarantee == ANT_AGGRESSIVE || guarantee == ANT_APPROXIMATE;
    if (source.everything)
        guarantee = ANT_CONSERVATIVE;
    else if (source.cell == -3)
        guarantee = may_miss ? ANT_APPROXIMATE : ANT_CONSERVATIVE;
    answer->guarantee = guarantee;
    answer->everything = source.everything ? 1 : 0;
    answer->visible_count = source.visible_count;
    return ANT_OK;
}

ant_status ant_cursor_read_ids(const ant_cursor* cursor, uint32_t* ids, size_t capacity, size_t* count) {
    if (!has_answer(cursor) || !count)
        return ANT_USAGE;
    return read_ids(cursor->cursor.visible, cursor->cursor.visible_count, ids, capacity, count);
}

ant_status ant_cursor_read_bits(const ant_cursor* cursor, uint8_t* bytes, size_t capacity, size_t* count) {
    if (!has_answer(cursor) || !count)
        return ANT_USAGE;
    return read_bits(cursor->cursor.visible, cursor->pvs->object_count(), bytes, capacity, count);
}

ant_status ant_cursor_sees(const ant_cursor* cursor, uint32_t object, int* visible) {
    if (!has_answer(cursor) || !visible || object >= cursor->pvs->object_count())
        return ANT_USAGE;
    *visible = static_cast<int>(cursor->cursor.visible[object / 64] >> (object % 64) & 1);
    return ANT_OK;
}

ant_status ant_cursor_read_changes(ant_cursor* cursor, uint32_t* shown, size_t shown_capacity, size_t* shown_count,
                                   uint32_t* hidden, size_t hidden_capacity, size_t* hidden_count) {
    if (!has_answer(cursor))
        return ANT_USAGE;
    return cursor->told.read(cursor->cursor.visible, cursor->pvs->object_count(), shown, shown_capacity, shown_count,
                             hidden, hidden_capacity, hidden_count);
}

} // extern "C"
