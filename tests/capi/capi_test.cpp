// Makes a file and runs the checks of antumbra_test.c on it, opened from memory and from disk.
#include "base/file.hpp"

#include <antumbra/antumbra.h>
#include <antumbra/pvs.hpp>

#include <gtest/gtest.h>

#include <cstdio>
#include <string>
#include <unistd.h>

extern "C" {
int check_versions(void);
int check_description(const ant_pvs* pvs);
int check_texts(const ant_pvs* pvs);
int check_objects_and_cells(const ant_pvs* pvs);
int check_queries(const ant_pvs* pvs);
int check_ranges(const ant_pvs* pvs);
int check_misuse(const ant_pvs* pvs);
int check_no_clusters(const ant_pvs* pvs);
int check_clusters(const ant_pvs* pvs);
int check_leaves(const ant_pvs* pvs);
int check_cull_scene(void);
int check_cull_methods(void);
int check_cull_answers(void);
int check_cull_of_file(const ant_pvs* pvs);
int check_cursor_changes(const ant_pvs* pvs);
int check_cull_misuse(const ant_pvs* pvs);
}

namespace {

antumbra::PvsData data_of_the_c_test() {
    antumbra::PvsData data;
    data.guarantee = antumbra::Guarantee::exact;
    data.method = "exact";
    data.tool_version = "0.1";
    data.options_json = std::string("{}");
    data.scene_fingerprint = {0xAB};
    data.scene_fingerprint[15] = 0xCD;
    data.structure_fingerprint = 0x0123456789ABCDEFu;
    data.sides = 1;
    data.origin = {10, 0, 0};
    data.objects.resize(3);
    for (antumbra::PvsObject& object : data.objects)
        object.bounds = {{0, 0.5, 0.5}, {0, 0.5, 0.5}};
    data.objects[2] = {7, 1, -1, ANT_OBJECT_OCCLUDES, 12, {{1, 0, 0}, {2, 1, 1}}, "door"};
    data.grid = {{{0, 0, 0}, {3, 1, 1}}, {3, 1, 1}};
    data.volumes = {{{0, 0, 0}, {3, 1, 1}}, {2, 1, 1}};
    data.row_count = 2;
    data.rows = {1 | 1 << 3, 5 | 2 << 3};
    data.cell_row = {0, 1, antumbra::kCellNotBaked};
    return data;
}

class CInterface : public testing::Test {
  protected:
    void SetUp() override {
        bytes_ = *antumbra::encode_pvs(data_of_the_c_test());
        ASSERT_EQ(ant_pvs_open_memory(bytes_.data(), bytes_.size(), &pvs_, error_, sizeof error_), ANT_OK) << error_;
        EXPECT_STREQ(error_, "");
    }
    void TearDown() override { ant_pvs_close(pvs_); }

    std::vector<std::byte> bytes_;
    ant_pvs* pvs_ = nullptr;
    char error_[200] = "untouched";
};

TEST_F(CInterface, Versions) { EXPECT_EQ(check_versions(), 0) << "line of antumbra_test.c"; }
TEST_F(CInterface, Description) { EXPECT_EQ(check_description(pvs_), 0) << "line of antumbra_test.c"; }
TEST_F(CInterface, Texts) { EXPECT_EQ(check_texts(pvs_), 0) << "line of antumbra_test.c"; }
TEST_F(CInterface, ObjectsAndCells) { EXPECT_EQ(check_objects_and_cells(pvs_), 0) << "line of antumbra_test.c"; }
TEST_F(CInterface, Queries) { EXPECT_EQ(check_queries(pvs_), 0) << "line of antumbra_test.c"; }
TEST_F(CInterface, Ranges) { EXPECT_EQ(check_ranges(pvs_), 0) << "line of antumbra_test.c"; }
TEST_F(CInterface, MisuseIsAnswered) { EXPECT_EQ(check_misuse(pvs_), 0) << "line of antumbra_test.c"; }
TEST_F(CInterface, FilesWithoutClusters) { EXPECT_EQ(check_no_clusters(pvs_), 0) << "line of antumbra_test.c"; }

/// Two objects, of five triangles (one without area) and of one, in three clusters; two leaves along x.
TEST(CInterfaceOfClusters, ClustersAndLeaves) {
    antumbra::PvsData data;
    data.guarantee = antumbra::Guarantee::exact;
    data.objects.resize(2);
    data.objects[0].triangle_count = 4;
    data.objects[1].triangle_count = 1;
    data.cluster_first = {0, 2, 4, 5};
    data.triangles = {{5, {1, 0, antumbra::PvsTriangles::kNone, 1, 0}}, {1, {2}}};
    data.tree.bounds = {{0, 0, 0}, {4, 1, 1}};
    data.tree.nodes = {{0, 16384, 2}, {antumbra::ViewNode::kLeaf, 0, 0}, {antumbra::ViewNode::kLeaf, 0, antumbra::kCellSolid}};
    data.row_count = 1;
    data.rows = {0b10101}; // object 0 and its cluster 0, the cluster of object 1
    std::vector<std::byte> bytes = *antumbra::encode_pvs(data);
    ant_pvs* pvs = nullptr;
    ASSERT_EQ(ant_pvs_open_memory(bytes.data(), bytes.size(), &pvs, nullptr, 0), ANT_OK);
    EXPECT_EQ(check_clusters(pvs), 0) << "line of antumbra_test.c";
    EXPECT_EQ(check_leaves(pvs), 0) << "line of antumbra_test.c";
    ant_pvs_close(pvs);
}

TEST_F(CInterface, Changes) { EXPECT_EQ(check_cursor_changes(pvs_), 0) << "line of cull_test.c"; }
TEST_F(CInterface, CullScene) { EXPECT_EQ(check_cull_scene(), 0) << "line of cull_test.c"; }
TEST_F(CInterface, CullMethods) { EXPECT_EQ(check_cull_methods(), 0) << "line of cull_test.c"; }
TEST_F(CInterface, CullAnswers) { EXPECT_EQ(check_cull_answers(), 0) << "line of cull_test.c"; }
TEST_F(CInterface, CullOfAFile) { EXPECT_EQ(check_cull_of_file(pvs_), 0) << "line of cull_test.c"; }
TEST_F(CInterface, CullMisuseIsAnswered) { EXPECT_EQ(check_cull_misuse(pvs_), 0) << "line of cull_test.c"; }

TEST_F(CInterface, OpensAFileOfTheDisk) {
    std::string path = testing::TempDir() + "capi_test" + std::to_string(::getpid()) + ".pvs";
    ASSERT_TRUE(antumbra::write_file_atomically(path, bytes_));
    ant_pvs* mapped = nullptr;
    EXPECT_EQ(ant_pvs_open_file(path.c_str(), &mapped, error_, sizeof error_), ANT_OK) << error_;
    EXPECT_EQ(check_queries(mapped), 0);
    ant_pvs_close(mapped);
    bytes_.back() ^= std::byte(1);
    ASSERT_TRUE(antumbra::write_file_atomically(path, bytes_));
    EXPECT_EQ(ant_pvs_open_file(path.c_str(), &mapped, error_, sizeof error_), ANT_CORRUPT);
    EXPECT_EQ(mapped, nullptr);
    EXPECT_NE(std::string(error_).find(path + ": chunk 'ROWS'"), std::string::npos) << error_;
    std::remove(path.c_str());
}

} // namespace
