// The formats that go through assimp; the first byte chooses one. A crash inside of assimp is assimp's (report it
// there and, if it lasts, take the format from the list); a crash outside is ours.
#include "whole_path.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace antumbra;
    const char* endings[] = {"off", "dae", "3ds", "fbx"};
    if (size == 0)
        return 0;
    fuzz::go_on_with(import_with_assimp(std::as_bytes(std::span(data + 1, size - 1)), endings[data[0] % 4], "fuzz",
                                        fuzz::small_limits()));
    return 0;
}
