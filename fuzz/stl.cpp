#include "whole_path.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace antumbra;
    fuzz::go_on_with(import_stl(std::as_bytes(std::span(data, size)), "fuzz.stl", fuzz::small_limits()));
    return 0;
}
