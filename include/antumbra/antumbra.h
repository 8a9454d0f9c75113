/* Antumbra, C interface. This header is the manual.
 *
 *     ant_pvs* pvs;
 *     ant_cursor* cursor;
 *     char error[256];
 *     if (ant_pvs_open_file("house.pvs", &pvs, error, sizeof error) != ANT_OK) { puts(error); return 1; }
 *     ant_cursor_create(pvs, &cursor);
 *     for (each frame) {
 *         int changed;
 *         ant_cursor_query(cursor, eye, &changed);
 *         if (changed) {
 *             ant_cursor_read_ids(cursor, ids, capacity, &count);  // draw these objects
 *         }
 *     }
 *     ant_cursor_destroy(cursor);
 *     ant_pvs_close(pvs);
 *
 * Without a bake, or on top of one: an ant_cull_scene of boxes and occluders, an ant_culler over it, and one ant_cull_state
 * for each view (see "Culling" below).
 *
 * Rules that hold for every function
 *  - It returns an ant_status and never throws, prints, exits or touches global state. Where an answer goes to
 *    a pointer, that pointer is written only if the status is ANT_OK (and where stated otherwise).
 *  - A NULL where an object is needed, or an index out of range, gives ANT_USAGE and nothing else happens.
 *  - Sizes come first: call a "read" function with a NULL buffer and capacity 0 to learn how much there is. A
 *    buffer that is too small is not written: the call gives ANT_LIMIT and the size that is needed.
 *  - Structs that begin with struct_size: set it to sizeof the struct before the call. A library that is newer than
 *    its caller uses as much of the struct as the caller knows; too small a size is ANT_USAGE, and input of a size that
 *    the library does not know yet ANT_UNSUPPORTED.
 *  - Threads: an ant_pvs, ant_cull_scene or ant_culler may be used by any number of threads at once. An ant_cursor or
 *    ant_cull_state belongs to one thread at a time. Opening, closing, creating and destroying are ordinary calls without hidden state.
 *  - Objects are numbered from 0 in the order in which the baker met them; node, primitive and instance say
 *    what each is in the scene's own file.
 *  - Coordinates are those of the scene file (world), in its units, as double.
 *  - Memory is taken by open and create and by the first query of a cursor or the first frames of a cull state; later
 *    ones take none. When there is no memory left the program ends, as with any C++ program built without exceptions.
 */
#ifndef ANTUMBRA_ANTUMBRA_H
#define ANTUMBRA_ANTUMBRA_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Versions and status ---------------------------------------------------------------------------------- */

#define ANT_VERSION_MAJOR 0
#define ANT_VERSION_MINOR 1
#define ANT_VERSION_PATCH 0

/* Version of the library that is linked, e.g. "0.1.0": compare with the numbers above. Never NULL. */
const char* ant_version_text(void);

/* The newest .pvs format that the library reads: major * 65536 + minor. */
uint32_t ant_version_format(void);

/* The numbers never change. */
typedef enum ant_status {
    ANT_OK = 0,
    ANT_USAGE = 1,       /* an argument makes no sense */
    ANT_IO = 2,          /* the disk or the file system refused */
    ANT_CORRUPT = 3,     /* the file is damaged, truncated or contradicts itself */
    ANT_UNSUPPORTED = 4, /* the file is well formed but asks for what this version cannot do */
    ANT_LIMIT = 5,       /* a buffer is too small, or a stated limit would be exceeded */
    ANT_MISMATCH = 6,    /* two inputs do not belong together */
    ANT_CANCELLED = 7,   /* asked to stop */
    ANT_INTERNAL = 8     /* a broken promise of the library; please report */
} ant_status;

/* One word for a status, e.g. "corrupt"; "unknown" for others. Never NULL. */
const char* ant_status_name(ant_status status);

/* What an answer promises. The numbers never change. */
typedef enum ant_guarantee {
    ANT_EXACT = 1,        /* what is visible and nothing else */
    ANT_CONSERVATIVE = 2, /* at least what is visible */
    ANT_AGGRESSIVE = 3,   /* only what is visible, perhaps not all of it */
    ANT_APPROXIMATE = 4   /* neither */
} ant_guarantee;

