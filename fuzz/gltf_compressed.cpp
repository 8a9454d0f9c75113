// Draco and meshopt streams within a sound glTF: the input is the stream, its first bytes say how it is declared.
#include "whole_path.hpp"

#include <nlohmann/json.hpp>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace antumbra;
    using Json = nlohmann::json;
    if (size < 8)
        return 0;
    bool draco = data[0] & 1;
    unsigned mode = data[1] % 3, filter = data[2] % 4, stride = data[3], vertices = data[4] | data[5] << 8,
             corners = data[6] | data[7] << 8;
    std::string binary(reinterpret_cast<const char*>(data) + 8, size - 8);
    auto packed = [&](const char* kind, unsigned bytes, unsigned count) -> Json {
        const char* filters[] = {"NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL"};
        return {{"buffer", 0}, {"byteLength", std::uint64_t(bytes) * count},
                {"extensions", {{"EXT_meshopt_compression", {{"buffer", 0}, {"byteLength", binary.size()},
                    {"byteStride", bytes}, {"count", count}, {"mode", kind}, {"filter", filters[filter]}}}}}};
    };
    Json json = {{"asset", {{"version", "2.0"}}},
                 {"nodes", Json::array({{{"mesh", 0}}})},
                 {"buffers", Json::array({{{"byteLength", binary.size()}}})}};
    Json primitive = {{"attributes", {{"POSITION", 0}}}};
    Json positions = {{"componentType", 5126}, {"type", "VEC3"}, {"count", vertices}};
    Json indices = {{"componentType", 5125}, {"type", "SCALAR"}, {"count", corners}};
    if (draco) {
        json["bufferViews"] = Json::array({{{"buffer", 0}, {"byteLength", binary.size()}}});
        primitive["indices"] = 1;
        primitive["extensions"]["KHR_draco_mesh_compression"] = {{"bufferView", 0}, {"attributes", {{"POSITION", 0}}}};
    } else if (mode == 0) {
        json["bufferViews"] = Json::array({packed("ATTRIBUTES", stride, vertices)});
        positions["bufferView"] = 0;
    } else {
        // Zeros as positions, so that decoded indices meet them.
        json["bufferViews"] = Json::array({packed(mode == 1 ? "TRIANGLES" : "INDICES", stride & 1 ? 2 : 4, corners)});
        indices["componentType"] = stride & 1 ? 5123 : 5125;
        indices["bufferView"] = 0;
        primitive["indices"] = 1;
    }
    json["accessors"] = Json::array({positions, indices});
    json["meshes"] = Json::array({{{"primitives", Json::array({primitive})}}});
    std::string text = json.dump(), glb = "glTF";
    text.resize((text.size() + 3) / 4 * 4, ' ');
    auto put = [&](std::size_t value) {
        for (int i = 0; i < 4; ++i)
            glb += static_cast<char>(value >> (8 * i) & 0xFF);
    };
    put(2);
    put(28 + text.size() + binary.size());
    put(text.size());
    glb += "JSON" + text;
    put(binary.size());
    glb += std::string("BIN\0", 4) + binary;
    fuzz::go_on_with(import_gltf(std::as_bytes(std::span(glb.data(), glb.size())), "fuzz.glb", "", fuzz::small_limits()));
    return 0;
}
