/* Culling through the C interface, as a C99 program meets it. Each check function returns 0, or the line that failed. */
#include <antumbra/antumbra.h>

#include <math.h>
#include <string.h>

#define CHECK(condition)                                                                                              \
    do {                                                                                                              \
        if (!(condition))                                                                                             \
            return __LINE__;                                                                                          \
    } while (0)

/* The eye at (1000, 1, 0) looks along -z. Object 0 stands in front of a wall at z = -5 that faces it, object 1 behind it,
 * object 2 beside it, object 3 behind the eye, object 4 too, but is always visible. */
static const double kBounds[] = {999.5, 0.5, -3,  1000.5, 1.5, -2,  999.5, 0.5, -9,   1000.5, 1.5, -8,
                                 1008,  0.5, -11, 1009,   1.5, -10, 999.5, 0.5, 8,    1000.5, 1.5, 9,
                                 999.5, 0.5, 8,   1000.5, 1.5, 9};
static const uint32_t kFlags[] = {0, 0, 0, 0, ANT_OBJECT_ALWAYS_VISIBLE};
/* Corners of the wall, the lower right one twice, and one that is nowhere. */
static const double kVertices[] = {997, -2, -5, 1003, -2, -5, 1003, 4, -5, 997, 4, -5, 1003, -2, -5, NAN, 0, 0};
static const uint32_t kTriangles[] = {0, 1, 2, 0, 2, 3, 4, 1, 2, 0, 1, 5}; /* the third has no area, the fourth no place */

static ant_cull_input wall(void) {
    ant_cull_input input;
    memset(&input, 0, sizeof input);
    input.struct_size = sizeof input;
    input.object_count = 5;
    input.bounds = kBounds;
    input.flags = kFlags;
    input.origin[0] = 1000;
    input.vertex_count = 6;
    input.vertices = kVertices;
    input.triangle_count = 4;
    input.triangles = kTriangles;
    return input;
}

static ant_view view_of(double target_z) {
    ant_view view;
    ant_view_init(&view, sizeof view);
    view.eye[0] = view.target[0] = 1000;
    view.eye[1] = view.target[1] = 1;
    view.target[2] = target_z;
    view.fov_y_deg = 90;
    return view;
}

int check_cull_scene(void) {
    ant_cull_input input = wall();
    ant_cull_scene* scene;
    ant_cull_scene_info info;
    char error[200];
    CHECK(ant_cull_scene_create(&input, &scene, error, sizeof error) == ANT_OK && scene && error[0] == 0);
    info.struct_size = sizeof info;
    CHECK(ant_cull_scene_describe(scene, &info) == ANT_OK && info.object_count == 5 && info.occluder_count == 2);
    ant_cull_scene_destroy(scene);
    input.object_count = 0;
    input.bounds = NULL;
    input.triangle_count = 0;
    input.triangles = NULL;
    CHECK(ant_cull_scene_create(&input, &scene, NULL, 0) == ANT_OK && scene); /* nothing at all is a scene, too */
    ant_cull_scene_destroy(scene);
    return 0;
}

/* What each method reports in front of the wall, as a bit set. */
static int expected(const char* method) {
    if (strcmp(method, "none") == 0)
        return 31;
    return strncmp(method, "frustum", 7) == 0 ? 23 : 21;
}

