// The study of Nirenstein, Blake and Gain's figures.
#include <antumbra/generate.hpp>
#include <antumbra/study.hpp>

#include <gtest/gtest.h>

namespace antumbra {
namespace {

TEST(Studies, NirensteinMakesItsTablesAndFigures) {
    Result<RawScene> raw = generate("apartment", {});
    ASSERT_TRUE(raw);
    Scene scene = std::move(Scene::create(std::move(*raw))).value();
    StudyOptions options;
    options.width = 160;
    options.height = 90;
    auto study = run_study("nirenstein", scene, options);
    ASSERT_TRUE(study) << study.status().message();
    EXPECT_EQ(problem_of(*study), nullptr);
    ASSERT_EQ(study->tables.size(), 4u);
    const StudyTable& table = study->tables[0];
    ASSERT_EQ(table.rows.size(), 3u);
    EXPECT_EQ(table.rows[0].origin, StudyOrigin::published);
    EXPECT_EQ(table.rows[0].cells[4].number, 99.45);
    EXPECT_EQ(table.rows[2].cells[1].number, double(scene.triangles().size()));
    EXPECT_GT(table.rows[2].cells[3].number, 0);
    EXPECT_GT(table.rows[2].cells[4].number, 20); // culled: %
    EXPECT_LT(table.rows[2].cells[4].number, 100);
    EXPECT_EQ(study->tables[1].rows[2].cells[4].number, 0); // undecided
    double queries = 0;
    for (const StudyRow& row : study->tables[2].rows)
        queries += row.cells[1].number;
    EXPECT_NEAR(queries, 100, 1e-6);
    const std::vector<StudyCell>& near = study->tables[3].rows[1].cells;
    EXPECT_LE(near[1].number, near[2].number);
    EXPECT_LE(near[2].number, near[3].number);
    ASSERT_EQ(study->plots.size(), 2u);
    ASSERT_EQ(study->pictures.size(), 1u);
    EXPECT_GT(study->pictures[0].png.size(), 500u);
}

} // namespace
} // namespace antumbra
