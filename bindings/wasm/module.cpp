// What a WebAssembly module needs besides the run time: no way to print, and the proof that structs lie where
// web/antumbra/src reads them.
#include <antumbra/antumbra.h>

#include <cstddef>

// The library's own would print, for which a module would have to import a file system.
extern "C" void abort() { __builtin_trap(); }
extern "C" void __cxa_pure_virtual() { __builtin_trap(); }

#define AT(type, member, offset) static_assert(offsetof(type, member) == offset)
AT(ant_pvs_info, guarantee, 4);
AT(ant_pvs_info, object_count, 8);
AT(ant_pvs_info, cell_count, 16);
AT(ant_pvs_info, grid_count, 24);
AT(ant_pvs_info, sides, 36);
AT(ant_pvs_info, grid_min, 40);
AT(ant_pvs_info, grid_max, 64);
AT(ant_pvs_info, origin, 88);
AT(ant_pvs_info, scene_fingerprint, 112);
AT(ant_pvs_info, structure_fingerprint, 128);
AT(ant_pvs_info, file_bytes, 136);
AT(ant_pvs_info, visibility_bytes, 144);
AT(ant_pvs_info, volume_count, 152);
AT(ant_pvs_info, tree_nodes, 160);
static_assert(sizeof(ant_pvs_info) == 168);
AT(ant_object, flags, 12);
AT(ant_object, triangle_count, 16);
AT(ant_object, bounds_min, 24);
static_assert(sizeof(ant_object) == 72);
AT(ant_cell, min, 8);
static_assert(sizeof(ant_cell) == 56);
AT(ant_answer, guarantee, 8);
AT(ant_answer, everything, 12);
AT(ant_answer, visible_count, 16);
static_assert(sizeof(ant_answer) == 24);
AT(ant_cull_input, object_count, 4);
AT(ant_cull_input, bounds, 8);
AT(ant_cull_input, flags, 12);
AT(ant_cull_input, origin, 16);
AT(ant_cull_input, vertex_count, 40);
AT(ant_cull_input, vertices, 44);
AT(ant_cull_input, triangle_count, 48);
AT(ant_cull_input, triangles, 52);
AT(ant_cull_input, two_sided, 56);
static_assert(sizeof(ant_cull_input) == 64);
AT(ant_cull_scene_info, object_count, 4);
AT(ant_cull_scene_info, occluder_count, 8);
static_assert(sizeof(ant_cull_scene_info) == 12);
AT(ant_culler_options, occluders, 4);
AT(ant_culler_options, raster_width, 8);
AT(ant_culler_options, polygon_budget, 12);
AT(ant_culler_options, pixels_per_polygon, 16);
AT(ant_culler_options, pvs, 20);
static_assert(sizeof(ant_culler_options) == 24);
AT(ant_view, projection, 4);
AT(ant_view, eye, 8);
AT(ant_view, target, 32);
AT(ant_view, up, 56);
AT(ant_view, fov_y_deg, 80);
AT(ant_view, height, 88);
AT(ant_view, aspect, 96);
AT(ant_view, near_plane, 104);
AT(ant_view, far_plane, 112);
static_assert(sizeof(ant_view) == 120);
AT(ant_cull_answer, guarantee, 4);
AT(ant_cull_answer, everything, 8);
AT(ant_cull_answer, reason, 12);
AT(ant_cull_answer, object_count, 16);
AT(ant_cull_answer, visible_count, 20);
AT(ant_cull_answer, boxes_tested, 24);
AT(ant_cull_answer, outside_frustum, 32);
AT(ant_cull_answer, hidden_by_pvs, 40);
AT(ant_cull_answer, hidden_by_occluders, 48);
AT(ant_cull_answer, occluders_used, 56);
static_assert(sizeof(ant_cull_answer) == 64);
