#include "whole_path.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace antumbra;
    fuzz::go_on_with(import_ply(std::as_bytes(std::span(data, size)), "fuzz.ply", fuzz::small_limits()));
    return 0;
}
