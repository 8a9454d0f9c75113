#include "evaluate/two_rooms.hpp"

#include <antumbra/evaluate.hpp>
#include <antumbra/generate.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>

namespace antumbra {
namespace {

using Json = nlohmann::json;

Study small_study() {
    Study study;
    study.name = "small";
    study.title = "A study";
    study.source = "Nobody, 1900";
    study.tables.push_back({"table", "", {{"scene", "", 0}, {"time", "ms", 2}}, {{StudyOrigin::published, {"a </script> b", {}}},
                                                                              {StudyOrigin::ours, {"c", 1.5}}}});
    study.plots.push_back({"plot", "x", "y", true, false, {{"line", StudyOrigin::ours, {1, 2}, {3, 0}}}});
    return study;
}

TEST(Study, ShapesThatDoNotFitAreNamed) {
    EXPECT_EQ(problem_of(small_study()), nullptr);
    Study study = small_study();
    study.tables[0].rows[0].cells.pop_back();
    EXPECT_STREQ(problem_of(study), "a row has other cells than columns");
    study = small_study();
    study.plots[0].series[0].x = {2, 1};
    EXPECT_STREQ(problem_of(study), "the places of a line do not ascend");
    study = small_study();
    study.plots[0].logarithmic_y = true;
    EXPECT_STREQ(problem_of(study), "a logarithmic plot has a value that is not above 0");
    study = small_study();
    study.pictures.push_back({"no PNG", std::vector<std::byte>(100)});
    EXPECT_STREQ(problem_of(study), "a picture is no PNG or has no caption");
}

TEST(Study, JsonKeepsNumbersAndWhoseTheyAre) {
    Json json = Json::parse(study_json(small_study(), false));
    EXPECT_EQ(json["tables"][0]["rows"][0]["origin"], "published");
    EXPECT_TRUE(json["tables"][0]["rows"][0]["cells"][1].is_null());
    EXPECT_EQ(json["tables"][0]["rows"][1]["cells"][1], 1.5);
    EXPECT_EQ(json["plots"][0]["series"][0]["y"], Json({3, 0}));
}

TEST(Study, UnknownNamesListTheKnownOnes) {
    Scene scene = test::two_rooms().scene();
    auto study = run_study("nonsense", scene);
    ASSERT_FALSE(study);
    EXPECT_EQ(study.status().code(), ErrorCode::usage);
    EXPECT_NE(study.status().message().find("coorg-teller"), std::string::npos);
    for (std::string_view name : study_names())
        EXPECT_FALSE(study_summary(name).empty());
}

TEST(Study, CoorgTellerCullsAndKeepsItsRelationsWhileTheViewerWalks) {
    auto raw = generate("city", {30000, 1});
    ASSERT_TRUE(raw) << raw.status().message();
    auto scene = Scene::create(std::move(*raw));
    ASSERT_TRUE(scene);
    PathOptions path_options;
    path_options.frames = 12;
    auto path = find_path(*scene, path_options);
    ASSERT_TRUE(path) << path.status().message();
    StudyOptions options;
    options.path = path->views;
    options.width = 96;
    options.height = 54;
    options.repeat = 1;
    options.draw = false;
    auto study = run_study("coorg-teller", *scene, options);
    ASSERT_TRUE(study) << study.status().message();
    EXPECT_EQ(problem_of(*study), nullptr);
    ASSERT_EQ(study->tables.size(), 3u);
    for (const StudyTable& table : study->tables) {
        auto of = [&](StudyOrigin origin) {
            return std::count_if(table.rows.begin(), table.rows.end(), [&](const StudyRow& r) { return r.origin == origin; });
        };
        EXPECT_GE(of(StudyOrigin::published), 1) << table.title;
        EXPECT_GE(of(StudyOrigin::ours), 1) << table.title;
    }
    const std::vector<StudyCell>& left = study->tables[0].rows.back().cells;
    EXPECT_LT(left[3].number, left[2].number) << "occlusion culls more than the frustum";
    EXPECT_LE(left[5].number, left[3].number) << "and draws all that is seen";
    EXPECT_EQ(left[6].number, 0) << "nothing is lost";
    for (const StudyRow& row : study->tables[2].rows)
        if (row.cells[1].words == "relations from the cache, %") {
            EXPECT_GT(row.cells[2].number, 50);
            EXPECT_GE(row.cells[2].number, row.cells[4].number) << "who walks slower finds more";
        }
}

TEST(Study, AnEmptyPathIsAUsageError) {
    Scene scene = test::two_rooms().scene();
    auto study = run_study("coorg-teller", scene);
    ASSERT_FALSE(study);
    EXPECT_EQ(study.status().code(), ErrorCode::usage);
}

TEST(Study, TheReportCarriesStudies) {
    Scene scene = test::two_rooms().scene();
    View view;
    view.eye = scene.to_local({1, 1.5, 3.5});
    view.target = scene.to_local({2.5, 0.5, 1.5});
    WalkOptions walk_options;
    walk_options.width = 32;
    walk_options.height = 18;
    walk_options.repeat = 1;
    walk_options.draw = false;
    auto result = walk(scene, std::vector<View>{view}, walk_options);
    ASSERT_TRUE(result);
    std::vector<Study> studies{small_study()};
    ReportOptions options;
    options.studies = studies;
    options.plan_pixels = 16;
    auto page = make_report(scene, nullptr, *result, options);
    ASSERT_TRUE(page);
    EXPECT_EQ(page->find("a </script> b"), std::string::npos);
    EXPECT_NE(page->find("\"source\":\"Nobody, 1900\""), std::string::npos);
}

TEST(Study, BittnersTreesDrawLessTheMoreOccludersTheyHaveAndLoseNothing) {
    GenerateOptions generate_options;
    generate_options.triangles = 40000;
    generate_options.storeys = 3;
    generate_options.plants = 20;
    auto raw = generate("office", generate_options);
    ASSERT_TRUE(raw) << raw.status().message();
    auto scene = Scene::create(std::move(*raw));
    ASSERT_TRUE(scene);
    PathOptions path_options;
    path_options.frames = 10;
    auto path = find_path(*scene, path_options);
    ASSERT_TRUE(path) << path.status().message();
    StudyOptions options;
    options.path = path->views;
    options.width = 96;
    options.height = 54;
    options.repeat = 1;
    options.draw = false;
    auto study = run_study("bittner", *scene, options);
    ASSERT_TRUE(study) << study.status().message();
    EXPECT_EQ(problem_of(*study), nullptr);
    double frustum = 0, fewest = 1e300, most = 0;
    for (const StudyRow& row : study->tables[0].rows) {
        if (row.origin == StudyOrigin::published)
            continue;
        EXPECT_EQ(row.cells[8].number, 0) << "pixels lost by " << row.cells[1].words;
        if (row.cells[1].words == "F")
            frustum = row.cells[3].number;
        if (row.cells[1].words != "FME")
            continue;
        if (row.cells[2].number == 8)
            most = row.cells[3].number;
        fewest = std::min(fewest, row.cells[3].number);
    }
    EXPECT_LT(most, frustum);
    EXPECT_LT(fewest, most);
    EXPECT_LT(fewest * 3, frustum * 2);
    EXPECT_EQ(run_study("bittner", *scene).status().code(), ErrorCode::usage) << "no path";
}

TEST(Study, PoonWangChoosesFewOccludersAndLosesNothing) {
    auto raw = generate("downtown", {30000, 1});
    ASSERT_TRUE(raw) << raw.status().message();
    auto scene = Scene::create(std::move(*raw));
    ASSERT_TRUE(scene);
    StudyOptions options;
    options.width = options.height = 96;
    options.repeat = 1;
    options.draw = false;
    auto study = run_study("poon-wang", *scene, options);
    ASSERT_TRUE(study) << study.status().message();
    EXPECT_EQ(problem_of(*study), nullptr);
    ASSERT_EQ(study->tables.size(), 5u); // the sixth needs drawing
    EXPECT_EQ(study->pictures.size(), 3u);
    for (const std::string& text : study->notes)
        EXPECT_EQ(text.find("bug"), std::string::npos) << text;
    // More occluders never cull less but for what the choice among them does.
    for (const StudyRow& row : study->tables[0].rows)
        if (row.origin == StudyOrigin::ours) {
            EXPECT_LE(row.cells[2].number, row.cells[1].number) << "more used than allowed";
            EXPECT_GT(row.cells[3].number, 10) << row.cells[0].words << " culls next to nothing";
        }
    std::size_t routes = 0;
    for (const StudyRow& row : study->tables[3].rows)
        if (row.origin == StudyOrigin::ours && row.cells[1].words == "OM") {
            ++routes;
            EXPECT_EQ(row.cells[8].number, 0) << "lost on the " << row.cells[0].words << " route";
        }
    EXPECT_EQ(routes, 3u);
}

} // namespace
} // namespace antumbra
