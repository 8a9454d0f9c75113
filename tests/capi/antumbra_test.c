/* The C interface as a C99 program meets it. Each check function returns 0, or the line that failed. */
#include <antumbra/antumbra.h>

#include <string.h>

#define CHECK(condition)                                                                                              \
    do {                                                                                                              \
        if (!(condition))                                                                                             \
            return __LINE__;                                                                                          \
    } while (0)

/* The file that capi_test.cpp makes: two cells along x in [0,2]x[0,1]x[0,1], a third that is not baked; three objects;
 * the first cell sees object 0, the second objects 0 and 2; object 2 is the "door". */

int check_versions(void) {
    CHECK(strcmp(ant_version_text(), "0.1.0") == 0);
    CHECK(ant_version_format() >> 16 == 1);
    CHECK(strcmp(ant_status_name(ANT_CORRUPT), "corrupt") == 0);
    CHECK(strcmp(ant_status_name((ant_status)99), "unknown") == 0);
    CHECK(strcmp(ant_guarantee_name(ANT_EXACT), "exact") == 0);
    CHECK(strcmp(ant_guarantee_name((ant_guarantee)0), "unknown") == 0);
    return 0;
}

int check_description(const ant_pvs* pvs) {
    ant_pvs_info info;
    info.struct_size = sizeof info;
    CHECK(ant_pvs_describe(pvs, &info) == ANT_OK);
    CHECK(info.guarantee == ANT_EXACT);
    CHECK(info.object_count == 3);
    CHECK(info.cell_count == 3 && info.grid_count[0] == 3 && info.grid_count[1] == 1 && info.grid_count[2] == 1);
    CHECK(info.sides == 1);
    CHECK(info.grid_min[0] == 0 && info.grid_max[0] == 3 && info.grid_max[2] == 1);
    CHECK(info.origin[0] == 10 && info.origin[1] == 0);
    CHECK(info.scene_fingerprint[0] == 0xAB && info.scene_fingerprint[15] == 0xCD);
    CHECK(info.structure_fingerprint == 0x0123456789ABCDEFu);
    CHECK(info.file_bytes > info.visibility_bytes && info.visibility_bytes > 0);
    info.struct_size = 8;
    CHECK(ant_pvs_describe(pvs, &info) == ANT_USAGE);
    return 0;
}

int check_texts(const ant_pvs* pvs) {
    char buffer[16];
    size_t length = 99;
    CHECK(ant_pvs_read_text(pvs, ANT_TEXT_METHOD, NULL, 0, &length) == ANT_OK && length == 5);
    CHECK(ant_pvs_read_text(pvs, ANT_TEXT_METHOD, buffer, sizeof buffer, &length) == ANT_OK);
    CHECK(strcmp(buffer, "exact") == 0);
    CHECK(ant_pvs_read_text(pvs, ANT_TEXT_METHOD, buffer, 6, &length) == ANT_OK);
    memset(buffer, 'x', sizeof buffer);
    CHECK(ant_pvs_read_text(pvs, ANT_TEXT_METHOD, buffer, 5, &length) == ANT_LIMIT && length == 5);
    CHECK(buffer[0] == 'x');
    CHECK(ant_pvs_read_text(pvs, ANT_TEXT_TOOL_VERSION, buffer, sizeof buffer, &length) == ANT_OK);
    CHECK(strcmp(buffer, "0.1") == 0);
    CHECK(ant_pvs_read_text(pvs, ANT_TEXT_OPTIONS, buffer, sizeof buffer, &length) == ANT_OK);
    CHECK(strcmp(buffer, "{}") == 0);
    CHECK(ant_object_read_name(pvs, 2, buffer, sizeof buffer, &length) == ANT_OK);
    CHECK(length == 4 && strcmp(buffer, "door") == 0);
    CHECK(ant_object_read_name(pvs, 0, buffer, 1, &length) == ANT_OK && length == 0 && buffer[0] == 0);
    return 0;
}

