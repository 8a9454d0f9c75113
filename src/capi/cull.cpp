// The part of the C interface that culls: scenes, cullers, states.
#include "capi/shared.hpp"

#include <antumbra/cull.hpp>

#include "cull/scene_data.hpp"

#include <cmath>
#include <cstring>
#include <memory>
#include <numeric>

struct ant_cull_scene {
    antumbra::CullScene scene;
};

struct ant_culler {
    std::unique_ptr<antumbra::Culler> culler;
    antumbra::CullScene scene;
};

struct ant_cull_state {
    antumbra::ViewState view;
    antumbra::CullResult result;
    antumbra::capi::Told told;
    ant_guarantee guarantee = ANT_CONSERVATIVE;
    std::uint32_t objects = 0;
    bool has_answer = false;
};

namespace {

using antumbra::Box3d;
using antumbra::Box3f;
using antumbra::ErrorCode;
using antumbra::Result;
using antumbra::Status;
using antumbra::Vec3d;
using antumbra::Vec3f;
using namespace antumbra::capi;

constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// `value` - `origin` in single precision: the nearest below it (direction -1) or above it (+1).
float local(double value, double origin, int direction) {
    double difference = value - origin;
    double restored = difference + origin; // Knuth's two-sum: the error of the subtraction, exactly
    double error = (value - restored) - (origin - (restored - difference));
    auto rounded = static_cast<float>(difference);
    double excess = static_cast<double>(rounded) - difference - error;
    if (direction * excess < 0)
        rounded = std::nextafter(rounded, static_cast<float>(direction) * kInfinity);
    return rounded;
}

std::vector<Box3f> local_boxes(const ant_cull_input& input) {
    std::vector<Box3f> boxes(input.object_count);
    for (std::size_t o = 0; o < boxes.size(); ++o)
        for (int axis = 0; axis < 3; ++axis) {
            boxes[o].min[axis] = local(input.bounds[o * 6 + std::size_t(axis)], input.origin[axis], -1);
            boxes[o].max[axis] = local(input.bounds[o * 6 + 3 + std::size_t(axis)], input.origin[axis], 1);
        }
    return boxes;
}

/// One vertex for each place, and for each vertex of the input its number; kNowhere if it is not finite.
struct Welded {
    static constexpr std::uint32_t kNowhere = 0xFFFFFFFFu;
    std::vector<Vec3f> places;
    std::vector<std::uint32_t> number;
};

Welded weld(const ant_cull_input& input) {
    std::vector<Vec3f> points(input.vertex_count);
    for (std::size_t v = 0; v < points.size(); ++v)
        for (int axis = 0; axis < 3; ++axis) // + 0: a negative zero is the same place
            points[v][axis] = static_cast<float>(input.vertices[v * 3 + std::size_t(axis)] - input.origin[axis]) + 0.0f;
    std::vector<std::uint32_t> order;
    order.reserve(points.size());
    for (std::uint32_t v = 0; v < points.size(); ++v)
        if (is_finite(points[v]))
            order.push_back(v);
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        const Vec3f &p = points[a], &q = points[b];
        return p.x != q.x ? p.x < q.x : p.y != q.y ? p.y < q.y : p.z != q.z ? p.z < q.z : a < b;
    });
    Welded welded;
    welded.number.assign(points.size(), Welded::kNowhere);
    for (std::uint32_t v : order) {
        if (welded.places.empty() || !(welded.places.back() == points[v]))
            welded.places.push_back(points[v]);
        welded.number[v] = static_cast<std::uint32_t>(welded.places.size() - 1);
    }
    return welded;
}

