// Two rooms side by side with a closed wall between them, and a file about them made by hand.
#pragma once

#include "support/make_scene.hpp"

#include <antumbra/pvs.hpp>

namespace antumbra::test {

/// [-4,0] and [0,4] along x; objects: left room, right room, left crate, right crate.
inline SceneMaker two_rooms() {
    SceneMaker maker;
    maker.object("left room").box({-4, 0, 0}, {-0.25, 3, 4}, true);
    maker.object("right room").box({0.25, 0, 0}, {4, 3, 4}, true);
    maker.object("left crate").box({-3, 0, 1}, {-2, 1, 2});
    maker.object("right crate").box({2, 0, 1}, {3, 1, 2});
    return maker;
}

/// One cell per room. Row 0 lists the left objects, row 1 the right ones.
inline PvsData two_cells(const Scene& scene, Guarantee guarantee = Guarantee::conservative) {
    PvsData data;
    data.guarantee = guarantee;
    data.method = "by hand";
    data.tool_version = "test";
    data.options_json = std::string("{}");
    data.scene_fingerprint = scene.fingerprint();
    data.structure_fingerprint = scene.structure_fingerprint();
    data.sides = std::uint8_t(scene.sides());
    data.origin = scene.origin();
    data.grid.bounds = {{-4, 0, 0}, {4, 3, 4}};
    data.grid.count = {2, 1, 1};
    data.cell_row = {0, 1};
    for (std::uint32_t o = 0; o < scene.objects().size(); ++o) {
        PvsObject object;
        object.node = std::int32_t(o);
        object.flags = scene.objects()[o].flags;
        object.triangle_count = scene.objects()[o].triangle_count;
        object.bounds = scene.objects()[o].bounds;
        object.name = std::string(scene.name(o));
        data.objects.push_back(object);
    }
    data.row_count = 2;
    data.rows = {0b0101, 0b1010};
    return data;
}

/// An opened file together with its bytes.
struct OpenFile {
    std::vector<std::byte> bytes;
    std::optional<Pvs> pvs;

    explicit OpenFile(const PvsData& data) {
        auto encoded = encode_pvs(data);
        EXPECT_TRUE(encoded) << encoded.status().message();
        bytes = std::move(*encoded);
        auto opened = Pvs::open(bytes);
        EXPECT_TRUE(opened) << opened.status().message();
        pvs.emplace(std::move(*opened));
    }
};

} // namespace antumbra::test