int check_objects_and_cells(const ant_pvs* pvs) {
    ant_object object;
    ant_cell cell;
    int64_t index;
    const double point[3] = {1.5, 0.5, 0.5}, outside[3] = {-1, 0, 0};
    CHECK(ant_object_describe(pvs, 2, &object) == ANT_OK);
    CHECK(object.node == 7 && object.primitive == 1 && object.instance == -1);
    CHECK(object.flags == ANT_OBJECT_OCCLUDES && object.triangle_count == 12);
    CHECK(object.bounds_min[0] == 11 && object.bounds_max[0] == 12 && object.bounds_max[1] == 1);
    CHECK(ant_cell_describe(pvs, 1, &cell) == ANT_OK);
    CHECK(cell.kind == ANT_CELL_BAKED && cell.min[0] == 1 && cell.max[0] == 2 && cell.max[1] == 1);
    CHECK(ant_cell_describe(pvs, 2, &cell) == ANT_OK && cell.kind == ANT_CELL_NOT_BAKED);
    CHECK(ant_cell_find(pvs, point, &index) == ANT_OK && index == 1);
    CHECK(ant_cell_find(pvs, outside, &index) == ANT_OK && index == -1);
    return 0;
}

int check_queries(const ant_pvs* pvs) {
    ant_cursor* cursor;
    ant_answer answer;
    uint32_t ids[3] = {9, 9, 9};
    uint8_t bits[1];
    size_t count;
    int changed = 7, visible;
    const double first[3] = {0.5, 0.5, 0.5}, second[3] = {1.5, 0.5, 0.5}, unbaked[3] = {2.5, 0.5, 0.5};
    CHECK(ant_cursor_create(pvs, &cursor) == ANT_OK && cursor);
    CHECK(ant_cursor_describe(cursor, &answer) == ANT_USAGE); /* nothing asked yet */
    CHECK(ant_cursor_read_ids(cursor, NULL, 0, &count) == ANT_USAGE);
    CHECK(ant_cursor_query(cursor, first, &changed) == ANT_OK && changed == 1);
    CHECK(ant_cursor_query(cursor, first, &changed) == ANT_OK && changed == 0);
    CHECK(ant_cursor_query(cursor, second, NULL) == ANT_OK);
    CHECK(ant_cursor_describe(cursor, &answer) == ANT_OK);
    CHECK(answer.cell == 1 && answer.guarantee == ANT_EXACT && !answer.everything && answer.visible_count == 2);
    CHECK(ant_cursor_read_ids(cursor, NULL, 0, &count) == ANT_OK && count == 2);
    CHECK(ant_cursor_read_ids(cursor, ids, 1, &count) == ANT_LIMIT && count == 2 && ids[0] == 9);
    CHECK(ant_cursor_read_ids(cursor, ids, 3, &count) == ANT_OK && ids[0] == 0 && ids[1] == 2 && ids[2] == 9);
    CHECK(ant_cursor_read_bits(cursor, NULL, 0, &count) == ANT_OK && count == 1);
    CHECK(ant_cursor_read_bits(cursor, bits, 0, &count) == ANT_LIMIT);
    CHECK(ant_cursor_read_bits(cursor, bits, 1, &count) == ANT_OK && bits[0] == 5);
    CHECK(ant_cursor_sees(cursor, 1, &visible) == ANT_OK && visible == 0);
    CHECK(ant_cursor_sees(cursor, 2, &visible) == ANT_OK && visible == 1);
    CHECK(ant_cursor_query(cursor, unbaked, &changed) == ANT_OK && changed == 1);
    CHECK(ant_cursor_describe(cursor, &answer) == ANT_OK);
    CHECK(answer.cell == 2 && answer.everything && answer.visible_count == 3 && answer.guarantee == ANT_CONSERVATIVE);
    ant_cursor_destroy(cursor);
    return 0;
}

/* Objects 0 and 1 are at the origin of the file, (10,0,0), without extent; the door is the box (11,0,0)..(12,1,1). Two
 * volumes: [0,1.5] and [1.5,3] along x; the first cell sees the first, the second cell the second. */
