// A walk's figures as JSON: the same words on the command line and in the report.
#pragma once

#include <antumbra/evaluate.hpp>

#include <nlohmann/json.hpp>

namespace antumbra {

/// null where a figure was not measured (negative).
inline nlohmann::ordered_json figure_json(double value) {
    return value < 0 ? nlohmann::ordered_json(nullptr) : nlohmann::ordered_json(value);
}

/// One method: its guarantee, times, what it drew and what it got wrong.
inline nlohmann::ordered_json method_json(const WalkMethod& method, const WalkResult& result) {
    return {{"name", method.name},
            {"guarantee", to_string(method.guarantee)},
            {"cull_ms", {{"median", figure_json(method.cull_ms_median)}, {"p99", figure_json(method.cull_ms_p99)}}},
            {"draw_ms", {{"median", figure_json(method.draw_ms_median)}}},
            {"frame_ms", {{"median", figure_json(method.frame_ms_median)}}},
            {"objects_reported", method.objects_reported},
            {"objects_true", result.objects_true},
            {"triangles_drawn", method.triangles_drawn},
            {"culled_of_frustum", method.culled_of_frustum},
            {"false_visible_objects", method.false_visible_objects},
            {"false_invisible_objects", method.false_invisible_objects},
            {"false_invisible_pixels", method.false_invisible_pixels},
            {"grazing_pixels", method.grazing_pixels},
            {"unconfirmed_pixels", method.unconfirmed_pixels},
            {"speedup_over_frustum", figure_json(method.speedup_over_frustum)}};
}

} // namespace antumbra
