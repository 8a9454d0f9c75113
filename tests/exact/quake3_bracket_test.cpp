#include "support/quake3_bracket.hpp"

#include "base/file.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

namespace antumbra {
namespace {

// Sampled within exact within baked, on a share of the leaves; `bench_quake3_bracket` does the same for whole maps.
TEST(Quake3Bracket, HoldsOnAShareOfARealMap) {
    const char* folder = std::getenv("ANTUMBRA_SCENES");
    std::string path = (folder ? std::string(folder) : ANTUMBRA_SOURCE_DIR "/../shared/scenes") + "/gamemap/oa_dm2.bsp";
    if (!std::filesystem::exists(path))
        GTEST_SKIP() << "no " << path;
    Result<MappedFile> file = MappedFile::open(path);
    ASSERT_TRUE(file);
    Result<Quake3Map> map = import_quake3(file->bytes(), path);
    ASSERT_TRUE(map) << map.status().message();
    test::Quake3Bracket bracket(*map, "oa_dm2.bsp");
    BakeOptions options;
    options.rays_per_cell = 5000;
    options.holdout_rays = 500;
    test::Quake3Bracket::Counts counts = bracket.check(6, 3, options);
    EXPECT_EQ(counts.cells, 6u);
    EXPECT_GT(counts.sampled, 100u);
    EXPECT_GT(counts.exact, counts.sampled);
    EXPECT_EQ(counts.sampled_not_exact, 0u);
    EXPECT_EQ(counts.undecided, 0u);
    EXPECT_GT(counts.surfaces, 50u);
    EXPECT_GT(counts.baked_surfaces, counts.surfaces);
    EXPECT_EQ(counts.exceptions, std::vector<std::string>());
}

} // namespace
} // namespace antumbra