int check_ranges(const ant_pvs* pvs) {
    ant_cursor* cursor;
    ant_answer answer;
    ant_pvs_info info;
    uint32_t ids[3];
    size_t count;
    int changed, visible;
    const double low[3] = {0.5, 0.5, 0.5}, high[3] = {1.5, 0.5, 0.5}, second[3] = {1.25, 0.5, 0.5};
    const double to_door[3] = {1, 0, 0}, away[3] = {-1, 0, 0}, up[3] = {0, 0, 1};
    const double left_min[3] = {0.1, 0.1, 0.1}, left_max[3] = {0.2, 0.2, 0.2}, far_max[3] = {9, 9, 9};
    info.struct_size = sizeof info;
    CHECK(ant_pvs_describe(pvs, &info) == ANT_OK && info.volume_count == 2 && info.tree_nodes == 0);
    CHECK(ant_cursor_create(pvs, &cursor) == ANT_OK);
    CHECK(ant_cursor_sees_box(cursor, left_min, left_max, &visible) == ANT_USAGE); /* nothing asked yet */
    CHECK(ant_cursor_query_range(cursor, low, high, NULL, NULL, 0, 0, &changed) == ANT_OK && changed == 1);
    CHECK(ant_cursor_describe(cursor, &answer) == ANT_OK && answer.cell == -3 && answer.visible_count == 2);
    CHECK(answer.guarantee == ANT_CONSERVATIVE && !answer.everything);
    CHECK(ant_cursor_sees_box(cursor, left_min, left_max, &visible) == ANT_OK && visible == 1);
    CHECK(ant_cursor_query(cursor, second, NULL) == ANT_OK);
    CHECK(ant_cursor_sees_box(cursor, left_min, left_max, &visible) == ANT_OK && visible == 0);
    CHECK(ant_cursor_sees_box(cursor, left_min, far_max, &visible) == ANT_OK && visible == 1);
    CHECK(ant_cursor_query_range(cursor, second, second, to_door, up, 0.1, 1, NULL) == ANT_OK);
    CHECK(ant_cursor_read_ids(cursor, ids, 3, &count) == ANT_OK && count == 2 && ids[0] == 0 && ids[1] == 2);
    CHECK(ant_cursor_query_range(cursor, second, second, away, NULL, 0.1, 1, &changed) == ANT_OK && changed == 1);
    CHECK(ant_cursor_read_ids(cursor, ids, 3, &count) == ANT_OK && count == 0);
    CHECK(ant_cursor_query_range(NULL, low, high, NULL, NULL, 0, 0, NULL) == ANT_USAGE);
    CHECK(ant_cursor_query_range(cursor, NULL, high, NULL, NULL, 0, 0, NULL) == ANT_USAGE);
    CHECK(ant_cursor_query_range(cursor, low, NULL, NULL, NULL, 0, 0, NULL) == ANT_USAGE);
    CHECK(ant_cursor_sees_box(NULL, low, high, &visible) == ANT_USAGE);
    CHECK(ant_cursor_sees_box(cursor, NULL, high, &visible) == ANT_USAGE);
    CHECK(ant_cursor_sees_box(cursor, low, NULL, &visible) == ANT_USAGE);
    CHECK(ant_cursor_sees_box(cursor, low, high, NULL) == ANT_USAGE);
    ant_cursor_destroy(cursor);
    return 0;
}

