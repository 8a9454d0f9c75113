// Builds a small Quake III map in memory.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <string>
#include <vector>

namespace antumbra::test {

/// Words of the lumps, open to every edit. As built: a floor (polygon), an arch (patch), a flare, a hidden (NODRAW)
/// wall, a pane of glass, and a lift (model 1) that stands at (100, 200, 300).
struct Quake3Builder {
    using Words = std::vector<std::uint32_t>;
    std::array<Words, 17> lumps;
    std::string entities = "{ \"classname\" \"worldspawn\" }\n{ \"model\" \"*1\" \"origin\" \"100 200 300\" }\n";
    std::uint32_t version = 46;

    static std::uint32_t word(float value) { return std::bit_cast<std::uint32_t>(value); }

    void add_shader(std::string name, std::uint32_t surface_flags, std::uint32_t contents) {
        name.resize(64, '\0');
        for (std::size_t i = 0; i < 64; i += 4)
            lumps[1].push_back(std::uint32_t(std::uint8_t(name[i])) | std::uint32_t(std::uint8_t(name[i + 1])) << 8 |
                               std::uint32_t(std::uint8_t(name[i + 2])) << 16 |
                               std::uint32_t(std::uint8_t(name[i + 3])) << 24);
        lumps[1].insert(lumps[1].end(), {surface_flags, contents});
    }
    void add_vertex(float x, float y, float z) {
        lumps[10].insert(lumps[10].end(), {word(x), word(y), word(z)});
        lumps[10].resize(lumps[10].size() + 8);
    }
    void add_surface(std::uint32_t shader, std::uint32_t type, std::uint32_t vertex, std::uint32_t vertices,
                     std::uint32_t index, std::uint32_t indices, std::uint32_t width = 0, std::uint32_t height = 0) {
        Words surface(26);
        surface[0] = shader;
        surface[2] = type;
        surface[3] = vertex;
        surface[4] = vertices;
        surface[5] = index;
        surface[6] = indices;
        surface[24] = width;
        surface[25] = height;
        lumps[13].insert(lumps[13].end(), surface.begin(), surface.end());
    }

    Quake3Builder() {
        add_shader("textures/stone", 0, 1);
        add_shader("textures/caulk", 0x80, 1);
        add_shader("textures/glass", 0, 0x20000001);
        for (auto [x, y] : {std::pair{0.f, 0.f}, {0.f, 8.f}, {8.f, 8.f}, {8.f, 0.f}})
            add_vertex(x, y, 0);
        lumps[11] = {0, 1, 2, 0, 2, 3};
        // Control points of an arch over x, straight along y.
        for (float y : {0.f, 4.f, 8.f})
            for (auto [x, z] : {std::pair{0.f, 0.f}, {4.f, 8.f}, {8.f, 0.f}})
                add_vertex(x, y, z);
        add_surface(0, 1, 0, 4, 0, 6);
        add_surface(0, 2, 4, 9, 0, 0, 3, 3);
        add_surface(0, 4, 0, 0, 0, 0);
        add_surface(1, 1, 0, 4, 0, 6);
        add_surface(2, 3, 0, 4, 0, 6);
        add_surface(0, 1, 0, 4, 0, 6);
        lumps[2] = {word(1), word(0), word(0), word(4)};           // plane x = 4
        lumps[3] = {0, 0xFFFFFFFFu, 0xFFFFFFFEu, 0, 0, 0, 0, 0, 0}; // in front leaf 0, behind leaf 1
        lumps[4] = {0, 0, 4, 0, 0, 8, 8, 8, 0, 2, 0, 1,            // cluster 0, surfaces 0 .. 1, brush 0
                    1, 0, 0, 0, 0, 4, 8, 8, 2, 1, 1, 0};
        lumps[5] = {0, 1, 4};
        lumps[6] = {0};
        lumps[7] = {0, 0, 0, 0, 0, 0, 0, 5, 0, 1, 0, 0, 0, 0, 0, 0, 5, 1, 1, 0};
        lumps[8] = {0, 1, 0};
        lumps[9] = {0, 0};
        lumps[16] = {2, 1, 0x0301}; // two clusters: 0 sees itself, 1 sees both
    }

    std::string file() const {
        std::string directory = "IBSP", body;
        auto put = [](std::string& text, std::uint32_t value) {
            for (int i = 0; i < 4; ++i)
                text += static_cast<char>(value >> (8 * i) & 0xFF);
        };
        put(directory, version);
        for (std::size_t lump = 0; lump < 17; ++lump) {
            put(directory, std::uint32_t(8 + 8 * 17 + body.size()));
            std::size_t before = body.size();
            if (lump == 0)
                body += entities;
            for (std::uint32_t w : lumps[lump])
                put(body, w);
            put(directory, std::uint32_t(body.size() - before));
            body.resize((body.size() + 3) / 4 * 4);
        }
        return directory + body;
    }
};

} // namespace antumbra::test