int check_cull_methods(void) {
    ant_cull_input input = wall();
    ant_cull_scene* scene;
    ant_cull_state* state;
    ant_view forward = view_of(-1);
    char error[200], method[32];
    size_t length;
    uint32_t i, tried = 0;
    CHECK(ant_cull_scene_create(&input, &scene, error, sizeof error) == ANT_OK);
    CHECK(ant_cull_state_create(&state) == ANT_OK);
    for (i = 0; i < ant_culler_method_count(); ++i) {
        ant_culler* culler;
        ant_cull_answer answer;
        ant_guarantee guarantee;
        uint8_t bits;
        size_t count;
        CHECK(ant_culler_read_method(i, method, sizeof method, &length) == ANT_OK && strlen(method) == length);
        if (strcmp(method, "pvs") == 0) {
            CHECK(ant_culler_create(scene, method, NULL, &culler, error, sizeof error) == ANT_USAGE && !culler);
            CHECK(strstr(error, ".pvs") != NULL);
            continue;
        }
        CHECK(ant_culler_create(scene, method, NULL, &culler, error, sizeof error) == ANT_OK);
        CHECK(ant_culler_guarantee(culler, &guarantee) == ANT_OK);
        CHECK(ant_culler_cull(culler, &forward, state) == ANT_OK);
        answer.struct_size = sizeof answer;
        CHECK(ant_cull_state_describe(state, &answer) == ANT_OK && answer.object_count == 5);
        CHECK(answer.everything || (answer.guarantee == guarantee && answer.reason[0] == 0));
        CHECK(!answer.everything || strcmp(method, "none") == 0);
        CHECK(ant_cull_state_read_bits(state, &bits, 1, &count) == ANT_OK && count == 1);
        /* A method may know less than another, never more than there is. */
        CHECK((bits & 21) == 21 && (bits & ~expected("none")) == 0);
        if (strcmp(method, "masked") == 0 || strcmp(method, "planes") == 0 || strcmp(method, "frustum") == 0) {
            CHECK(bits == expected(method));
            ++tried;
        }
        ant_culler_destroy(culler);
    }
    CHECK(tried == 3);
    CHECK(ant_culler_read_method(i, method, sizeof method, &length) == ANT_USAGE);
    ant_cull_state_destroy(state);
    ant_cull_scene_destroy(scene);
    return 0;
}