/* One word for a guarantee, e.g. "conservative"; "unknown" for others. Never NULL. */
const char* ant_guarantee_name(ant_guarantee guarantee);

/* ---- Opening a .pvs file ---------------------------------------------------------------------------------- */

/* An opened file. Immutable. */
typedef struct ant_pvs ant_pvs;

/* Opens a file that lies in memory. The caller keeps `bytes` alive and unchanged until ant_pvs_close.
 * Checks everything once: time proportional to `size` (about 1 GB/s), memory one bit per object.
 * Errors: ANT_CORRUPT (names the chunk), ANT_UNSUPPORTED (written by a later version), ANT_USAGE.
 * `error` (may be NULL) receives one line of text, cut to error_size - 1 letters and ended by a zero; "" on success.
 * `*pvs` becomes NULL on any error. */
ant_status ant_pvs_open_memory(const void* bytes, size_t size, ant_pvs** pvs, char* error, size_t error_size);

/* The same for a file of the file system, which is mapped until ant_pvs_close; it must not be changed meanwhile
 * (replace it by renaming another over it). Also ANT_IO. ANT_UNSUPPORTED where there is no file system (WebAssembly). */
ant_status ant_pvs_open_file(const char* path, ant_pvs** pvs, char* error, size_t error_size);

/* Ends it; its cursors must be destroyed before. NULL is allowed. */
void ant_pvs_close(ant_pvs* pvs);

/* What a file says about itself. Set struct_size to sizeof(ant_pvs_info) before the call: a later library fills
 * only as much of the struct as the caller knows. */
typedef struct ant_pvs_info {
    size_t struct_size;
    ant_guarantee guarantee;       /* of answers inside baked cells */
    uint32_t object_count;
    uint64_t cell_count;           /* product of grid_count; 0: no grid */
    uint32_t grid_count[3];        /* cells along x, y, z */
    uint32_t sides;                /* 0: faces are seen from the sides that their material says, 1: from both */
    double grid_min[3];            /* box of all cells, world */
    double grid_max[3];
    double origin[3];              /* world position that stored bounds are relative to */
    uint8_t scene_fingerprint[16]; /* hash of the geometry that was baked */
    uint64_t structure_fingerprint; /* FNV-1a over (node, primitive, instance, triangles in the file) as 32-bit
                                       little-endian numbers, object by object: compare with your scene to notice
                                       a stale bake */
    uint64_t file_bytes;
    uint64_t visibility_bytes;     /* coded visibility alone */
    uint64_t volume_count;         /* occludee volumes, for ant_cursor_sees_box; 0: none */
    uint64_t tree_nodes;           /* of the view tree that some files have in place of the grid; 0: none */
} ant_pvs_info;

/* Errors: ANT_USAGE, also for an impossible struct_size. Cost: nanoseconds. */
ant_status ant_pvs_describe(const ant_pvs* pvs, ant_pvs_info* info);

typedef enum ant_text {
    ANT_TEXT_METHOD = 0,       /* how it was baked, e.g. "sampled" */
    ANT_TEXT_TOOL_VERSION = 1, /* program that baked it */
    ANT_TEXT_OPTIONS = 2       /* options and measured statistics, one JSON object */
} ant_text;

/* Copies a text and a zero after it; needs capacity >= *length + 1. `*length` is the number of letters without
 * that zero. Texts come from files: they need not be UTF-8 and may hold zeros. Errors: ANT_USAGE, ANT_LIMIT. */
ant_status ant_pvs_read_text(const ant_pvs* pvs, ant_text which, char* buffer, size_t capacity, size_t* length);

/* ---- Objects ---------------------------------------------------------------------------------------------- */

/* Bits of ant_object::flags. */
#define ANT_OBJECT_OCCLUDES 1u
#define ANT_OBJECT_DOUBLE_SIDED 2u
#define ANT_OBJECT_ALWAYS_VISIBLE 4u /* in every answer */
#define ANT_OBJECT_MOVES 8u          /* bounds are those of the rest pose */

typedef struct ant_object {
    int32_t node, primitive, instance; /* in the scene file (glTF indices); -1: no such notion */
    uint32_t flags;
    uint32_t triangle_count;
    double bounds_min[3], bounds_max[3]; /* world */
} ant_object;

