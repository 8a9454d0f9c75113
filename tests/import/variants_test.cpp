// One model in five forms - plain, quantised, meshopt, Draco, instanced - as the usual tools write them: they must
// give the same scene, within the quantisation.
#include <antumbra/import.hpp>

#include "import/gltf_builder.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace antumbra {
namespace {

using test::GltfBuilder;
using test::Json;
namespace fs = std::filesystem;

/// Of the tools of tools/gltf, which tools/setup installs.
fs::path tool(const char* name) { return fs::path(ANTUMBRA_SOURCE_DIR) / "tools/gltf/node_modules/.bin" / name; }

/// Eight copies of a bumpy dome and one mirrored wall, under a turned and scaled parent.
std::string model() {
    GltfBuilder b;
    b.json["scene"] = 0;
    std::vector<float> positions;
    std::vector<std::uint16_t> indices;
    constexpr int n = 10;
    for (int y = 0; y <= n; ++y)
        for (int x = 0; x <= n; ++x) {
            float u = float(x) / n - 0.5f, v = float(y) / n - 0.5f;
            positions.insert(positions.end(), {u, 0.5f - u * u - v * v + 0.03f * float((x * 3 + y * 5) % 4), v});
        }
    for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x)
            for (int i : {0, n + 1, 1, 1, n + 1, n + 2})
                indices.push_back(std::uint16_t(y * (n + 1) + x + i));
    b.add("materials", {{"name", "stone"}});
    int dome = b.add_mesh(b.add_accessor("VEC3", positions), b.add_accessor("SCALAR", indices), 0);
    int wall = b.add_mesh(b.add_accessor<float>("VEC3", {-4, 0, 0, 4, 0, 0, -4, 2, 0.5f, 4, 2, 0}),
                          b.add_accessor<std::uint16_t>("SCALAR", {0, 1, 2, 2, 1, 3}), 0);
    std::vector<int> children;
    for (int i = 0; i < 8; ++i)
        children.push_back(b.add("nodes", {{"mesh", dome}, {"name", "dome " + std::to_string(i)},
                                           {"translation", {i * 1.5 - 5, 0.1 * i, i % 3}},
                                           {"rotation", {0, std::sin(0.2 * i), 0, std::cos(0.2 * i)}},
                                           {"scale", {1, 1 + 0.1 * i, 1}}}));
    children.push_back(b.add("nodes", {{"mesh", wall}, {"name", "wall"}, {"scale", {-1, 1, 1}}}));
    int root = b.add("nodes", {{"children", children}, {"translation", {3, 0, 1}}, {"scale", {2, 2, 2}}});
    b.json["scenes"] = Json::array({{{"nodes", {root}}}});
    return b.glb();
}

struct Corner3 {
    Vec3d centroid, normal;
};

std::vector<Corner3> triangles_of(const RawScene& raw) {
    std::vector<Corner3> all;
    for (const TriangleIndices& t : raw.triangles) {
        const Vec3d &a = raw.positions[t[0]], &b = raw.positions[t[1]], &c = raw.positions[t[2]];
        all.push_back({(a + b + c) / 3, cross(b - a, c - a) * 0.5});
    }
    return all;
}

class Variants : public ::testing::Test {
  protected:
    Variants() {
        folder_ = fs::temp_directory_path() / ("antumbra-variants-" + std::to_string(::getpid()));
        fs::create_directories(folder_);
        std::ofstream(folder_ / "plain.glb", std::ios::binary) << model();
        plain_ = *import_file((folder_ / "plain.glb").string());
    }
    ~Variants() override { fs::remove_all(folder_); }

    void SetUp() override {
        if (!fs::exists(tool("gltf-transform")) || !fs::exists(tool("gltfpack")))
            GTEST_SKIP() << "no gltf-transform or gltfpack; tools/setup installs them (npm ci in tools/gltf)";
    }

    /// Runs `arguments` and compares what it wrote with the plain model: as many triangles, and for each of ours one
    /// whose centroid and area vector are as near as `tolerance`.
    void expect_same(const std::string& arguments, const char* extension, double tolerance) {
        std::string output = (folder_ / "variant.glb").string();
        std::string command = arguments;
        for (const auto& [from, to] : {std::pair<std::string, std::string>{"IN", (folder_ / "plain.glb").string()}, {"OUT", output}})
            command.replace(command.find(from), from.size(), to);
        ASSERT_EQ(std::system((command + " > " + (folder_ / "log").string() + " 2>&1").c_str()), 0) << command;
        std::ifstream file(output, std::ios::binary);
        std::string text{std::istreambuf_iterator<char>(file), {}};
        ASSERT_NE(text.find(extension), std::string::npos) << "the tool did not do what is tested: " << command;
        Result<RawScene> raw = import_file(output);
        ASSERT_TRUE(raw.ok()) << raw.status().message();
        ASSERT_EQ(raw->triangles.size(), plain_.triangles.size());
        EXPECT_EQ(raw->objects.size(), plain_.objects.size());
        std::vector<Corner3> mine = triangles_of(plain_), theirs = triangles_of(*raw);
        double worst = 0;
        for (const Corner3& t : mine) {
            double best = INFINITY;
            // A corner that is off by e changes the area vector by e times an edge.
            double edge = std::max(1.0, std::sqrt(2 * length(t.normal)));
            for (const Corner3& other : theirs)
                best = std::min(best, std::max(length(t.centroid - other.centroid),
                                               length(t.normal - other.normal) / edge));
            worst = std::max(worst, best);
        }
        EXPECT_LT(worst, tolerance) << command;
        EXPECT_TRUE(Scene::create(std::move(*raw)).ok());
    }

    fs::path folder_;
    RawScene plain_;
};

TEST_F(Variants, PlainIsWhatWasBuilt) {
    EXPECT_EQ(plain_.objects.size(), 9u);
    EXPECT_EQ(plain_.triangles.size(), 8u * 200 + 2);
}

// The model is 30 units long, its meshes up to 16: fourteen bits of that are 0.001.
TEST_F(Variants, Quantised) {
    expect_same(tool("gltf-transform").string() + " quantize IN OUT", "KHR_mesh_quantization", 3e-3);
    expect_same(tool("gltfpack").string() + " -kn -i IN -o OUT", "KHR_mesh_quantization", 3e-3);
}

TEST_F(Variants, Meshopt) {
    expect_same(tool("gltf-transform").string() + " meshopt IN OUT", "EXT_meshopt_compression", 3e-3);
    expect_same(tool("gltfpack").string() + " -kn -c -i IN -o OUT", "EXT_meshopt_compression", 3e-3);
    expect_same(tool("gltfpack").string() + " -kn -cc -vpf -i IN -o OUT", "EXT_meshopt_compression", 3e-3);
}

TEST_F(Variants, Draco) {
    expect_same(tool("gltf-transform").string() + " draco IN OUT", "KHR_draco_mesh_compression", 3e-3);
    expect_same(tool("gltf-transform").string() + " draco --method sequential IN OUT", "KHR_draco_mesh_compression", 3e-3);
}

TEST_F(Variants, Instanced) {
    expect_same(tool("gltf-transform").string() + " instance IN OUT", "EXT_mesh_gpu_instancing", 1e-4);
    expect_same(tool("gltfpack").string() + " -mi -c -i IN -o OUT", "EXT_mesh_gpu_instancing", 3e-3);
}

} // namespace
} // namespace antumbra
