#include "generate/laws.hpp"

#include "generate/modeller.hpp"

#include <fstream>

namespace antumbra {
namespace {

std::span<const std::byte> bytes_of(const std::string& text) {
    return std::as_bytes(std::span(text));
}

TEST(Sha256, agrees_with_the_examples_of_its_standard) {
    EXPECT_EQ(test::Sha256::hex({}), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
    EXPECT_EQ(test::Sha256::hex(bytes_of("abc")),
              "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    EXPECT_EQ(test::Sha256::hex(bytes_of("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq")),
              "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
}

TEST(Generate, an_unknown_kind_is_wrong_usage_and_lists_the_known_ones) {
    Result<RawScene> scene = generate("castle");
    ASSERT_FALSE(scene.ok());
    EXPECT_EQ(scene.status().code(), ErrorCode::usage);
    for (std::string_view name : generator_names())
        EXPECT_NE(scene.status().message().find(name), std::string::npos) << name;
}

TEST(Generate, names_are_in_alphabetical_order) {
    EXPECT_TRUE(std::is_sorted(generator_names().begin(), generator_names().end()));
}

TEST(Generate, the_hashes_in_the_documentation_are_those_of_the_tests) {
    std::ifstream file(ANTUMBRA_SOURCE_DIR "/docs/scenes.md");
    std::string text{std::istreambuf_iterator<char>(file), {}};
    for (auto [arguments, hash] : test::kPublished) {
        std::size_t row = text.find("| `" + std::string(arguments) + "` |");
        ASSERT_NE(row, std::string::npos) << arguments;
        std::size_t end = text.find('\n', row);
        EXPECT_NE(text.substr(row, end - row).find(hash), std::string::npos) << arguments;
    }
}

TEST(Sine, is_exact_at_quarter_turns_and_right_elsewhere) {
    using namespace generation;
    EXPECT_EQ(sine(0), 0);
    EXPECT_EQ(sine(0.25), 1);
    EXPECT_EQ(sine(0.5), 0);
    EXPECT_EQ(sine(0.75), -1);
    EXPECT_EQ(cosine(-0.25), 0);
    EXPECT_EQ(cosine(7), 1);
    for (int i = -1000; i <= 1000; ++i) {
        double turns = i / 770.0;
        EXPECT_NEAR(sine(turns), std::sin(turns * 2 * 3.14159265358979323846), 1e-14);
        EXPECT_NEAR(cosine(turns), std::cos(turns * 2 * 3.14159265358979323846), 1e-14);
    }
}

TEST(Frame, turning_by_a_quarter_lets_z_look_along_x) {
    generation::Frame frame = generation::turned({1, 2, 3}, 0.25);
    EXPECT_EQ(frame.apply({0, 0, 5}), (Vec3d{6, 2, 3}));
    EXPECT_EQ(frame.apply({5, 0, 0}), (Vec3d{1, 2, -2}));
}

/// Each solid of the workshop with the triangles and the volume (times six) that it must have.
TEST(Modeller, solids_are_closed_wound_outward_and_have_the_promised_triangles) {
    using namespace generation;
    Modeller modeller("test");
    std::vector<std::pair<std::uint32_t, double>> wanted;
    auto begin = [&](std::uint32_t triangles, double volume) {
        modeller.begin("solid " + std::to_string(wanted.size()));
        modeller.place(turned({3, 4, 5}, 0.25));
        wanted.emplace_back(triangles, volume * 6);
    };
    begin(12, 6);
    modeller.box({0, 0, 0}, {1, 2, 3});
    for (Axis axis : {Axis::x, Axis::y, Axis::z}) {
        begin(28, 8 * 8 * 8 - 6 * 6 * 7);
        modeller.open_box({0, 0, 0}, {8, 8, 8}, 1, axis);
        begin(32, (4 * 5 - 1 * 2) * 3);
        modeller.ring(axis, {0, 0}, {4, 5}, {1, 1}, {2, 3}, 1, 4);
        Vec2 bracket[] = {{0, 0}, {1, 0}, {1, 2}, {2, 2}, {2, 0}, {3, 0}, {3, 3}, {0, 3}};
        begin(28, 7 * 2);
        modeller.extrude(axis, bracket, 0, 2);
        Vec2 square[] = {{1, 1}, {-1, 1}, {-1, -1}, {1, -1}};
        begin(16, 4 * 2);
        modeller.star(axis, square, 0, 2);
        begin(12, 2 * 3); // a square of radius 1 has area 2
        modeller.cylinder(axis, 1.4142135623730951, 0, 1.5, 4);
        Vec2 cone[] = {{1.4142135623730951, 0}, {0, 3}};
        begin(6, 4);
        modeller.lathe(axis, cone, 4);
        Vec2 top[] = {{0, 0}, {1.4142135623730951, 3}, {0, 6}};
        begin(8, 8);
        modeller.lathe(axis, top, 4);
    }
    begin(8, 4.0 / 3);
    modeller.octahedron({0, 0, 0}, {1, 1, 1});
    begin(20, 16); // a square tube of radius sqrt 2 has an area of 4, the path is 4 long
    Vec3d path[] = {{0, 0, 0}, {0, 1, 0}, {0, 4, 0}};
    double radius[] = {1.4142135623730951};
    modeller.tube(path, radius, 4);
    RawScene scene = modeller.finish();
    ASSERT_EQ(scene.objects.size(), wanted.size());
    for (std::size_t i = 0; i < wanted.size(); ++i) {
        EXPECT_EQ(scene.objects[i].triangle_count, wanted[i].first) << i;
        EXPECT_EQ(test::open_edges(scene, scene.objects[i]), 0u) << i;
        EXPECT_NEAR(test::volume(scene, scene.objects[i]), wanted[i].second, 0.02) << i;
    }
}

} // namespace
} // namespace antumbra