void add_triangle(antumbra::OccluderSet& set, const std::uint32_t (&corners)[3], bool two_sided) {
    Vec3d a = to_double(set.vertices[corners[0]]), b = to_double(set.vertices[corners[1]]),
          c = to_double(set.vertices[corners[2]]);
    Vec3d normal = cross(b - a, c - a);
    double length = antumbra::length(normal);
    if (!(length > 0) || !std::isfinite(length))
        return;
    antumbra::OccluderPolygon polygon;
    polygon.first = static_cast<std::uint32_t>(set.loops.size());
    polygon.count = 3;
    polygon.double_sided = two_sided;
    polygon.normal = normal / length;
    polygon.offset = -dot(polygon.normal, a);
    polygon.area = length / 2;
    polygon.centre = (a + b + c) / 3.0;
    set.loops.insert(set.loops.end(), corners, corners + 3);
    set.polygons.push_back(polygon);
}

antumbra::OccluderSet occluders(const ant_cull_input& input) {
    Welded welded = weld(input);
    antumbra::OccluderSet set;
    set.vertices = std::move(welded.places);
    for (std::size_t t = 0; t < input.triangle_count; ++t) {
        std::uint32_t corners[3];
        bool is_somewhere = true;
        for (std::size_t i = 0; i < 3; ++i) {
            corners[i] = welded.number[input.triangles[t * 3 + i]];
            is_somewhere = is_somewhere && corners[i] != Welded::kNowhere;
        }
        if (is_somewhere)
            add_triangle(set, corners, input.two_sided && input.two_sided[t] != 0);
    }
    connect_occluders(set);
    group_occluders(set);
    return set;
}

/// "" or what is wrong.
const char* problem_of(const ant_cull_input& input) {
    if (!std::isfinite(input.origin[0]) || !std::isfinite(input.origin[1]) || !std::isfinite(input.origin[2]))
        return "the origin is not finite";
    if ((input.object_count && !input.bounds) || (input.vertex_count && !input.vertices) ||
        (input.triangle_count && !input.triangles))
        return "a needed pointer is NULL";
    if (input.triangle_count >= antumbra::kNoPolygon / 3)
        return "there are too many triangles";
    for (std::size_t i = 0; i < std::size_t(input.triangle_count) * 3; ++i)
        if (input.triangles[i] >= input.vertex_count)
            return "a triangle names a vertex that is not there";
    return "";
}

/// ANT_USAGE for a struct that is shorter than any that was ever published, ANT_UNSUPPORTED for one of a later library.
ant_status check_input_size(std::size_t struct_size, std::size_t known) {
    return struct_size < known ? ANT_USAGE : struct_size > known ? ANT_UNSUPPORTED : ANT_OK;
}

Status wrong_size(ant_status status, const char* where) {
    return {static_cast<ErrorCode>(status), std::string(where) + ": struct_size is not the size of the struct of this "
                                            "version of the library; set it to sizeof the struct, and build with its header"};
}

antumbra::View local_view(const ant_view& view, const Vec3d& origin) {
    antumbra::View result;
    result.projection = view.projection == ANT_ORTHOGRAPHIC ? antumbra::Projection::orthographic
                                                            : antumbra::Projection::perspective;
    result.eye = vector(view.eye) - origin;
    result.target = vector(view.target) - origin;
    result.up = vector(view.up);
    result.fov_y_deg = view.fov_y_deg;
    result.height = view.height;
    result.aspect = view.aspect;
    result.near_plane = view.near_plane;
    result.far_plane = view.far_plane;
    return result;
}

bool is_answered(const ant_cull_state* state) { return state && state->has_answer; }

} // namespace

