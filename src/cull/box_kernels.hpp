// Eight boxes against the planes of a view volume. All kernels do the same operations in the same order on each
// lane, without fused multiply-add: their answers are identical bit for bit.
#pragma once

#include "cull/scene_data.hpp"
#include "cull/view_planes.hpp"

namespace antumbra {

struct EightBoxes {
    const float (*min)[kWidth];
    const float (*max)[kWidth];
};

struct BoxVerdicts {
    std::uint32_t outside = 0;           ///< bit per box: certainly beyond one of the planes
    std::uint32_t crossing[kWidth];      ///< per box: bits of the planes (of `active`) that it may cross
};

/// `active`: bits of the planes to test.
using BoxKernel = void (*)(const EightBoxes& boxes, const FrustumPlanes& planes, std::uint32_t active,
                           BoxVerdicts& verdicts);

void test_boxes_scalar(const EightBoxes& boxes, const FrustumPlanes& planes, std::uint32_t active,
                       BoxVerdicts& verdicts);

/// The kernel for an instruction set; nullptr if the processor lacks it.
BoxKernel box_kernel(InstructionSet instruction_set);

} // namespace antumbra