/* Errors: ANT_USAGE. Cost: nanoseconds. */
ant_status ant_object_describe(const ant_pvs* pvs, uint32_t object, ant_object* description);

/* The object's name; buffer and length as in ant_pvs_read_text. Errors: ANT_USAGE, ANT_LIMIT. */
ant_status ant_object_read_name(const ant_pvs* pvs, uint32_t object, char* buffer, size_t capacity, size_t* length);

/* ---- Clusters ---------------------------------------------------------------------------------------------
 *
 * Files that list clusters say which triangles of an object can be seen, not only that the object can. To draw them: once, sort
 * each object's index buffer by the clusters of its triangles (keeping the order within each), so that a cluster is a range of
 * it; then, whenever an answer has changed, draw the ranges of visible clusters. */

#define ANT_NO_CLUSTER 0xFFFFFFFFu /* of a triangle without area: never seen */

/* How many clusters all objects have together; 0: only objects are listed. Errors: ANT_USAGE. */
ant_status ant_pvs_count_clusters(const ant_pvs* pvs, uint32_t* count);

/* For each of the object's triangles in the scene's file, in order (triangle t has corners 3 t .. 3 t + 2 of its index buffer):
 * the number of its cluster, or ANT_NO_CLUSTER. `*count` triangles: if that is not what your own buffer holds, draw the object
 * whole. Errors: ANT_USAGE (also where there are no clusters), ANT_LIMIT. Cost: O(triangles); memory while it runs. */
ant_status ant_object_read_clusters(const ant_pvs* pvs, uint32_t object, uint32_t* clusters, size_t capacity, size_t* count);

/* ---- Cells ------------------------------------------------------------------------------------------------ */

typedef enum ant_cell_kind {
    ANT_CELL_BAKED = 0,
    ANT_CELL_NOT_BAKED = 1, /* nobody asked for it: everything is visible */
    ANT_CELL_SOLID = 2      /* inside geometry, no place for a viewer: everything is visible */
} ant_cell_kind;

typedef struct ant_cell {
    ant_cell_kind kind;
    double min[3], max[3]; /* closed box, world */
} ant_cell;

/* Cell (i,j,k) has number i + grid_count[0] * (j + grid_count[1] * k). In a file with a view tree the cells are the leaves among
 * the numbers below tree_nodes; the others are ANT_USAGE. A leaf may stand for some directions alone: several share their space
 * then. Errors: ANT_USAGE. Cost: nanoseconds. */
ant_status ant_cell_describe(const ant_pvs* pvs, uint64_t cell, ant_cell* description);

/* The cell that holds a point, or -1 outside all of them, for NaN, and where leaves of a view tree split directions. A point on a face that two cells share is in
 * the one above it. Errors: ANT_USAGE. Cost: some ten nanoseconds. */
ant_status ant_cell_find(const ant_pvs* pvs, const double point[3], int64_t* cell);

/* ---- Queries ---------------------------------------------------------------------------------------------- */

/* The state of one view: remembers the last answer, so that a viewer who stays in his cell pays nothing. */
typedef struct ant_cursor ant_cursor;

/* The cursor refers to `pvs`, which must stay open while it is used. Errors: ANT_USAGE; `*cursor` is NULL then. */
ant_status ant_cursor_create(const ant_pvs* pvs, ant_cursor** cursor);

/* NULL is allowed. */
void ant_cursor_destroy(ant_cursor* cursor);

/* What can be seen from `eye` (three coordinates, world)? `*changed` (may be NULL) becomes 1 if the answer is another
 * than the cursor's last one, else 0. An eye outside every baked cell, inside solid matter, infinite or NaN sees
 * everything: that is an answer, not an error.
 * Cost: below 1 microsecond per 4,000 objects in a new cell, below 50 nanoseconds in the same one. Errors: ANT_USAGE. */
ant_status ant_cursor_query(ant_cursor* cursor, const double eye[3], int* changed);

