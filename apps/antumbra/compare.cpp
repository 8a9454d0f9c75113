#include "command.hpp"

#include <antumbra/compare.hpp>
#include <antumbra/evaluate.hpp>

#include <fmt/format.h>

namespace antumbra::app {
namespace {

struct CompareArguments {
    Common common;
    SceneArguments scene;
    std::string a, b;
    CompareOptions options;
};

const char* name_of(CompareUnits units) {
    static constexpr const char* names[] = {"objects", "clusters", "groups"};
    return names[std::size_t(units)];
}

Json to_json(const ComparedFile& file, const Pvs& pvs, const std::string& path) {
    return {{"file", path},
            {"guarantee", to_string(pvs.guarantee())},
            {"method", std::string(pvs.method())},
            {"cells", file.cells},
            {"pairs", file.pairs},
            {"pairs_only", file.pairs_only},
            {"mean_objects", file.mean_objects},
            {"mean_only", file.mean_only},
            {"objects", file.objects},
            {"objects_only", file.objects_only},
            {"pixels_only", file.pixels_only},
            {"clusters", file.clusters},
            {"mean_triangles", file.mean_triangles}};
}

Json to_json(const Scene& scene, const std::vector<ComparedObject>& objects) {
    Json list = Json::array();
    for (const ComparedObject& one : objects)
        list.push_back({{"id", one.object},
                        {"unit", one.unit},
                        {"name", std::string(scene.name(one.object))},
                        {"pairs", one.pairs},
                        {"volume", one.volume},
                        {"pixels", one.pixels}});
    return list;
}

/// ", cluster 7": which part of the object is meant, if it is not the whole.
std::string part_of(const CompareResult& result, std::uint32_t unit) {
    return result.units == CompareUnits::objects    ? ""
           : result.units == CompareUnits::clusters ? fmt::format(", cluster {}", unit)
                                                    : fmt::format(", group {}", unit);
}

void print_json(const CompareArguments& arguments, const Scene& scene, const Pvs& a, const Pvs& b,
                const CompareResult& result) {
    Json document;
    document["a"] = to_json(result.a, a, arguments.a);
    document["b"] = to_json(result.b, b, arguments.b);
    document["units"] = name_of(result.units);
    document["unit_count"] = result.unit_count;
    document["same_cells"] = result.same_cells;
    document["pieces"] = result.pieces;
    document["common_of_a"] = result.common_of_a;
    document["common_of_b"] = result.common_of_b;
    document["pairs_both"] = result.pairs_both;
    document["viewpoints"] = result.viewpoints;
    document["pixels"] = result.pixels;
    document["pixels_neither"] = result.pixels_neither;
    document["only_a"] = to_json(scene, result.only_a);
    document["only_b"] = to_json(scene, result.only_b);
    document["pieces_bound"] = result.pieces_bound;
    document["contradictions"] = result.contradictions;
    document["first"] = Json::array();
    for (const Contradiction& one : result.first)
        document["first"].push_back({{"id", one.object},
                                     {"unit", one.unit},
                                     {"name", std::string(scene.name(one.object))},
                                     {"seen_by", one.a_sees ? "a" : "b"},
                                     {"cell_a", one.cell_a},
                                     {"cell_b", one.cell_b}});
    document["words"] = result.words;
    app::print_json(document);
}

void print_text(const CompareArguments& arguments, const Scene& scene, const Pvs& a, const Pvs& b,
                const CompareResult& result) {
    fmt::print("A          {} ({}, {}), {} cells\n", arguments.a, describe_guarantee(a), a.method(), result.a.cells);
    fmt::print("B          {} ({}, {}), {} cells\n", arguments.b, describe_guarantee(b), b.method(), result.b.cells);
    if (result.same_cells)
        fmt::print("space      the same {} cells\n", result.pieces);
    else
        fmt::print("space      {} pieces where cells of both meet: {:.3g}% of A, {:.3g}% of B\n", result.pieces,
                   100 * result.common_of_a, 100 * result.common_of_b);
    fmt::print("pairs      {} in both, {} only in A, {} only in B\n", result.pairs_both, result.a.pairs_only,
               result.b.pairs_only);
    const char* units = name_of(result.units);
    fmt::print("visible    A {:.1f} {} on average, {:.2f} of them only in A; B {:.1f}, {:.2f} only in B\n",
               result.a.mean_objects, units, result.a.mean_only, result.b.mean_objects, result.b.mean_only);
    fmt::print("triangles  {:.1f} on average in what A lists, {:.1f} in what B lists\n", result.a.mean_triangles,
               result.b.mean_triangles);
    fmt::print("{:<10} {} listed somewhere by A and nowhere by B, {} the other way round\n", units, result.a.objects_only,
               result.b.objects_only);
    if (result.pixels)
        fmt::print("pixels     of {} from {} viewpoints: {} see what only A lists, {} what only B lists, {} what neither "
                   "lists\n",
                   result.pixels, result.viewpoints, result.a.pixels_only, result.b.pixels_only, result.pixels_neither);
    for (const auto& [letter, list] : {std::pair("A", &result.only_a), std::pair("B", &result.only_b)})
        for (const ComparedObject& one : *list)
            fmt::print("only {}     {} '{}'{}: {} pairs, {:.3g}% of the space, {} pixels\n", letter, one.object,
                       scene.name(one.object), part_of(result, one.unit), one.pairs, 100 * one.volume, one.pixels);
    for (const std::string& sentence : result.words)
        fmt::print("{}\n", sentence);
}

int run_compare(CompareArguments& arguments) {
    Result<Scene> scene = arguments.scene.load();
    if (!scene)
        return fail(scene.status());
    Result<PvsFile> a = open_pvs(arguments.a), b = open_pvs(arguments.b);
    if (!a || !b)
        return fail(a ? b.status() : a.status());
    arguments.options.seed = arguments.common.seed;
    Result<CompareResult> result = compare(*scene, a->pvs, b->pvs, arguments.options, make_job(arguments.common));
    if (!result)
        return fail(result.status().in(arguments.a + ", " + arguments.b));
    if (arguments.common.json)
        print_json(arguments, *scene, a->pvs, b->pvs, *result);
    else
        print_text(arguments, *scene, a->pvs, b->pvs, *result);
    if (result->contradictions == 0)
        return 0;
    const Contradiction& first = result->first.front();
    return fail({ErrorCode::internal,
                 fmt::format("{} and {} contradict each other in {} pairs: {} lists object {} '{}'{} from its cell {}, and "
                             "only what is visible; {}, which lists all that is visible from there, does not (cell {}); do "
                             "not trust either, try `antumbra explain`",
                             arguments.a, arguments.b, result->contradictions,
                             first.a_sees ? arguments.a : arguments.b, first.object, scene->name(first.object),
                             part_of(*result, first.unit), first.a_sees ? first.cell_a : first.cell_b, first.a_sees ? arguments.b : arguments.a,
                             first.a_sees ? first.cell_b : first.cell_a)});
}

} // namespace

void add_compare(CLI::App& app) {
    auto arguments = std::make_shared<CompareArguments>();
    CLI::App& command = *app.add_subcommand("compare", "What each of two .pvs files sees that the other does not");
    arguments->scene.add_to(command);
    command.add_option("A", arguments->a, "A .pvs file")->required();
    command.add_option("B", arguments->b, "Another of the same scene")->required();
    command.add_option("--samples", arguments->options.viewpoints, "Viewpoints for the weight in pixels; 0: none")
        ->check(CLI::Range(0, 1 << 24))
        ->capture_default_str();
    command.add_option("--face-size", arguments->options.face_size, "Pixels along each of the six square pictures")
        ->check(CLI::Range(1, 8192))
        ->capture_default_str();
    command.add_option("--listed", arguments->options.listed, "Objects named for each file")->capture_default_str();
    add_common(command, arguments->common, "antumbra compare house.glb sampled.pvs exact.pvs",
               [arguments] { return run_compare(*arguments); });
}

} // namespace antumbra::app