/* Every pointer NULL in turn, every index out of range: ANT_USAGE, never a crash. */
int check_misuse(const ant_pvs* pvs) {
    ant_pvs* other = (ant_pvs*)1;
    ant_cursor* cursor = (ant_cursor*)1;
    ant_object object;
    ant_cell cell;
    ant_pvs_info info;
    const double eye[3] = {0, 0, 0};
    char error[64];
    size_t length;
    int64_t index;
    int flag;
    info.struct_size = sizeof info;
    CHECK(ant_pvs_open_memory(NULL, 5, &other, error, sizeof error) == ANT_USAGE && other == NULL && error[0] != 0);
    CHECK(ant_pvs_open_memory("x", 1, NULL, NULL, 0) == ANT_USAGE);
    CHECK(ant_pvs_open_memory(NULL, 0, &other, NULL, 0) == ANT_CORRUPT); /* a file without bytes */
    CHECK(ant_pvs_open_memory("x", 1, &other, error, 0) == ANT_CORRUPT);
    CHECK(ant_pvs_open_memory("x", 1, &other, error, 1) == ANT_CORRUPT && error[0] == 0);
    CHECK(ant_pvs_open_memory("x", 1, &other, error, 7) == ANT_CORRUPT && strlen(error) == 6);
    CHECK(ant_pvs_open_file(NULL, &other, error, sizeof error) == ANT_USAGE);
    CHECK(ant_pvs_open_file("x", NULL, error, sizeof error) == ANT_USAGE);
    CHECK(ant_pvs_open_file("/no/such/file.pvs", &other, error, sizeof error) == ANT_IO);
    CHECK(strstr(error, "/no/such/file.pvs") != NULL);
    CHECK(ant_pvs_describe(NULL, &info) == ANT_USAGE && ant_pvs_describe(pvs, NULL) == ANT_USAGE);
    CHECK(ant_pvs_read_text(NULL, ANT_TEXT_METHOD, NULL, 0, &length) == ANT_USAGE);
    CHECK(ant_pvs_read_text(pvs, ANT_TEXT_METHOD, NULL, 0, NULL) == ANT_USAGE);
    CHECK(ant_pvs_read_text(pvs, ANT_TEXT_METHOD, NULL, 5, &length) == ANT_USAGE);
    CHECK(ant_pvs_read_text(pvs, (ant_text)9, NULL, 0, &length) == ANT_USAGE);
    CHECK(ant_object_describe(NULL, 0, &object) == ANT_USAGE && ant_object_describe(pvs, 0, NULL) == ANT_USAGE);
    CHECK(ant_object_describe(pvs, 3, &object) == ANT_USAGE);
    CHECK(ant_object_read_name(NULL, 0, NULL, 0, &length) == ANT_USAGE);
    CHECK(ant_object_read_name(pvs, 3, NULL, 0, &length) == ANT_USAGE);
    CHECK(ant_object_read_name(pvs, 0, NULL, 0, NULL) == ANT_USAGE);
    CHECK(ant_cell_describe(NULL, 0, &cell) == ANT_USAGE && ant_cell_describe(pvs, 0, NULL) == ANT_USAGE);
    CHECK(ant_cell_describe(pvs, 3, &cell) == ANT_USAGE);
    CHECK(ant_cell_find(NULL, eye, &index) == ANT_USAGE && ant_cell_find(pvs, NULL, &index) == ANT_USAGE);
    CHECK(ant_cell_find(pvs, eye, NULL) == ANT_USAGE);
    CHECK(ant_cursor_create(NULL, &cursor) == ANT_USAGE && cursor == NULL);
    CHECK(ant_cursor_create(pvs, NULL) == ANT_USAGE);
    CHECK(ant_cursor_query(NULL, eye, &flag) == ANT_USAGE);
    CHECK(ant_cursor_create(pvs, &cursor) == ANT_OK);
    CHECK(ant_cursor_query(cursor, NULL, &flag) == ANT_USAGE);
    CHECK(ant_cursor_query(cursor, eye, NULL) == ANT_OK);
    CHECK(ant_cursor_describe(NULL, NULL) == ANT_USAGE && ant_cursor_describe(cursor, NULL) == ANT_USAGE);
    CHECK(ant_cursor_read_ids(NULL, NULL, 0, &length) == ANT_USAGE);
    CHECK(ant_cursor_read_ids(cursor, NULL, 0, NULL) == ANT_USAGE);
    CHECK(ant_cursor_read_ids(cursor, NULL, 4, &length) == ANT_USAGE);
    CHECK(ant_cursor_read_bits(NULL, NULL, 0, &length) == ANT_USAGE);
    CHECK(ant_cursor_read_bits(cursor, NULL, 0, NULL) == ANT_USAGE);
    CHECK(ant_cursor_sees(NULL, 0, &flag) == ANT_USAGE && ant_cursor_sees(cursor, 0, NULL) == ANT_USAGE);
    CHECK(ant_cursor_sees(cursor, 3, &flag) == ANT_USAGE);
    ant_cursor_destroy(cursor);
    ant_cursor_destroy(NULL);
    ant_pvs_close(NULL);
    return 0;
}

