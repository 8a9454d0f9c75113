// The development scenes, if they are there: object and triangle counts as their collector counted them.
#include <antumbra/import.hpp>

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

namespace antumbra {
namespace {

namespace fs = std::filesystem;

fs::path scenes_folder() {
    const char* named = std::getenv("ANTUMBRA_SCENES");
    return named ? fs::path(named) : fs::path(ANTUMBRA_SOURCE_DIR) / ".." / "shared" / "scenes";
}

struct Expected {
    const char* file;
    std::size_t objects;   ///< (node, primitive) pairs, or groups that have faces
    std::size_t nodes;     ///< as the collector counts objects
    std::size_t triangles; ///< degenerate ones included
};

class SharedScene : public ::testing::TestWithParam<Expected> {};

TEST_P(SharedScene, HasAllObjectsAndTriangles) {
    fs::path path = scenes_folder() / GetParam().file;
    if (!fs::exists(path))
        GTEST_SKIP() << path << " is not on this machine";
    Result<RawScene> raw = import_file(path.string());
    ASSERT_TRUE(raw.ok()) << raw.status().message();
    EXPECT_EQ(raw->objects.size(), GetParam().objects);
    EXPECT_EQ(raw->triangles.size(), GetParam().triangles);
    std::vector<std::int32_t> nodes;
    for (const RawObject& object : raw->objects)
        nodes.push_back(object.id.node);
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    EXPECT_EQ(nodes.size(), GetParam().nodes);
    Result<Scene> scene = Scene::create(std::move(*raw));
    ASSERT_TRUE(scene.ok()) << scene.status().message();
    EXPECT_EQ(scene->objects().size(), GetParam().objects);
}

INSTANTIATE_TEST_SUITE_P(
    All, SharedScene,
    ::testing::Values(Expected{"interior/ravenbridge_mansion.glb", 780, 525, 275132},
                      Expected{"interior/schependomlaan_root.glb", 3229, 3229, 115685},
                      Expected{"interior/recast_dungeon.obj", 1, 1, 10133},
                      Expected{"city/denhaag.glb", 5971, 1991, 41183},
                      Expected{"city/candela_city.glb", 2906, 839, 445022},
                      Expected{"cad/2CylinderEngine.glb", 115, 67, 121496},
                      Expected{"cad/as1-tu-203.glb", 18, 18, 7488},
                      Expected{"forest/black_forest.glb", 4533, 2925, 1105608},
                      Expected{"gamemap/czest3ctf.glb", 5768, 5768, 34359},
                      Expected{"gamemap/oa_dm2.glb", 2517, 2517, 12033},
                      Expected{"gamemap/ctf_compromise.glb", 4552, 4552, 20711},
                      Expected{"gamemap/ons-reborn.glb", 14943, 14943, 125101},
                      Expected{"ugly/motorBike.obj", 67, 1, 331653},
                      // 1,991 objects with 5,971 groups within them
                      Expected{"ugly/denhaag_rd_absolute.obj", 5971, 1, 41183},
                      Expected{"ugly/redeclipse_auster.obj", 375, 1, 46603},
                      Expected{"ugly/tesseract_alphacorp.obj", 1117, 1, 33963}),
    [](const ::testing::TestParamInfo<Expected>& scene) {
        std::string name = fs::path(scene.param.file).filename().string();
        for (char& c : name)
            c = std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
        return name;
    });

/// The same city quarter, once around its own origin as GLB, once in the national grid as OBJ.
TEST(SharedScenes, FarCoordinatesLoseNothing) {
    fs::path near = scenes_folder() / "city/denhaag.glb", far = scenes_folder() / "ugly/denhaag_rd_absolute.obj";
    if (!fs::exists(near) || !fs::exists(far))
        GTEST_SKIP();
    Result<Scene> a = load_scene(near.string()), b = load_scene(far.string());
    ASSERT_TRUE(a.ok() && b.ok());
    EXPECT_EQ(a->triangles().size(), 41183u);
    EXPECT_EQ(b->triangles().size(), 41183u);
    EXPECT_LT(b->step(), 1e-3);
    Box3f sa = a->local_bounds(), sb = b->local_bounds();
    for (int k = 0; k < 3; ++k)
        EXPECT_NEAR(sa.size()[k], sb.size()[k], 2e-3);
}

} // namespace
} // namespace antumbra
