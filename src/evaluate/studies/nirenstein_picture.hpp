// Figure 5 of Nirenstein, Blake and Gain 2002: a cell, and what is visible from it.
#pragma once

#include "rays/tracer.hpp"

#include <antumbra/study.hpp>

namespace antumbra {

/// The scene from above with the cell (local) in yellow, the triangles in `visible` (a bit set) in green, all others in red; as
/// a picture and as a drawing.
Result<StudyPicture> seen_from_cell(const Tracer& tracer, const Box3d& cell, const std::vector<std::uint64_t>& visible,
                                    const StudyOptions& options, const Job& job);

} // namespace antumbra