int check_cull_answers(void) {
    ant_cull_input input = wall();
    ant_cull_scene* scene;
    ant_culler* culler;
    ant_cull_state* state;
    ant_cull_answer answer;
    ant_culler_options options;
    ant_view forward = view_of(-1), backward = view_of(1), senseless = view_of(0);
    uint32_t ids[5] = {9, 9, 9, 9, 9}, hidden[5] = {9, 9, 9, 9, 9};
    size_t count, hidden_count;
    int visible;
    CHECK(ant_cull_scene_create(&input, &scene, NULL, 0) == ANT_OK);
    CHECK(ant_culler_options_init(&options, sizeof options) == ANT_OK && options.occluders == 64 && !options.pvs);
    CHECK(ant_culler_create(scene, "planes", &options, &culler, NULL, 0) == ANT_OK);
    ant_cull_scene_destroy(scene); /* the culler keeps what it needs */
    CHECK(ant_cull_state_create(&state) == ANT_OK);
    answer.struct_size = sizeof answer;
    CHECK(ant_cull_state_describe(state, &answer) == ANT_USAGE); /* nothing asked yet */
    CHECK(ant_cull_state_read_ids(state, NULL, 0, &count) == ANT_USAGE);
    CHECK(ant_cull_state_read_bits(state, NULL, 0, &count) == ANT_USAGE);
    CHECK(ant_cull_state_sees(state, 0, &visible) == ANT_USAGE);
    CHECK(ant_cull_state_read_changes(state, NULL, 0, &count, NULL, 0, &hidden_count) == ANT_USAGE);

    CHECK(ant_culler_cull(culler, &forward, state) == ANT_OK);
    CHECK(ant_cull_state_describe(state, &answer) == ANT_OK && answer.visible_count == 3);
    CHECK(answer.hidden_by_occluders >= 1 && answer.occluders_used >= 1 && answer.boxes_tested >= 1);
    CHECK(ant_cull_state_read_ids(state, ids, 2, &count) == ANT_LIMIT && count == 3 && ids[0] == 9);
    CHECK(ant_cull_state_read_ids(state, ids, 5, &count) == ANT_OK && count == 3);
    CHECK(ids[0] == 0 && ids[1] == 2 && ids[2] == 4 && ids[3] == 9);
    CHECK(ant_cull_state_sees(state, 1, &visible) == ANT_OK && !visible);
    CHECK(ant_cull_state_sees(state, 2, &visible) == ANT_OK && visible);
    CHECK(ant_cull_state_sees(state, 5, &visible) == ANT_USAGE);

    /* Before the first call everything counts as shown. */
    CHECK(ant_cull_state_read_changes(state, NULL, 0, &count, NULL, 0, &hidden_count) == ANT_OK);
    CHECK(count == 0 && hidden_count == 2);
    CHECK(ant_cull_state_read_changes(state, NULL, 0, &count, hidden, 1, &hidden_count) == ANT_LIMIT && hidden[0] == 9);
    CHECK(ant_cull_state_read_changes(state, NULL, 0, &count, hidden, 5, &hidden_count) == ANT_OK);
    CHECK(count == 0 && hidden_count == 2 && hidden[0] == 1 && hidden[1] == 3 && hidden[2] == 9);
    CHECK(ant_cull_state_read_changes(state, ids, 5, &count, hidden, 5, &hidden_count) == ANT_OK);
    CHECK(count == 0 && hidden_count == 0);

    CHECK(ant_culler_cull(culler, &backward, state) == ANT_OK);
    CHECK(ant_cull_state_read_changes(state, ids, 5, &count, hidden, 5, &hidden_count) == ANT_OK);
    CHECK(count == 1 && ids[0] == 3 && hidden_count == 2 && hidden[0] == 0 && hidden[1] == 2);

    CHECK(ant_culler_cull(culler, &senseless, state) == ANT_OK); /* no line of sight: everything */
    CHECK(ant_cull_state_describe(state, &answer) == ANT_OK && answer.everything && answer.reason[0] != 0);
    CHECK(answer.visible_count == 5 && answer.guarantee == ANT_CONSERVATIVE);
    forward.projection = ANT_ORTHOGRAPHIC;
    forward.height = 2;
    forward.aspect = 1;
    CHECK(ant_culler_cull(culler, &forward, state) == ANT_OK);
    CHECK(ant_cull_state_sees(state, 0, &visible) == ANT_OK && visible);
    CHECK(ant_cull_state_sees(state, 2, &visible) == ANT_OK && !visible);
    ant_cull_state_destroy(state);
    ant_culler_destroy(culler);
    return 0;
}

/* A file with three objects: see antumbra_test.c. */
int check_cull_of_file(const ant_pvs* pvs) {
    ant_cull_scene* scene;
    ant_cull_scene_info info;
    ant_culler* culler;
    ant_culler_options options;
    ant_cull_state* state;
    ant_cull_input input = wall();
    ant_cull_scene* other;
    ant_view view;
    ant_guarantee guarantee;
    uint32_t ids[3];
    size_t count;
    char error[200];
    CHECK(ant_cull_scene_create_from_pvs(pvs, &scene, error, sizeof error) == ANT_OK);
    info.struct_size = sizeof info;
    CHECK(ant_cull_scene_describe(scene, &info) == ANT_OK && info.object_count == 3);
    ant_culler_options_init(&options, sizeof options);
    options.pvs = pvs;
    CHECK(ant_culler_create(scene, "pvs", &options, &culler, error, sizeof error) == ANT_OK);
    CHECK(ant_culler_guarantee(culler, &guarantee) == ANT_OK && guarantee == ANT_CONSERVATIVE);
    CHECK(ant_cull_state_create(&state) == ANT_OK);
    ant_view_init(&view, sizeof view);
    view.eye[0] = 1.5, view.eye[1] = 0.5, view.eye[2] = 0.5;
    view.target[0] = 3, view.target[1] = 0.5, view.target[2] = 0.5;
    CHECK(ant_culler_cull(culler, &view, state) == ANT_OK);
    CHECK(ant_cull_state_read_ids(state, ids, 3, &count) == ANT_OK && count == 2 && ids[0] == 0 && ids[1] == 2);
    ant_culler_destroy(culler);
    CHECK(ant_cull_scene_create(&input, &other, NULL, 0) == ANT_OK);
    CHECK(ant_culler_create(other, "pvs", &options, &culler, error, sizeof error) == ANT_MISMATCH && error[0] != 0);
    ant_cull_scene_destroy(other);
    ant_cull_state_destroy(state);
    ant_cull_scene_destroy(scene);
    return 0;
}