/* What can be seen from somewhere in a range of views: every viewpoint of the closed box eye_min .. eye_max (equal for a
 * single one), looking as a camera does along `direction` with `up` upward (neither need be normal or unit); the
 * picture's height is 2 * tan_half_fov_y at distance 1, its width `aspect` times that. direction NULL: every way.
 * The union over all cells that the range touches, less the objects whose stored bounds lie outside the frustum from
 * every viewpoint (objects that are always visible stay); conservative in direction. A box that is partly outside the
 * cells, or senseless numbers, see everything in the frustum, or every way. up NULL: the y axis.
 * Cost: the cells touched, some hundred nanoseconds each, and some ten nanoseconds per visible object. Errors: ANT_USAGE. */
ant_status ant_cursor_query_range(ant_cursor* cursor, const double eye_min[3], const double eye_max[3],
                                  const double direction[3], const double up[3], double tan_half_fov_y, double aspect,
                                  int* changed);

/* Whether something moving within the box can be seen, by the cursor's last answer: `*visible` becomes 0 only if the file
 * has occludee volumes, all that the box touches are hidden, and none of it is outside of them. Does not look at the
 * frustum of a range. Errors: ANT_USAGE (also before the first query). Cost: a nanosecond per volume touched. */
ant_status ant_cursor_sees_box(const ant_cursor* cursor, const double box_min[3], const double box_max[3],
                               int* visible);

typedef struct ant_answer {
    int64_t cell;            /* number of the cell (in a file with a view tree: of the leaf), -1: outside all of
                                them, -3: the answer comes from several, or was for a range */
    ant_guarantee guarantee; /* of this answer: that of the file; but if everything is visible conservative; for a
                                range conservative if the file promises that nothing is lost, else approximate */
    int32_t everything;      /* 1: nothing is known here, so all objects are in the answer */
    uint32_t visible_count;
} ant_answer;

/* The last answer in short. ANT_USAGE before the first query. Cost: nanoseconds. */
ant_status ant_cursor_describe(const ant_cursor* cursor, ant_answer* answer);

/* The numbers of the visible objects, ascending; `*count` of them. Errors: ANT_USAGE (also before the first query),
 * ANT_LIMIT. Cost: about a nanosecond per visible object. */
ant_status ant_cursor_read_ids(const ant_cursor* cursor, uint32_t* ids, size_t capacity, size_t* count);

/* The answer as a bit set: object o is bit o % 8 (1 << that) of byte o / 8; `*count` = (objects + 7) / 8 bytes.
 * Errors: ANT_USAGE (also before the first query), ANT_LIMIT. */
ant_status ant_cursor_read_bits(const ant_cursor* cursor, uint8_t* bytes, size_t capacity, size_t* count);

/* `*visible` becomes 1 or 0. Errors: ANT_USAGE (also before the first query). Cost: a nanosecond. */
ant_status ant_cursor_sees(const ant_cursor* cursor, uint32_t object, int* visible);

/* The same of clusters: `*visible` becomes 1 or 0; 1 where that cannot be told. The frustum of a range is not looked at: draw
 * the visible clusters of visible objects. Errors: ANT_USAGE (also before the first query). */
ant_status ant_cursor_sees_cluster(const ant_cursor* cursor, uint32_t cluster, int* visible);

/* All clusters as a bit set, as ant_cursor_read_bits. Errors: ANT_USAGE (also before the first query), ANT_LIMIT. */
ant_status ant_cursor_read_cluster_bits(const ant_cursor* cursor, uint8_t* bytes, size_t capacity, size_t* count);

/* What a renderer has to do: the objects that are visible now and were not at the last successful call of this
 * function (`shown`), and the other way round (`hidden`), both ascending. Before the first call everything counts as
 * visible, so that a renderer that begins by drawing all objects only ever applies differences. With both buffers NULL
 * or one of them too small (ANT_LIMIT) the two counts are written and nothing else happens: the differences stay to be
 * read. A difference that is empty needs no buffer. Errors: ANT_USAGE (also before the first query), ANT_LIMIT.
 * Cost: a nanosecond per 64 objects and per difference; memory (one bit per object) once. */
ant_status ant_cursor_read_changes(ant_cursor* cursor, uint32_t* shown, size_t shown_capacity, size_t* shown_count,
                                   uint32_t* hidden, size_t hidden_capacity, size_t* hidden_count);

