// OBJ text; what follows a form feed is its material library, as if it lay beside it.
#include "whole_path.hpp"

#include "import/obj_materials.hpp"

#include <algorithm>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace antumbra;
    const std::uint8_t* end = std::find(data, data + size, std::uint8_t('\f'));
    std::span<const std::byte> text = std::as_bytes(std::span(data, end));
    ObjMaterials materials;
    materials.read(std::as_bytes(std::span(end, data + size)));
    (void)materials.see_through("a");
    fuzz::go_on_with(import_obj(text, "fuzz.obj", "", fuzz::small_limits()));
    return 0;
}