int check_cursor_changes(const ant_pvs* pvs) {
    ant_cursor* cursor;
    uint32_t shown[3], hidden[3];
    size_t shown_count, hidden_count;
    const double first[3] = {0.5, 0.5, 0.5}, second[3] = {1.5, 0.5, 0.5}, unbaked[3] = {2.5, 0.5, 0.5};
    CHECK(ant_cursor_create(pvs, &cursor) == ANT_OK);
    CHECK(ant_cursor_read_changes(cursor, NULL, 0, &shown_count, NULL, 0, &hidden_count) == ANT_USAGE);
    CHECK(ant_cursor_query(cursor, first, NULL) == ANT_OK);
    CHECK(ant_cursor_read_changes(cursor, shown, 3, &shown_count, hidden, 3, &hidden_count) == ANT_OK);
    CHECK(shown_count == 0 && hidden_count == 2 && hidden[0] == 1 && hidden[1] == 2);
    CHECK(ant_cursor_query(cursor, unbaked, NULL) == ANT_OK); /* not read: nothing is lost */
    CHECK(ant_cursor_query(cursor, second, NULL) == ANT_OK);
    CHECK(ant_cursor_read_changes(cursor, shown, 0, &shown_count, hidden, 3, &hidden_count) == ANT_LIMIT);
    CHECK(ant_cursor_read_changes(cursor, NULL, 0, &shown_count, NULL, 0, &hidden_count) == ANT_OK && shown_count == 1);
    CHECK(ant_cursor_read_changes(cursor, shown, 1, &shown_count, NULL, 0, &hidden_count) == ANT_OK);
    CHECK(shown_count == 1 && shown[0] == 2 && hidden_count == 0);
    CHECK(ant_cursor_read_changes(cursor, NULL, 1, &shown_count, hidden, 3, &hidden_count) == ANT_USAGE);
    CHECK(ant_cursor_read_changes(cursor, shown, 3, NULL, hidden, 3, &hidden_count) == ANT_USAGE);
    CHECK(ant_cursor_read_changes(NULL, shown, 3, &shown_count, hidden, 3, &hidden_count) == ANT_USAGE);
    ant_cursor_destroy(cursor);
    return 0;
}