extern "C" {

ant_status ant_cull_scene_create(const ant_cull_input* input, ant_cull_scene** scene, char* error, size_t error_size) {
    if (scene)
        *scene = nullptr;
    if (!input || !scene)
        return answer({ErrorCode::usage, "ant_cull_scene_create: a needed pointer is NULL"}, error, error_size);
    if (ant_status size = check_input_size(input->struct_size, sizeof(ant_cull_input)); size != ANT_OK)
        return answer(wrong_size(size, "ant_cull_scene_create"), error, error_size);
    if (const char* problem = problem_of(*input); *problem)
        return answer({ErrorCode::usage, std::string("ant_cull_scene_create: ") + problem}, error, error_size);
    std::vector<Box3f> boxes = local_boxes(*input);
    antumbra::OccluderSet set = occluders(*input);
    antumbra::CullSceneInput made;
    made.bounds = boxes;
    made.origin = vector(input->origin);
    made.occluders = &set;
    if (input->flags)
        made.flags = {input->flags, input->object_count};
    *scene = new ant_cull_scene{antumbra::CullScene::create(made)};
    return answer({}, error, error_size);
}

ant_status ant_cull_scene_create_from_pvs(const ant_pvs* pvs, ant_cull_scene** scene, char* error, size_t error_size) {
    if (scene)
        *scene = nullptr;
    if (!pvs || !scene)
        return answer({ErrorCode::usage, "ant_cull_scene_create_from_pvs: a needed pointer is NULL"}, error, error_size);
    Result<antumbra::CullScene> opened = antumbra::CullScene::open(pvs->pvs);
    if (!opened)
        return answer(opened.status(), error, error_size);
    *scene = new ant_cull_scene{std::move(*opened)};
    return answer({}, error, error_size);
}

void ant_cull_scene_destroy(ant_cull_scene* scene) { delete scene; }

ant_status ant_cull_scene_describe(const ant_cull_scene* scene, ant_cull_scene_info* info) {
    if (!scene || !info || info->struct_size < sizeof(ant_cull_scene_info))
        return ANT_USAGE;
    info->object_count = scene->scene.object_count();
    info->occluder_count = static_cast<std::uint32_t>(scene->scene.data().occluders.polygons.size());
    return ANT_OK;
}

ant_status ant_culler_options_init(ant_culler_options* options, size_t size) {
    if (!options || size != sizeof(ant_culler_options))
        return ANT_USAGE;
    antumbra::CullerOptions defaults;
    *options = {sizeof(ant_culler_options), defaults.occluders, static_cast<std::uint32_t>(defaults.raster_width),
                defaults.polygon_budget, defaults.pixels_per_polygon, nullptr};
    return ANT_OK;
}

uint32_t ant_culler_method_count(void) { return static_cast<std::uint32_t>(antumbra::culler_names().size()); }

ant_status ant_culler_read_method(uint32_t index, char* buffer, size_t capacity, size_t* length) {
    if (!length || index >= antumbra::culler_names().size())
        return ANT_USAGE;
    return read_text(antumbra::culler_names()[index], buffer, capacity, length);
}

ant_status ant_culler_create(const ant_cull_scene* scene, const char* method, const ant_culler_options* options,
                             ant_culler** culler, char* error, size_t error_size) {
    if (culler)
        *culler = nullptr;
    if (!scene || !method || !culler)
        return answer({ErrorCode::usage, "ant_culler_create: a needed pointer is NULL"}, error, error_size);
    antumbra::CullerOptions wanted;
    if (options) {
        if (ant_status size = check_input_size(options->struct_size, sizeof(ant_culler_options)); size != ANT_OK)
            return answer(wrong_size(size, "ant_culler_create"), error, error_size);
        wanted.occluders = options->occluders;
        wanted.raster_width = static_cast<int>(std::min(options->raster_width, 0x7FFFFFFFu));
        wanted.polygon_budget = options->polygon_budget;
        wanted.pixels_per_polygon = options->pixels_per_polygon;
        wanted.pvs = options->pvs ? &options->pvs->pvs : nullptr;
    }
    Result<std::unique_ptr<antumbra::Culler>> made = antumbra::make_culler(method, scene->scene, wanted);
    if (!made)
        return answer(made.status(), error, error_size);
    *culler = new ant_culler{std::move(*made), scene->scene};
    return answer({}, error, error_size);
}

void ant_culler_destroy(ant_culler* culler) { delete culler; }

ant_status ant_culler_guarantee(const ant_culler* culler, ant_guarantee* guarantee) {
    if (!culler || !guarantee)
        return ANT_USAGE;
    *guarantee = static_cast<ant_guarantee>(culler->culler->guarantee());
    return ANT_OK;
}

ant_status ant_view_init(ant_view* view, size_t size) {
    if (!view || size != sizeof(ant_view))
        return ANT_USAGE;
    antumbra::View defaults;
    *view = {sizeof(ant_view), ANT_PERSPECTIVE, {}, {}, {}, defaults.fov_y_deg, defaults.height, defaults.aspect,
             defaults.near_plane, defaults.far_plane};
    copy(defaults.eye, view->eye);
    copy(defaults.target, view->target);
    copy(defaults.up, view->up);
    return ANT_OK;
}

ant_status ant_cull_state_create(ant_cull_state** state) {
    if (!state)
        return ANT_USAGE;
    *state = new ant_cull_state;
    return ANT_OK;
}

void ant_cull_state_destroy(ant_cull_state* state) { delete state; }

ant_status ant_culler_cull(const ant_culler* culler, const ant_view* view, ant_cull_state* state) {
    if (!culler || !view || !state)
        return ANT_USAGE;
    if (ant_status size = check_input_size(view->struct_size, sizeof(ant_view)); size != ANT_OK)
        return size;
    int projection; // a caller's number, which may be none of the enumeration's: to read it as such would be undefined
    static_assert(sizeof projection == sizeof view->projection);
    std::memcpy(&projection, &view->projection, sizeof projection);
    if (projection != ANT_PERSPECTIVE && projection != ANT_ORTHOGRAPHIC)
        return ANT_USAGE;
    culler->culler->cull(local_view(*view, culler->scene.data().origin), state->view, state->result);
    state->guarantee = static_cast<ant_guarantee>(culler->culler->guarantee());
    if (state->result.everything)
        state->guarantee = ANT_CONSERVATIVE;
    state->objects = culler->scene.object_count();
    state->has_answer = true;
    return ANT_OK;
}

ant_status ant_cull_state_describe(const ant_cull_state* state, ant_cull_answer* answer) {
    if (!is_answered(state) || !answer || answer->struct_size < sizeof(ant_cull_answer))
        return ANT_USAGE;
    const antumbra::CullResult& result = state->result;
    const antumbra::CullCounters& counters = result.counters;
    *answer = {answer->struct_size, state->guarantee, result.everything ? 1 : 0, result.reason, state->objects,
               result.visible_count, counters.boxes_tested, counters.outside_frustum, counters.hidden_by_pvs,
               counters.hidden_by_last + counters.hidden_by_planes + counters.hidden_by_raster,
               counters.occluders_used + counters.polygons_drawn};
    return ANT_OK;
}

ant_status ant_cull_state_read_ids(const ant_cull_state* state, uint32_t* ids, size_t capacity, size_t* count) {
    if (!is_answered(state) || !count)
        return ANT_USAGE;
    return read_ids(state->result.visible, state->result.visible_count, ids, capacity, count);
}

ant_status ant_cull_state_read_bits(const ant_cull_state* state, uint8_t* bytes, size_t capacity, size_t* count) {
    if (!is_answered(state) || !count)
        return ANT_USAGE;
    return read_bits(state->result.visible, state->objects, bytes, capacity, count);
}

ant_status ant_cull_state_sees(const ant_cull_state* state, uint32_t object, int* visible) {
    if (!is_answered(state) || !visible || object >= state->objects)
        return ANT_USAGE;
    *visible = state->result.is_visible(object) ? 1 : 0;
    return ANT_OK;
}

ant_status ant_cull_state_read_changes(ant_cull_state* state, uint32_t* shown, size_t shown_capacity, size_t* shown_count,
                                       uint32_t* hidden, size_t hidden_capacity, size_t* hidden_count) {
    if (!is_answered(state))
        return ANT_USAGE;
    return state->told.read(state->result.visible, state->objects, shown, shown_capacity, shown_count, hidden,
                            hidden_capacity, hidden_count);
}

} // extern "C"
