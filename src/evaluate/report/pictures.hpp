// Pictures of chosen frames with culling off and on.
#pragma once

#include "evaluate/gl/drawing.hpp"
#include "rays/tracer.hpp"

#include <antumbra/evaluate.hpp>

#include <optional>
#include <string>
#include <vector>

namespace antumbra {

/// One frame as one method shows it. Pictures only where they differ from the one without culling.
struct MethodPicture {
    std::uint64_t differing_pixels = 0;
    std::optional<Image> on, difference;
};

struct FramePictures {
    std::uint32_t frame = 0;
    std::string why; ///< what makes the frame worth a look
    Image off;
    std::vector<MethodPicture> methods; ///< as WalkResult::methods
};

/// The notable frames of a walk, drawn with OpenGL, or, where there is none, shaded from rays (then what a method loses
/// is painted, not drawn).
std::vector<FramePictures> make_pictures(const Tracer& tracer, const WalkResult& result, const Job& job);

} // namespace antumbra