/* ---- Culling ---------------------------------------------------------------------------------------------------
 *
 *     ant_cull_scene* scene;  ant_culler* culler;  ant_cull_state* state;  ant_view view;
 *     ant_cull_scene_create(&input, &scene, error, sizeof error);           // or ant_cull_scene_create_from_pvs
 *     ant_culler_create(scene, "masked", NULL, &culler, error, sizeof error);
 *     ant_cull_state_create(&state);                                        // one for each camera, shadow cascade, eye
 *     ant_view_init(&view, sizeof view);
 *     for (each frame) {
 *         ... view.eye, view.target, view.fov_y_deg, view.aspect ...
 *         ant_culler_cull(culler, &view, state);
 *         ant_cull_state_read_ids(state, ids, capacity, &count);            // draw these objects
 *     }
 */

/* Boxes of objects and what hides things, prepared for culling. Immutable. */
typedef struct ant_cull_scene ant_cull_scene;

/* What a scene is made of. Only read during ant_cull_scene_create. Occluders are triangles that surely block sight
 * (opaque, not animated, really drawn); connected ones work best: vertices at the same place are taken as one. Few
 * and large ones pay most. Triangles without area, or with a coordinate that is not finite, are left out. */
typedef struct ant_cull_input {
    size_t struct_size;
    uint32_t object_count;
    const double* bounds;      /* for each object: least x, y, z, greatest x, y, z. Senseless boxes are always visible */
    const uint32_t* flags;     /* for each object: ANT_OBJECT_ALWAYS_VISIBLE matters, other bits do not. NULL: none */
    double origin[3];          /* near the scene: boxes are kept in single precision relative to it, rounded outward */
    uint32_t vertex_count;
    const double* vertices;    /* x, y, z of each; NULL if there are none */
    uint32_t triangle_count;   /* 0: methods that need occluders cull by the frustum only */
    const uint32_t* triangles; /* three vertices of each, counter-clockwise seen from the front */
    const uint8_t* two_sided;  /* for each triangle: 0 blocks sight only towards its front. NULL: all 0 */
} ant_cull_input;

/* Errors: ANT_USAGE (a vertex number out of range, a needed pointer NULL, an origin that is not finite),
 * ANT_UNSUPPORTED. `error` as in ant_pvs_open_memory. Cost: O(n log n), about a microsecond per box or triangle. */
ant_status ant_cull_scene_create(const ant_cull_input* input, ant_cull_scene** scene, char* error, size_t error_size);

/* The scene that a file was baked from: its objects in their order, and what `antumbra prepare` has put into the file
 * (occluders, trees), checked. Does not need `pvs` afterwards. Errors: ANT_USAGE, ANT_CORRUPT. */
ant_status ant_cull_scene_create_from_pvs(const ant_pvs* pvs, ant_cull_scene** scene, char* error, size_t error_size);

/* NULL is allowed. Cullers made from it keep what they need. */
void ant_cull_scene_destroy(ant_cull_scene* scene);

typedef struct ant_cull_scene_info {
    size_t struct_size;
    uint32_t object_count;
    uint32_t occluder_count; /* polygons that block sight */
} ant_cull_scene_info;

/* Errors: ANT_USAGE. */
ant_status ant_cull_scene_describe(const ant_cull_scene* scene, ant_cull_scene_info* info);

/* One method of culling over one scene. Immutable. */
typedef struct ant_culler ant_culler;

typedef struct ant_culler_options {
    size_t struct_size;
    uint32_t occluders;       /* "planes": occluders per frame, 0..64 */
    uint32_t raster_width;    /* "hzb", "masked": pixels across, 8..2048 */
    uint32_t polygon_budget;  /* "hzb", "masked": polygons drawn per frame at most */
    float pixels_per_polygon; /* "masked": patches that cover fewer pixels for each polygon are not drawn */
    const ant_pvs* pvs;       /* "pvs": the baked file, of the same objects in the same order; must stay open while
                                 the culler is used. NULL for other methods */
} ant_culler_options;

/* Sets the defaults. `size` is sizeof(ant_culler_options). Errors: ANT_USAGE. */
ant_status ant_culler_options_init(ant_culler_options* options, size_t size);

/* How many methods there are, and the name of each, from the plainest to the most elaborate; buffer and length as in
 * ant_pvs_read_text. Errors: ANT_USAGE, ANT_LIMIT. */
