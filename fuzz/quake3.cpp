// Quake III maps; the reference is asked, too.
#include "whole_path.hpp"

#include <antumbra/quake3.hpp>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace antumbra;
    ImportOptions options = fuzz::small_limits();
    options.patch_levels = size % 5 + 1;
    Result<Quake3Map> map = import_quake3(std::as_bytes(std::span(data, size)), "fuzz.bsp", options);
    if (!map)
        return 0;
    const Quake3Reference& reference = map->reference;
    for (double x : {-1e9, 0.0, 5.0}) {
        std::int32_t leaf = reference.leaf_of({x, 1, 2});
        if (leaf >= 0)
            (void)reference.cluster_sees(reference.leaves[std::size_t(leaf)].cluster, 0);
    }
    fuzz::go_on_with(std::move(map->scene));
    return 0;
}
