#include "base/file.hpp"
#include "evaluate/report/image_coding.hpp"
#include "evaluate/report/plan.hpp"
#include "evaluate/two_rooms.hpp"

#include <antumbra/evaluate.hpp>
#include <nlohmann/json.hpp>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <regex>
#include <unistd.h>

namespace antumbra {
namespace {

using test::OpenFile;
using test::two_cells;
using test::two_rooms;
using Json = nlohmann::json;

/// A folder that goes when the test ends.
struct Folder {
    std::filesystem::path path;
    Folder() {
        std::string name = (std::filesystem::temp_directory_path() / "antumbra-XXXXXX").string();
        path = ::mkdtemp(name.data());
    }
    ~Folder() { std::filesystem::remove_all(path); }
    std::string operator/(const std::string& name) const { return (path / name).string(); }
};

struct Output {
    int code = 0;
    std::string text;
};

Output run(const std::string& command) {
    Output output;
    FILE* pipe = ::popen(command.c_str(), "r");
    std::array<char, 4096> buffer;
    while (std::size_t n = std::fread(buffer.data(), 1, buffer.size(), pipe))
        output.text.append(buffer.data(), n);
    int status = ::pclose(pipe);
    output.code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    return output;
}

WalkResult walk_two_rooms(const Scene& scene, const Pvs& pvs, bool draw = false) {
    View view;
    view.eye = scene.to_local({1, 1.5, 3.5});
    view.target = scene.to_local({2.5, 0.5, 1.5});
    view.near_plane = 0;
    View second = view;
    second.eye = scene.to_local({1.5, 1.5, 3.5});
    WalkOptions options;
    options.methods = {"none", "frustum", "pvs"};
    options.pvs = &pvs;
    options.width = 96;
    options.height = 54;
    options.repeat = 1;
    options.draw = draw;
    auto result = walk(scene, std::vector<View>{view, second}, options);
    EXPECT_TRUE(result) << result.status().message();
    return std::move(result).value();
}

std::string page_of_two_rooms(std::uint64_t right_row = 0b1010, bool draw = false) {
    Scene scene = two_rooms().scene();
    PvsData data = two_cells(scene);
    data.rows[1] = right_row;
    OpenFile file(data);
    ReportOptions options;
    options.plan_pixels = 64;
    auto page = make_report(scene, &*file.pvs, walk_two_rooms(scene, *file.pvs, draw), options);
    EXPECT_TRUE(page);
    return std::move(page).value();
}

Json data_of(const std::string& page) {
    const std::string open = "<script type=\"application/json\" id=\"data\">";
    std::size_t begin = page.find(open) + open.size();
    return Json::parse(page.substr(begin, page.find("</script>", begin) - begin));
}

TEST(Report, LoadsNothing) {
    std::string page = page_of_two_rooms(0b0010, true);
    for (const char* load :
         {R"((src|href|action|poster|srcset)\s*=\s*["']?\s*(https?:|//))", R"(url\(\s*["']?(https?:|//))", R"(@import)",
          R"(\b(fetch|importScripts|XMLHttpRequest|WebSocket|EventSource|sendBeacon)\s*\()"})
        EXPECT_FALSE(std::regex_search(page, std::regex(load))) << load;
    EXPECT_EQ(page.find("{{"), std::string::npos);
}

TEST(Report, CarriesTheNumbersOfTheWalk) {
    Json data = data_of(page_of_two_rooms());
    ASSERT_EQ(data["methods"].size(), 3u);
    EXPECT_EQ(data["methods"][2]["name"], "pvs");
    EXPECT_EQ(data["methods"][2]["guarantee"], "conservative");
    EXPECT_EQ(data["methods"][2]["objects_reported"], 2.0);
    EXPECT_EQ(data["frames"]["reported"][2], Json({2, 2}));
    EXPECT_EQ(data["frames"]["objects_true"], Json({2, 2}));
    EXPECT_EQ(data["snapshots"][0]["seen"], "Cg=="); // bits 1 and 3
    EXPECT_EQ(data["pvs"]["cells"], 2);
    EXPECT_TRUE(data["methods"][2]["draw_ms"]["median"].is_null());
}

TEST(Report, ShowsLossInThePictures) {
    Json good = data_of(page_of_two_rooms()), bad = data_of(page_of_two_rooms(0b0010));
    EXPECT_EQ(good["pictures"][0]["methods"][2]["differing_pixels"], 0);
    EXPECT_TRUE(good["pictures"][0]["methods"][2]["on"].is_null());
    EXPECT_GT(bad["pictures"][0]["methods"][2]["differing_pixels"], 50);
    EXPECT_EQ(bad["pictures"][0]["methods"][2]["on"].get<std::string>().substr(0, 22), "data:image/png;base64,");
}

TEST(Report, NamesFromTheFileCannotBecomeMarkup) {
    RawScene raw = two_rooms().raw();
    raw.source = "x/</script><img src=http:y>.glb";
    auto scene = Scene::create(raw);
    ASSERT_TRUE(scene);
    OpenFile file(two_cells(*scene));
    auto page = make_report(*scene, &*file.pvs, walk_two_rooms(*scene, *file.pvs));
    ASSERT_TRUE(page);
    EXPECT_EQ(page->find("<img src=http"), std::string::npos);
    EXPECT_EQ(data_of(*page)["scene"]["name"], "script><img src=http:y>.glb");
}

TEST(Report, RunsInABrowser) {
    if (run("command -v chromium").code != 0)
        GTEST_SKIP() << "no chromium";
    Folder folder;
    ASSERT_TRUE(write_file_atomically(folder / "page.html", page_of_two_rooms(0b0010, true)));
    Output dom =
        run("timeout 60 chromium --headless --no-sandbox --disable-gpu --no-first-run --disable-sync "
            "--disable-background-networking --disable-component-update --virtual-time-budget=4000 "
            "--enable-logging=stderr --user-data-dir='" +
            (folder / "profile") + "' --dump-dom 'file://" + (folder / "page.html") + "' 2>'" + (folder / "log") + "'");
    ASSERT_EQ(dom.code, 0);
    EXPECT_NE(dom.text.find("data-ready=\"yes\""), std::string::npos) << "the script did not reach its end";
    EXPECT_NE(dom.text.find("pvs broke its promise"), std::string::npos);
    EXPECT_NE(dom.text.find("class=\"uplot"), std::string::npos);
    auto log = MappedFile::open(folder / "log");
    ASSERT_TRUE(log);
    std::string text(reinterpret_cast<const char*>(log->bytes().data()), log->bytes().size());
    EXPECT_EQ(text.find("CONSOLE"), std::string::npos) << text;
}

TEST(Plan, CutsTheWallAndShowsTheFloors) {
    Scene scene = two_rooms().scene();
    OpenFile file(two_cells(scene));
    WalkResult result = walk_two_rooms(scene, *file.pvs);
    Tracer tracer = Tracer::build(scene);
    Plans plans = make_plans(tracer, result, 32, {});
    ASSERT_EQ(plans.plans.size(), 1u);
    const Plan& plan = plans.plans[0];
    EXPECT_NEAR(scene.to_world({0, plan.cut, 0}).y, 1.5, 0.1);
    // Decode and look at the pixel over the right crate's lid: object 3, level.
    std::vector<std::uint64_t> pixels;
    std::size_t at = 0;
    auto next = [&] {
        std::uint64_t value = 0;
        for (int shift = 0;; shift += 7) {
            auto byte = std::to_integer<std::uint64_t>(plan.runs[at++]);
            value |= (byte & 127) << shift;
            if (byte < 128)
                return value;
        }
    };
    while (at < plan.runs.size()) {
        std::uint64_t value = next(), count = next();
        pixels.insert(pixels.end(), count, value);
    }
    ASSERT_EQ(pixels.size(), std::size_t(plan.width) * plan.height);
    Vec3d lid = scene.to_local({2.5, 0, 1.5});
    auto i = std::size_t((lid.x - plan.x0) / plan.scale), j = std::size_t((lid.z - plan.z0) / plan.scale);
    ASSERT_LT(i, plan.width);
    ASSERT_LT(j, plan.height);
    EXPECT_EQ(pixels[i + plan.width * j], 1u + 8 * 3 + 6);
}

TEST(Plan, UnderTheOpenSkyTheSceneIsSeenWhole) {
    Scene scene = test::SceneMaker()
                      .object("ground")
                      .quad({-20, 0, 20}, {20, 0, 20}, {20, 0, -20}, {-20, 0, -20})
                      .object("tower")
                      .box({4, 0, -1}, {6, 10, 1})
                      .scene();
    View view;
    view.eye = scene.to_local({0, 1.6, 0});
    view.target = scene.to_local({5, 1.6, 0});
    WalkOptions walk_options;
    walk_options.draw = false;
    walk_options.width = walk_options.height = 16;
    auto result = walk(scene, std::vector<View>{view}, walk_options);
    ASSERT_TRUE(result);
    Tracer tracer = Tracer::build(scene);
    Plans plans = make_plans(tracer, *result, 32, {});
    EXPECT_TRUE(plans.outdoors);
    EXPECT_GE(scene.to_world({0, plans.plans.at(0).cut, 0}).y, 10);
}

TEST(ImageCoding, Base64OfTheStandard) {
    auto encode = [](const std::string& text) { return to_base64(std::as_bytes(std::span(text.data(), text.size()))); };
    EXPECT_EQ(encode(""), "");
    EXPECT_EQ(encode("f"), "Zg==");
    EXPECT_EQ(encode("fo"), "Zm8=");
    EXPECT_EQ(encode("foo"), "Zm9v");
    EXPECT_EQ(encode("foobar"), "Zm9vYmFy");
}

TEST(ImageCoding, PngBeginsAsPngsDo) {
    auto png = encode_png({1, 1, {255, 0, 0}});
    ASSERT_GT(png.size(), 33u);
    EXPECT_EQ(to_base64(std::span(png).first(6)), "iVBORw0K");
}

/// The flat of a few triangles as a file, for the command.
std::string write_room(const Folder& folder) {
    std::string obj = "o room\nv 0 0 0\nv 4 0 0\nv 4 0 4\nv 0 0 4\nv 0 3 0\nv 4 3 0\nv 4 3 4\nv 0 3 4\n"
                      "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\no thing\nv 1 0 1\nv 2 0 1\nv "
                      "1.5 1 1\nf 9 10 11\n";
    EXPECT_TRUE(write_file_atomically(folder / "room.obj", obj));
    return folder / "room.obj";
}

const std::string kProgram = std::string(ANTUMBRA_BINARY_DIR) + "/antumbra";

TEST(WalkCommand, PrintsTheKeysThatScriptsRelyOn) {
    Folder folder;
    std::string scene = write_room(folder);
    Output output = run(kProgram + " walk '" + scene + "' --frames 4 --size 64x36 --repeat 1 --json --report '" +
                        (folder / "r.html") + "' --save-path '" + (folder / "p.json") + "' 2>/dev/null");
    ASSERT_EQ(output.code, 0);
    Json document = Json::parse(output.text);
    for (const char* key : {"scene", "frames", "width", "height", "methods"})
        EXPECT_TRUE(document.contains(key)) << key;
    EXPECT_EQ(document["frames"], 4);
    EXPECT_EQ(document["width"], 64);
    ASSERT_EQ(document["methods"].size(), 2u);
    for (const Json& method : document["methods"]) {
        for (const char* key :
             {"name", "guarantee", "objects_reported", "objects_true", "triangles_drawn", "culled_of_frustum",
              "false_visible_objects", "false_invisible_objects", "false_invisible_pixels", "speedup_over_frustum"})
            EXPECT_TRUE(method.contains(key)) << key;
        EXPECT_GT(method["cull_ms"]["median"], 0);
        EXPECT_TRUE(method["cull_ms"].contains("p99"));
        EXPECT_TRUE(method["draw_ms"].contains("median"));
        EXPECT_TRUE(method["frame_ms"].contains("median"));
        EXPECT_EQ(method["false_invisible_pixels"], 0);
    }
    EXPECT_TRUE(file_exists(folder / "r.html"));
    // The saved path is taken again and gives the same frames.
    Output again = run(kProgram + " walk '" + scene + "' --path '" + (folder / "p.json") +
                       "' --size 64x36 --repeat 1 --no-draw --json 2>/dev/null");
    ASSERT_EQ(again.code, 0);
    EXPECT_EQ(Json::parse(again.text)["methods"][0]["objects_true"], document["methods"][0]["objects_true"]);
}

TEST(WalkCommand, WrongUsageIsTwo) {
    Folder folder;
    std::string scene = write_room(folder);
    EXPECT_EQ(run(kProgram + " walk '" + scene + "' --size 64 2>/dev/null").code, 2);
    EXPECT_EQ(run(kProgram + " walk '" + scene + "' --cull nonsense --frames 2 2>/dev/null").code, 2);
    EXPECT_EQ(run(kProgram + " walk '" + scene + "' --cull pvs --frames 2 2>/dev/null").code, 2);
}

TEST(VerifyCommand, PrintsTheKeysAndRefusesAnotherScene) {
    Folder folder;
    std::string scene = write_room(folder);
    std::string bake = kProgram + " bake '" + scene + "' --cells 2x1x2 --rays-per-cell 2048 -o '" +
                       (folder / "room.pvs") + "' 2>/dev/null >/dev/null";
    ASSERT_EQ(run(bake).code, 0);
    Output output =
        run(kProgram + " verify '" + scene + "' '" + (folder / "room.pvs") + "' --samples 10 --json 2>/dev/null");
    ASSERT_EQ(output.code, 0);
    Json document = Json::parse(output.text);
    for (const char* key : {"viewpoints", "pixels", "false_invisible_objects", "false_invisible_pixels",
                            "false_visible_objects", "worst"})
        EXPECT_TRUE(document.contains(key)) << key;
    EXPECT_EQ(document["viewpoints"], 10);
    Output sides =
        run(kProgram + " verify '" + scene + "' '" + (folder / "room.pvs") + "' --ignore thing 2>&1 >/dev/null");
    EXPECT_EQ(sides.code, 1);
    EXPECT_NE(sides.text.find("another scene"), std::string::npos) << sides.text;
}

} // namespace
} // namespace antumbra
