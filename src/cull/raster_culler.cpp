#include "cull/raster_culler.hpp"

namespace antumbra {

RasterKernels raster_kernels(InstructionSet set) {
    RasterKernels kernels{{box_kernel(set), nullptr}, nullptr, nullptr};
    if (set == InstructionSet::avx512 || set == InstructionSet::automatic) {
        kernels.draw = draw_patch_avx512();
        kernels.hidden = is_hidden_avx512();
        kernels.walk.project = project_eight_avx512();
    }
    if (set == InstructionSet::avx2 || (set == InstructionSet::automatic && !kernels.draw)) {
        kernels.draw = draw_patch_avx2();
        kernels.hidden = is_hidden_avx2();
        kernels.walk.project = project_eight_avx2();
    }
    if (set == InstructionSet::scalar || (set == InstructionSet::automatic && !kernels.draw)) {
        kernels.draw = draw_patch_scalar;
        kernels.hidden = is_hidden_scalar;
        kernels.walk.project = project_eight_scalar;
    }
    return kernels;
}

} // namespace antumbra
