#include "evaluate/two_rooms.hpp"

#include <antumbra/bake.hpp>
#include <antumbra/explain.hpp>
#include <antumbra/export.hpp>
#include <antumbra/import.hpp>

#include <nlohmann/json.hpp>

namespace antumbra {
namespace {

using test::OpenFile;
using test::SceneMaker;
using test::two_cells;
using test::two_rooms;

constexpr Vec3d kLeftEye{-1, 1.5, 1};
enum : std::uint32_t { kLeftRoom, kRightRoom, kLeftCrate, kRightCrate };

/// Rooms that are drawn from both sides: the gap between them belongs to both cells.
Scene closed_rooms() {
    RawScene raw = two_rooms().raw();
    for (std::uint32_t room : {kLeftRoom, kRightRoom})
        raw.objects[room].flags |= kDoubleSided;
    return std::move(Scene::create(raw)).value();
}

struct Asked {
    Scene scene = closed_rooms();
    OpenFile file;
    Result<Explainer> explainer;
    explicit Asked(Guarantee guarantee = Guarantee::exact, std::vector<std::uint64_t> rows = {0b0111, 0b1011})
        : file([&] {
              PvsData data = two_cells(scene, guarantee);
              data.rows = std::move(rows);
              return data;
          }()),
          explainer(Explainer::create(scene, *file.pvs)) {}
    Explanation ask(std::uint32_t object, Vec3d eye = kLeftEye, ExplainOptions options = {}) {
        EXPECT_TRUE(explainer) << explainer.status().message();
        Result<Explanation> explanation = explainer->explain(eye, object, options);
        EXPECT_TRUE(explanation) << explanation.status().message();
        return *explanation;
    }
};

TEST(Explain, WhatIsSeenCarriesAWitnessThatEndsOnIt) {
    Asked asked;
    Explanation e = asked.ask(kLeftCrate);
    EXPECT_TRUE(e.listed);
    EXPECT_EQ(e.cell, 0);
    EXPECT_EQ(e.state, CellState::baked);
    EXPECT_EQ(e.from_eye.sight, Sight::visible);
    ASSERT_TRUE(e.from_eye.witness);
    EXPECT_EQ(e.from_eye.witness->from, kLeftEye);
    Vec3d end = e.from_eye.witness->to;
    EXPECT_TRUE((Box3d{{-3.001, -0.001, 0.999}, {-1.999, 1.001, 2.001}}.contains(end))) << end.x;
    EXPECT_EQ(asked.scene.triangle_objects()[e.from_eye.witness->triangle], kLeftCrate);
    EXPECT_TRUE(e.from_eye.verified);
    EXPECT_TRUE(e.from_eye.hiders.empty());
    ASSERT_TRUE(e.from_cell);
    EXPECT_EQ(e.from_cell->sight, Sight::visible);
    EXPECT_TRUE(e.from_cell->from.contains(e.from_cell->witness->from));
}

TEST(Explain, WhatIsHiddenCarriesACertificateAndNamesItsHiders) {
    Asked asked;
    Explanation e = asked.ask(kRightCrate);
    EXPECT_FALSE(e.listed);
    for (const SightAnswer* answer : {&e.from_eye, &*e.from_cell}) {
        EXPECT_EQ(answer->sight, Sight::hidden);
        EXPECT_TRUE(answer->verified);
        EXPECT_EQ(answer->lines_through, 0u);
        EXPECT_GT(answer->parts, 0u);
        EXPECT_EQ(answer->leaves, answer->splits + answer->parts); // binary trees
        ASSERT_FALSE(answer->hiders.empty());
        double sum = 0;
        for (const Hider& hider : answer->hiders) {
            EXPECT_NE(hider.object, kRightCrate);
            EXPECT_FALSE(hider.triangles.empty());
            for (std::uint32_t t : hider.triangles)
                EXPECT_EQ(asked.scene.triangle_objects()[t], hider.object);
            sum += hider.share;
        }
        EXPECT_NEAR(sum + answer->undrawn, 1, 1e-12);
    }
    EXPECT_EQ(e.from_eye.hiders[0].object, kLeftRoom);
    EXPECT_GT(e.from_eye.hiders[0].share, 0.99);
    EXPECT_GT(e.from_eye.hiders[0].leaves, 0u);
}

TEST(Explain, TheViewpointMayBeBlindWhereTheCellIsNot) {
    SceneMaker maker;
    maker.object("wall").box({0, 0, -1}, {0.5, 2, 1});
    maker.object("thing").box({2, 0.5, -0.5}, {3, 1, 0.5});
    maker.object("ground").box({-8, -1, -8}, {8, -0.5, 8});
    Scene scene = maker.scene();
    BakeOptions options;
    options.method = "exact";
    options.cells = {1, 1, 1};
    options.where = {{{-6, 0, -6}, {-0.5, 2, 6}}};
    Result<BakeResult> baked = bake(scene, options);
    ASSERT_TRUE(baked) << baked.status().message();
    OpenFile file(baked->pvs);
    Result<Explainer> explainer = Explainer::create(scene, *file.pvs);
    ASSERT_TRUE(explainer);
    Result<Explanation> e = explainer->explain({-1, 0.8, 0}, 1);
    ASSERT_TRUE(e);
    EXPECT_EQ(e->from_eye.sight, Sight::hidden);
    EXPECT_EQ(e->from_cell->sight, Sight::visible);
    EXPECT_TRUE(e->listed);
    std::string words = explain_in_words(scene, *e);
    EXPECT_NE(words.find("0 'wall'"), std::string::npos) << words;
    EXPECT_NE(words.find("elsewhere in the cell"), std::string::npos) << words;
    // From beside the wall it is seen.
    EXPECT_EQ(explainer->explain({-1, 0.8, 4}, 1)->from_eye.sight, Sight::visible);
}

TEST(Explain, SaysWhenTheFileIsWrong) {
    Asked lost(Guarantee::exact, {0b0011, 0b1011});
    EXPECT_NE(explain_in_words(lost.scene, lost.ask(kLeftCrate)).find("against its guarantee"), std::string::npos);
    Asked missed(Guarantee::aggressive, {0b0011, 0b1011});
    EXPECT_NE(explain_in_words(missed.scene, missed.ask(kLeftCrate)).find("which its guarantee allows"),
              std::string::npos);
    Asked more(Guarantee::conservative, {0b1111, 0b1011});
    EXPECT_NE(explain_in_words(more.scene, more.ask(kRightCrate)).find("false visible"), std::string::npos);
    Asked right;
    for (std::uint32_t o = 0; o < 4; ++o)
        for (const char* blame : {"against its guarantee", "which its guarantee allows"})
            EXPECT_EQ(explain_in_words(right.scene, right.ask(o)).find(blame), std::string::npos) << o;
}

TEST(Explain, WithoutAProofWhatIsNotSeenStaysUndecided) {
    Asked asked;
    ExplainOptions options;
    options.prove = false;
    Explanation e = asked.ask(kRightCrate, kLeftEye, options);
    EXPECT_EQ(e.from_eye.sight, Sight::undecided);
    EXPECT_FALSE(e.from_eye.hiders.empty());
    options.prove = true;
    options.most_queries = 0;
    EXPECT_EQ(asked.ask(kRightCrate, kLeftEye, options).from_cell->sight, Sight::undecided);
    // The exact method alone finds the witness that no sight line looked for.
    options = {};
    options.sight_lines = 0;
    e = asked.ask(kLeftCrate, kLeftEye, options);
    EXPECT_EQ(e.from_cell->sight, Sight::visible);
    EXPECT_TRUE(e.from_cell->verified);
}

TEST(Explain, OutsideEveryCellThereIsOnlyTheEye) {
    Asked asked;
    Explanation e = asked.ask(kRightCrate, {-10, 1, 1});
    EXPECT_FALSE(e.from_cell);
    EXPECT_TRUE(e.listed);
    EXPECT_EQ(e.guarantee, Guarantee::conservative);
    EXPECT_EQ(e.from_eye.sight, Sight::hidden);
    EXPECT_EQ(asked.ask(kLeftRoom, {-10, 1, 1}).from_eye.sight, Sight::visible);
    e = asked.ask(kRightRoom, {-10, 1e9, 1});
    EXPECT_NE(e.from_eye.sight, Sight::hidden); // too far away for the solver to say so
}

TEST(Explain, WrongQuestionsAreRefused) {
    Asked asked;
    EXPECT_EQ(asked.explainer->explain(kLeftEye, 4).status().code(), ErrorCode::usage);
    EXPECT_EQ(asked.explainer->explain({0, NAN, 0}, 0).status().code(), ErrorCode::usage);
    Scene other = SceneMaker().object("x").box({0, 0, 0}, {1, 1, 1}).scene();
    EXPECT_EQ(Explainer::create(other, *asked.file.pvs).status().code(), ErrorCode::mismatch);
    EXPECT_EQ(*find_object(asked.scene, "left crate"), kLeftCrate);
    EXPECT_EQ(*find_object(asked.scene, "3"), kRightCrate);
    EXPECT_EQ(find_object(asked.scene, "4").status().code(), ErrorCode::usage);
    EXPECT_EQ(find_object(asked.scene, "crate").status().code(), ErrorCode::usage);
    Scene twins = SceneMaker().object("x").box({0, 0, 0}, {1, 1, 1}).object("x").box({2, 0, 0}, {3, 1, 1}).scene();
    EXPECT_NE(find_object(twins, "x").status().message().find("0 1"), std::string::npos);
}

TEST(Explain, TheJsonHasItsKeysAndTheDrawingItsParts) {
    Asked asked;
    for (std::uint32_t object : {kLeftCrate, kRightCrate}) {
        Explanation e = asked.ask(object);
        nlohmann::json document = nlohmann::json::parse(explain_in_json(asked.scene, e));
        EXPECT_EQ(document["object"]["id"], object);
        EXPECT_EQ(document["cell"]["index"], 0);
        EXPECT_EQ(document["pvs"]["listed"], object == kLeftCrate);
        for (const char* from : {"from_eye", "from_cell"}) {
            EXPECT_EQ(document[from]["answer"], object == kLeftCrate ? "visible" : "hidden");
            EXPECT_EQ(document[from]["witness"].is_null(), object == kRightCrate);
            EXPECT_EQ(document[from]["certificate"]["verified"], true);
            EXPECT_EQ(document[from]["hiders"].empty(), object == kLeftCrate);
        }
        Result<std::vector<std::byte>> glb = explain_as_glb(asked.scene, e);
        ASSERT_TRUE(glb) << glb.status().message();
        Result<RawScene> drawn = import_gltf(*glb, "drawing", "");
        ASSERT_TRUE(drawn) << drawn.status().message();
        // Lines are not objects for the reader: the object comes first, then what hides it.
        ASSERT_FALSE(drawn->objects.empty());
        EXPECT_EQ(drawn->objects[0].name, object == kLeftCrate ? "visible 2 'left crate'" : "hidden 3 'right crate'");
        EXPECT_EQ(drawn->objects[0].triangle_count, 12u);
        EXPECT_EQ(drawn->objects.size() > 1, object == kRightCrate);
    }
}

TEST(Explain, AWholeCellIsDrawnInGreenAndRed) {
    Asked asked;
    Result<std::vector<std::byte>> glb = cell_as_glb(asked.scene, *asked.file.pvs, kLeftEye);
    ASSERT_TRUE(glb) << glb.status().message();
    Result<RawScene> drawn = import_gltf(*glb, "cell", "");
    ASSERT_TRUE(drawn) << drawn.status().message();
    ASSERT_EQ(drawn->objects.size(), 3u);
    EXPECT_EQ(drawn->objects[0].name, "visible");
    EXPECT_EQ(drawn->objects[0].triangle_count, 36u);
    EXPECT_EQ(drawn->objects[1].name, "hidden");
    EXPECT_EQ(drawn->objects[1].triangle_count, 12u);
    EXPECT_EQ(drawn->objects[2].triangle_count, 12u);
    EXPECT_EQ(cell_as_glb(asked.scene, *asked.file.pvs, {-10, 1, 1}).status().code(), ErrorCode::usage);
}

TEST(Explain, TheSameQuestionTwiceGetsTheSameAnswer) {
    Asked asked;
    EXPECT_EQ(explain_in_json(asked.scene, asked.ask(kRightCrate)), explain_in_json(asked.scene, asked.ask(kRightCrate)));
}

} // namespace
} // namespace antumbra