int check_cull_misuse(const ant_pvs* pvs) {
    ant_cull_input input = wall();
    ant_cull_scene* scene = (ant_cull_scene*)1;
    ant_culler* culler = (ant_culler*)1;
    ant_cull_state* state;
    ant_culler_options options;
    ant_view view = view_of(-1);
    ant_cull_scene_info info;
    ant_guarantee guarantee;
    char error[200];
    size_t length;
    const uint32_t beyond[3] = {0, 1, 6};
    CHECK(ant_cull_scene_create(NULL, &scene, error, sizeof error) == ANT_USAGE && !scene && error[0]);
    CHECK(ant_cull_scene_create(&input, NULL, NULL, 0) == ANT_USAGE);
    input.struct_size -= 1;
    CHECK(ant_cull_scene_create(&input, &scene, NULL, 0) == ANT_USAGE);
    input.struct_size += 2;
    CHECK(ant_cull_scene_create(&input, &scene, error, sizeof error) == ANT_UNSUPPORTED && strstr(error, "struct_size"));
    input = wall();
    input.bounds = NULL;
    CHECK(ant_cull_scene_create(&input, &scene, NULL, 0) == ANT_USAGE);
    input = wall();
    input.vertices = NULL;
    CHECK(ant_cull_scene_create(&input, &scene, NULL, 0) == ANT_USAGE);
    input = wall();
    input.triangles = NULL;
    CHECK(ant_cull_scene_create(&input, &scene, NULL, 0) == ANT_USAGE);
    input = wall();
    input.origin[1] = INFINITY;
    CHECK(ant_cull_scene_create(&input, &scene, NULL, 0) == ANT_USAGE);
    input = wall();
    input.triangles = beyond;
    input.triangle_count = 1;
    CHECK(ant_cull_scene_create(&input, &scene, error, sizeof error) == ANT_USAGE && strstr(error, "vertex"));
    CHECK(ant_cull_scene_create_from_pvs(NULL, &scene, NULL, 0) == ANT_USAGE);
    CHECK(ant_cull_scene_create_from_pvs(pvs, NULL, NULL, 0) == ANT_USAGE);
    input = wall();
    CHECK(ant_cull_scene_create(&input, &scene, NULL, 0) == ANT_OK);
    info.struct_size = 1;
    CHECK(ant_cull_scene_describe(scene, &info) == ANT_USAGE && ant_cull_scene_describe(NULL, &info) == ANT_USAGE);
    CHECK(ant_culler_create(NULL, "planes", NULL, &culler, NULL, 0) == ANT_USAGE && !culler);
    CHECK(ant_culler_create(scene, NULL, NULL, &culler, NULL, 0) == ANT_USAGE);
    CHECK(ant_culler_create(scene, "planes", NULL, NULL, NULL, 0) == ANT_USAGE);
    CHECK(ant_culler_create(scene, "guess", NULL, &culler, error, sizeof error) == ANT_USAGE && strstr(error, "masked"));
    CHECK(ant_culler_options_init(NULL, sizeof options) == ANT_USAGE);
    CHECK(ant_culler_options_init(&options, 1) == ANT_USAGE);
    ant_culler_options_init(&options, sizeof options);
    options.raster_width = 4000000000u;
    CHECK(ant_culler_create(scene, "masked", &options, &culler, error, sizeof error) == ANT_USAGE && error[0]);
    options.struct_size = 3;
    CHECK(ant_culler_create(scene, "planes", &options, &culler, NULL, 0) == ANT_USAGE);
    CHECK(ant_culler_read_method(0, NULL, 0, NULL) == ANT_USAGE);
    CHECK(ant_culler_read_method(0, error, 1, &length) == ANT_LIMIT && length == 4);
    CHECK(ant_culler_create(scene, "planes", NULL, &culler, NULL, 0) == ANT_OK);
    CHECK(ant_culler_guarantee(NULL, &guarantee) == ANT_USAGE && ant_culler_guarantee(culler, NULL) == ANT_USAGE);
    CHECK(ant_view_init(NULL, sizeof view) == ANT_USAGE && ant_view_init(&view, 8) == ANT_USAGE);
    CHECK(ant_cull_state_create(NULL) == ANT_USAGE && ant_cull_state_create(&state) == ANT_OK);
    CHECK(ant_culler_cull(NULL, &view, state) == ANT_USAGE && ant_culler_cull(culler, NULL, state) == ANT_USAGE);
    CHECK(ant_culler_cull(culler, &view, NULL) == ANT_USAGE);
    view.projection = (ant_projection)7;
    CHECK(ant_culler_cull(culler, &view, state) == ANT_USAGE);
    view = view_of(-1);
    view.struct_size += 8;
    CHECK(ant_culler_cull(culler, &view, state) == ANT_UNSUPPORTED);
    CHECK(ant_cull_state_read_ids(NULL, NULL, 0, &length) == ANT_USAGE);
    ant_cull_state_destroy(state);
    ant_cull_state_destroy(NULL);
    ant_culler_destroy(culler);
    ant_culler_destroy(NULL);
    ant_cull_scene_destroy(scene);
    ant_cull_scene_destroy(NULL);
    return 0;
}
