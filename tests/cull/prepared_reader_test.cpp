// What an independent program, written from the format's description alone, reads of a prepared file.
#include "cull/scene_data.hpp"
#include "evaluate/cull_scene.hpp"
#include "support/make_scene.hpp"

#include <antumbra/bake.hpp>
#include <antumbra/occluder_finding.hpp>

#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <unistd.h>

namespace antumbra {
namespace {

template <class List>
void write_line(std::ostringstream& out, const std::string& head, const List& list) {
    out << head;
    for (auto item : list)
        out << ' ' << item;
    out << '\n';
}

void write_sets(std::ostringstream& out, int kind, const OccluderSets& sets) {
    std::vector<Box3d> boxes = sets.cells().boxes();
    for (std::size_t leaf = 0; leaf < boxes.size(); ++leaf)
        for (std::size_t d = 0; d < OccluderSets::kDirections; ++d)
            write_line(out, "set " + std::to_string(kind) + " " + std::to_string(leaf * OccluderSets::kDirections + d) + ":",
                       sets.at(boxes[leaf].centre(), OccluderSets::directions()[d]));
}

std::string dump(const CullScene::Data& data, const OccluderDatabase& database) {
    std::ostringstream out;
    const OccluderSet& set = data.occluders;
    out << "occluders: " << set.vertices.size() << " vertices, " << set.polygons.size() << " polygons, " << set.solids.size()
        << " solids, " << set.patches.size() << " patches\n";
    for (const OccluderPolygon& p : set.polygons)
        write_line(out, "polygon " + std::to_string(p.object) + " " + std::to_string(p.double_sided + 2 * p.synthetic) + " " +
                            std::to_string(p.solid), set.loop(p));
    for (std::size_t s = 0; s < set.solids.size(); ++s)
        if (set.solids[s].is_restricted())
            out << "restricted " << s << '\n';
    for (const ConvexGroups::Group& group : data.groups.groups)
        write_line(out, "group", std::span(data.groups.members).subspan(group.first, group.count));
    write_line(out, "tree over objects:", data.order);
    write_line(out, "tree over patches too:", data.patches.order);
    write_sets(out, 7, data.front_sets);
    write_sets(out, 5, data.back_sets);
    write_sets(out, 6, data.first_hit_sets);
    for (std::uint32_t i = 0; i + 1 < database.first.size(); ++i)
        write_line(out, "minimum set " + std::to_string(i) + ":",
                   std::span(database.polygons).subspan(database.first[i], database.first[i + 1] - database.first[i]));
    return out.str();
}

TEST(PreparedReader, an_independent_program_reads_the_same) {
    test::SceneMaker maker;
    maker.object("floor").quad({0, 0, 0}, {0, 0, 8}, {8, 0, 8}, {8, 0, 0});
    maker.object("house").box({0, 0, 10}, {4, 3, 11});
    maker.object("next house").box({4, 0, 10}, {8, 2, 11});
    maker.object("box").box({1, 0, 2}, {2, 1, 3});
    maker.object("curtain", kOccludes | kDoubleSided).quad({0, 0, 5}, {3, 0, 5}, {3, 3, 5}, {0, 3, 5});
    RawScene raw = maker.raw();
    raw.triangles.erase(raw.triangles.begin() + 2); // a hole in the first house: what joins them is restricted
    --raw.objects[1].triangle_count;
    for (std::size_t o = 2; o < raw.objects.size(); ++o)
        --raw.objects[o].first_triangle;
    Scene scene = *Scene::create(raw);
    OccluderSet occluders = find_occluders(scene);
    CullScene cull_scene = cull_scene_of(scene, occluders);
    std::vector<PvsChunk> chunks = *prepare_chunks(cull_scene, {.leaves = 4, .per_set = 8, .first_hit_leaves = 2});
    OccluderDatabase database;
    database.count = {2, 1, 1};
    database.first = {0, 2, 2, 3, 3, 3, 3, 3, 3, 3, 3, 3, 5};
    database.polygons = {3, 1, 0, 2, 4};
    chunks.push_back(occluder_database_chunk(database));
    std::vector<std::byte> bytes = *add_pvs_chunks(*encode_pvs(describe_scene(scene)), chunks);
    std::string path = (std::filesystem::temp_directory_path() / ("prepared-" + std::to_string(::getpid()) + ".pvs")).string();
    std::ofstream(path, std::ios::binary).write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
    std::FILE* pipe = ::popen(("python3 '" ANTUMBRA_SOURCE_DIR "/tests/pvs/read_prepared.py' '" + path + "' 2>&1").c_str(), "r");
    ASSERT_NE(pipe, nullptr);
    std::string output;
    char buffer[4096];
    while (std::size_t got = std::fread(buffer, 1, sizeof buffer, pipe))
        output.append(buffer, got);
    EXPECT_EQ(::pclose(pipe), 0);
    std::filesystem::remove(path);
    Result<CullScene> opened = CullScene::open(*Pvs::open(bytes));
    ASSERT_TRUE(opened) << opened.status().message();
    EXPECT_GT(opened->data().front_sets.members().size(), 20u);
    EXPECT_NE(output.find("restricted"), std::string::npos);
    EXPECT_EQ(output, dump(opened->data(), database));
}

} // namespace
} // namespace antumbra
