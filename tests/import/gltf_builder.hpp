// Builds small glTF files in memory for the tests of the reader.
#pragma once

#include <nlohmann/json.hpp>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <vector>

namespace antumbra::test {

using Json = nlohmann::json;

inline std::span<const std::byte> bytes_of(const std::string& text) {
    return std::as_bytes(std::span(text.data(), text.size()));
}

template <class T>
constexpr int component_code() {
    if constexpr (std::is_same_v<T, float>)
        return 5126;
    else if constexpr (sizeof(T) == 1)
        return std::is_signed_v<T> ? 5120 : 5121;
    else if constexpr (sizeof(T) == 2)
        return std::is_signed_v<T> ? 5122 : 5123;
    else
        return 5125;
}

/// `json` is open to every edit; the helpers append to its arrays and to the binary chunk.
struct GltfBuilder {
    Json json = {{"asset", {{"version", "2.0"}}}};
    std::string binary;

    template <class T>
    int add_view(const std::vector<T>& values) {
        binary.resize((binary.size() + 3) / 4 * 4);
        json["bufferViews"].push_back(
            {{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", values.size() * sizeof(T)}});
        binary.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
        return static_cast<int>(json["bufferViews"].size()) - 1;
    }

    template <class T>
    int add_accessor(const std::string& type, const std::vector<T>& values, bool normalized = false) {
        std::size_t width = type == "SCALAR" ? 1 : static_cast<std::size_t>(type.back() - '0');
        Json accessor = {{"bufferView", add_view(values)},
                         {"componentType", component_code<T>()},
                         {"count", values.size() / width},
                         {"type", type}};
        if (normalized)
            accessor["normalized"] = true;
        json["accessors"].push_back(accessor);
        return static_cast<int>(json["accessors"].size()) - 1;
    }

    int add(const char* array, Json element) {
        json[array].push_back(std::move(element));
        return static_cast<int>(json[array].size()) - 1;
    }

    int add_mesh(int position, int indices = -1, int material = -1, int mode = -1) {
        Json primitive = {{"attributes", {{"POSITION", position}}}};
        if (indices >= 0)
            primitive["indices"] = indices;
        if (material >= 0)
            primitive["material"] = material;
        if (mode >= 0)
            primitive["mode"] = mode;
        return add("meshes", {{"primitives", Json::array({primitive})}});
    }

    /// A mesh of one triangle (0,0,0) (1,0,0) (0,1,0), facing +z.
    int add_triangle_mesh(int material = -1) {
        return add_mesh(add_accessor<float>("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0}), -1, material);
    }

    std::string gltf() const {
        Json whole = json;
        if (!binary.empty() && !whole.contains("buffers"))
            whole["buffers"] = Json::array({{{"byteLength", binary.size()}}});
        return whole.dump();
    }

    std::string glb() const {
        auto u32 = [](std::size_t value) {
            std::string text(4, '\0');
            for (std::size_t i = 0; i < 4; ++i)
                text[i] = static_cast<char>(value >> (8 * i) & 0xFF);
            return text;
        };
        std::string text = gltf(), data = binary;
        text.resize((text.size() + 3) / 4 * 4, ' ');
        data.resize((data.size() + 3) / 4 * 4, '\0');
        std::string body = u32(text.size()) + "JSON" + text;
        if (!data.empty())
            body += u32(data.size()) + std::string("BIN\0", 4) + data;
        return "glTF" + u32(2) + u32(12 + body.size()) + body;
    }
};

} // namespace antumbra::test