int check_no_clusters(const ant_pvs* pvs) {
    uint32_t count = 9;
    size_t triangles = 9;
    CHECK(ant_pvs_count_clusters(pvs, &count) == ANT_OK && count == 0);
    CHECK(ant_pvs_count_clusters(NULL, &count) == ANT_USAGE);
    CHECK(ant_object_read_clusters(pvs, 0, NULL, 0, &triangles) == ANT_USAGE && triangles == 9);
    return 0;
}

int check_clusters(const ant_pvs* pvs) {
    const double eye[3] = {0.5, 0.5, 0.5}, inside[3] = {3, 0.5, 0.5};
    uint32_t count = 0, clusters[5];
    uint8_t bits = 99;
    size_t triangles = 0;
    int visible = 9;
    ant_cursor* cursor;
    CHECK(ant_pvs_count_clusters(pvs, &count) == ANT_OK && count == 3);
    CHECK(ant_object_read_clusters(pvs, 0, NULL, 0, &triangles) == ANT_OK && triangles == 5);
    CHECK(ant_object_read_clusters(pvs, 0, clusters, 4, &triangles) == ANT_LIMIT && triangles == 5);
    CHECK(ant_object_read_clusters(pvs, 0, clusters, 5, &triangles) == ANT_OK);
    CHECK(clusters[0] == 1 && clusters[1] == 0 && clusters[2] == ANT_NO_CLUSTER && clusters[3] == 1 && clusters[4] == 0);
    CHECK(ant_object_read_clusters(pvs, 1, clusters, 5, &triangles) == ANT_OK && triangles == 1 && clusters[0] == 2);
    CHECK(ant_object_read_clusters(pvs, 2, clusters, 5, &triangles) == ANT_USAGE);
    CHECK(ant_cursor_create(pvs, &cursor) == ANT_OK);
    CHECK(ant_cursor_sees_cluster(cursor, 0, &visible) == ANT_USAGE && visible == 9);
    CHECK(ant_cursor_query(cursor, eye, NULL) == ANT_OK);
    CHECK(ant_cursor_sees_cluster(cursor, 0, &visible) == ANT_OK && visible == 1);
    CHECK(ant_cursor_sees_cluster(cursor, 1, &visible) == ANT_OK && visible == 0);
    CHECK(ant_cursor_sees_cluster(cursor, 3, &visible) == ANT_USAGE);
    CHECK(ant_cursor_read_cluster_bits(cursor, &bits, 0, &triangles) == ANT_LIMIT && triangles == 1 && bits == 99);
    CHECK(ant_cursor_read_cluster_bits(cursor, &bits, 1, &triangles) == ANT_OK && bits == 5);
    CHECK(ant_cursor_query(cursor, inside, NULL) == ANT_OK); /* solid: everything */
    CHECK(ant_cursor_read_cluster_bits(cursor, &bits, 1, &triangles) == ANT_OK && bits == 7);
    ant_cursor_destroy(cursor);
    return 0;
}

int check_leaves(const ant_pvs* pvs) {
    const double low[3] = {0.5, 0.5, 0.5}, middle[3] = {1, 0.5, 0.5}, outside[3] = {5, 0.5, 0.5};
    ant_cell cell;
    int64_t found = 9;
    CHECK(ant_cell_describe(pvs, 0, &cell) == ANT_USAGE); /* splits */
    CHECK(ant_cell_describe(pvs, 3, &cell) == ANT_USAGE);
    CHECK(ant_cell_describe(pvs, 1, &cell) == ANT_OK && cell.kind == ANT_CELL_BAKED);
    CHECK(cell.min[0] == 0 && cell.max[0] == 1 && cell.max[1] == 1);
    CHECK(ant_cell_describe(pvs, 2, &cell) == ANT_OK && cell.kind == ANT_CELL_SOLID);
    CHECK(cell.min[0] == 1 && cell.max[0] == 4);
    CHECK(ant_cell_find(pvs, low, &found) == ANT_OK && found == 1);
    CHECK(ant_cell_find(pvs, middle, &found) == ANT_OK && found == 2);
    CHECK(ant_cell_find(pvs, outside, &found) == ANT_OK && found == -1);
    return 0;
}