uint32_t ant_culler_method_count(void);
ant_status ant_culler_read_method(uint32_t index, char* buffer, size_t capacity, size_t* length);

/* options NULL: the defaults. Errors: ANT_USAGE (the method is unknown: the text lists the known ones; an option out of
 * range or missing), ANT_MISMATCH (a pvs of another scene), ANT_UNSUPPORTED. */
ant_status ant_culler_create(const ant_cull_scene* scene, const char* method, const ant_culler_options* options,
                             ant_culler** culler, char* error, size_t error_size);

/* NULL is allowed. */
void ant_culler_destroy(ant_culler* culler);

/* Of what it reports, against what is visible in the view. Errors: ANT_USAGE. */
ant_status ant_culler_guarantee(const ant_culler* culler, ant_guarantee* guarantee);

typedef enum ant_projection { ANT_PERSPECTIVE = 0, ANT_ORTHOGRAPHIC = 1 } ant_projection;

/* A camera, in world coordinates. */
typedef struct ant_view {
    size_t struct_size;
    ant_projection projection;
    double eye[3];
    double target[3]; /* any point on the line of sight but the eye */
    double up[3];     /* not along the line of sight */
    double fov_y_deg; /* perspective: full vertical angle, above 0 and below 180 */
    double height;    /* orthographic: height of the view volume */
    double aspect;    /* width / height */
    double near_plane, far_plane; /* distances along the line of sight; the far one may be infinite */
} ant_view;

/* Sets the defaults: perspective, 60 degrees, 16 : 9, from 0.1 to infinity, at the origin, looking along -z, y upward.
 * `size` is sizeof(ant_view). Errors: ANT_USAGE. */
ant_status ant_view_init(ant_view* view, size_t size);

/* What one view keeps from frame to frame, and its last answer. Serves one culler at a time: used with another one
 * it forgets its caches, not what ant_cull_state_read_changes has told. */
typedef struct ant_cull_state ant_cull_state;

/* Errors: ANT_USAGE. */
ant_status ant_cull_state_create(ant_cull_state** state);

/* NULL is allowed. */
void ant_cull_state_destroy(ant_cull_state* state);

/* Which objects can be seen in this view? The answer lies in `state`. Whatever cannot be decided is visible; a view that
 * makes no sense (NaN, target at the eye, ..) sees everything: that is an answer, not an error. Errors: ANT_USAGE,
 * ANT_UNSUPPORTED. */
ant_status ant_culler_cull(const ant_culler* culler, const ant_view* view, ant_cull_state* state);

typedef struct ant_cull_answer {
    size_t struct_size;
    ant_guarantee guarantee;
    int32_t everything;           /* 1: the method had to give up and reports every object */
    const char* reason;           /* then: why (static text); else "" */
    uint32_t object_count;
    uint32_t visible_count;
    uint64_t boxes_tested;        /* what the stages did; a stage that a method does not have stays 0 */
    uint64_t outside_frustum;     /* boxes of nodes and objects outside the frustum */
    uint64_t hidden_by_pvs;       /* objects */
    uint64_t hidden_by_occluders; /* boxes of nodes and objects behind occluders */
    uint64_t occluders_used;      /* shadows cast, or polygons drawn */
} ant_cull_answer;

/* The last answer in short. Errors: ANT_USAGE, also before the first one. */
ant_status ant_cull_state_describe(const ant_cull_state* state, ant_cull_answer* answer);

/* The last answer, as ant_cursor_read_ids, _read_bits, _sees and _read_changes have it. */
ant_status ant_cull_state_read_ids(const ant_cull_state* state, uint32_t* ids, size_t capacity, size_t* count);
ant_status ant_cull_state_read_bits(const ant_cull_state* state, uint8_t* bytes, size_t capacity, size_t* count);
ant_status ant_cull_state_sees(const ant_cull_state* state, uint32_t object, int* visible);
ant_status ant_cull_state_read_changes(ant_cull_state* state, uint32_t* shown, size_t shown_capacity, size_t* shown_count,
                                       uint32_t* hidden, size_t hidden_capacity, size_t* hidden_count);

#ifdef __cplusplus
}
#endif

#endif
