#include "command.hpp"

#include "bake/exact/certificate_file.hpp"
#include "base/file.hpp"

#include <antumbra/evaluate.hpp>

#include <fmt/format.h>

namespace antumbra::app {
namespace {

struct VerifyArguments {
    Common common;
    SceneArguments scene;
    std::string pvs, proof;
    VerifyOptions options;
    bool certificates = false;
    CertificateOptions certificate_options;
};

Json to_json(const Scene& scene, const Pvs& pvs, const VerifyResult& result) {
    Json document;
    document["guarantee"] = to_string(pvs.guarantee());
    document["viewpoints"] = result.viewpoints;
    document["pixels"] = result.pixels;
    document["false_invisible_objects"] = result.false_invisible_objects;
    document["false_invisible_pixels"] = result.false_invisible_pixels;
    document["false_visible_objects"] = result.false_visible_objects;
    document["grazing_pixels"] = result.grazing_pixels;
    document["unconfirmed_pixels"] = result.unconfirmed_pixels;
    document["reported_objects"] = result.reported_objects;
    document["seen_objects"] = result.seen_objects;
    document["points_in_matter"] = result.in_matter;
    document["worst"] = Json::array();
    for (const FalseInvisible& one : result.worst)
        document["worst"].push_back({{"eye", {one.eye.x, one.eye.y, one.eye.z}},
                                     {"object", one.object},
                                     {"name", std::string(scene.name(one.object))},
                                     {"cell", one.cell},
                                     {"pixels", one.pixels}});
    return document;
}

void print_text(const Scene& scene, const Pvs& pvs, const VerifyResult& result) {
    double n = double(result.viewpoints);
    fmt::print("guarantee        {}\n", describe_guarantee(pvs));
    fmt::print("viewpoints       {}, {} pixels\n", result.viewpoints, result.pixels);
    fmt::print("false invisible  {} objects, {} pixels ({:.3g} of all)\n", result.false_invisible_objects,
               result.false_invisible_pixels, double(result.false_invisible_pixels) / double(result.pixels));
    fmt::print("not confirmed    {} pixels graze an edge, {} are blocked after all\n", result.grazing_pixels,
               result.unconfirmed_pixels);
    fmt::print("per viewpoint    {:.1f} objects reported, {:.1f} seen, {:.1f} false visible\n",
               double(result.reported_objects) / n, double(result.seen_objects) / n,
               double(result.false_visible_objects) / n);
    for (const FalseInvisible& one : result.worst)
        fmt::print("worst            {:6} pixels of {} '{}' from {:.17g},{:.17g},{:.17g}\n", one.pixels, one.object,
                   scene.name(one.object), one.eye.x, one.eye.y, one.eye.z);
}

/// What both kinds of certificate results count.
template <class Counts>
void add_proofs(Json& document, const Counts& counts) {
    document["pairs"] = counts.pairs;
    document["proved_visible"] = counts.visible;
    document["proved_hidden"] = counts.hidden;
    document["visible_by_definition"] = counts.by_definition;
    document["undecided"] = counts.undecided;
    document["trees"] = counts.trees;
    document["nodes"] = counts.nodes;
    document["rejected"] = counts.rejected;
}

template <class Counts>
std::string proofs_as_text(const Counts& counts) {
    return fmt::format("{} visible by a witness, {} hidden by {} trees of {} nodes in all, {} touch their cell, {} undecided",
                       counts.visible, counts.hidden, counts.trees, counts.nodes, counts.by_definition, counts.undecided);
}

/// Random (cell, object) pairs proved again, the proofs checked by the independent verifier.
int run_certificates(const VerifyArguments& arguments, const Scene& scene, const Pvs& pvs) {
    Result<CertificateResult> result =
        check_certificates(scene, pvs, arguments.certificate_options, make_job(arguments.common));
    if (!result)
        return fail(result.status().in(arguments.pvs));
    if (arguments.common.json) {
        Json document;
        document["guarantee"] = to_string(pvs.guarantee());
        add_proofs(document, *result);
        document["listed_but_hidden"] = result->listed_but_hidden;
        document["visible_but_unlisted"] = result->visible_but_unlisted;
        document["first_problem"] = result->first_problem;
        print_json(document);
    } else {
        fmt::print("guarantee  {}\n", describe_guarantee(pvs));
        fmt::print("proved     {} pairs: {}\n", result->pairs, proofs_as_text(*result));
        fmt::print("rejected   {} proofs\n", result->rejected);
        fmt::print("the file   lists {} hidden objects and lacks {} visible ones\n", result->listed_but_hidden,
                   result->visible_but_unlisted);
    }
    Guarantee guarantee = pvs.guarantee();
    bool may_list_hidden = guarantee == Guarantee::conservative || guarantee == Guarantee::approximate;
    bool broken = result->rejected || (result->listed_but_hidden && !may_list_hidden) ||
                  (result->visible_but_unlisted && !may_lose_pixels(guarantee));
    return broken ? fail({ErrorCode::internal, arguments.pvs + ": " + result->first_problem +
                                                   "; do not trust the file, and please report how it was baked"})
                  : 0;
}

/// Certificates stored with the bake, all of them, checked without the solver.
int run_stored_certificates(const VerifyArguments& arguments, const Scene& scene, const Pvs& pvs,
                            std::span<const std::byte> pvs_bytes, const std::string& path) {
    Result<MappedFile> file = MappedFile::open(path);
    if (!file)
        return fail(file.status());
    Result<CertificateFileResult> result =
        check_certificate_file(scene, pvs, pvs_bytes, file->bytes(), make_job(arguments.common));
    if (!result)
        return fail(result.status().in(path));
    if (arguments.common.json) {
        Json document;
        document["guarantee"] = to_string(pvs.guarantee());
        document["stored"] = path;
        document["cells"] = result->cells;
        add_proofs(document, *result);
        document["bytes"] = result->bytes;
        document["disagree"] = result->disagree;
        document["first_problem"] = result->first_problem;
        print_json(document);
    } else {
        fmt::print("guarantee  {}\n", describe_guarantee(pvs));
        fmt::print("stored     {}: all {} pairs of {} cells: {}\n", path, result->pairs, result->cells,
                   proofs_as_text(*result));
        fmt::print("rejected   {} proofs; {} pairs are listed otherwise\n", result->rejected, result->disagree);
    }
    if (result->rejected + result->disagree == 0)
        return 0;
    return fail({ErrorCode::internal, path + ": " + result->first_problem +
                                          "; do not trust the file, and please report how it was baked"});
}

int run_verify(VerifyArguments& arguments) {
    Result<Scene> scene = arguments.scene.load();
    if (!scene)
        return fail(scene.status());
    Result<PvsFile> opened = open_pvs(arguments.pvs);
    if (!opened)
        return fail(opened.status());
    const Pvs& pvs = opened->pvs;
    arguments.certificate_options.seed = arguments.common.seed;
    std::string stored = arguments.proof.empty() ? arguments.pvs + ".proof" : arguments.proof;
    if (arguments.certificates && (!arguments.proof.empty() || file_exists(stored)))
        return run_stored_certificates(arguments, *scene, pvs, opened->bytes(), stored);
    if (arguments.certificates)
        return run_certificates(arguments, *scene, pvs);
    arguments.options.seed = arguments.common.seed;
    Result<VerifyResult> result = verify(*scene, pvs, arguments.options, make_job(arguments.common));
    if (!result)
        return fail(result.status().in(arguments.pvs));
    if (arguments.common.json)
        print_json(to_json(*scene, pvs, *result));
    else
        print_text(*scene, pvs, *result);
    if (result->false_invisible_pixels == 0 || may_lose_pixels(pvs.guarantee()))
        return 0;
    return fail({ErrorCode::internal,
                 fmt::format("{}: promises to be {}, but hides {} objects that {} confirmed pixels see; do not use the "
                             "file, and please report how it was baked",
                             arguments.pvs, describe_guarantee(pvs), result->false_invisible_objects,
                             result->false_invisible_pixels)});
}

} // namespace

void add_verify(CLI::App& app) {
    auto arguments = std::make_shared<VerifyArguments>();
    CLI::App& command = *app.add_subcommand("verify", "Random viewpoints of a .pvs file against the truth by rays");
    arguments->scene.add_to(command);
    command.add_option("PVS", arguments->pvs, "The .pvs file")->required();
    command.add_option("--samples", arguments->options.samples, "Viewpoints")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    command.add_option("--face-size", arguments->options.face_size, "Pixels along each of the six square pictures")
        ->check(CLI::Range(1, 8192))
        ->capture_default_str();
    command.add_flag("--certificates", arguments->certificates,
                     "Check the certificates stored in PVS.proof; without that file prove random (cell, object) pairs "
                     "exactly and check those proofs. Instead of viewpoints");
    command.add_option("--proof", arguments->proof, "The file of certificates, if it is not PVS.proof");
    command.add_option("--pairs", arguments->certificate_options.pairs, "How many pairs --certificates proves")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    add_common(command, arguments->common, "antumbra verify house.glb house.pvs --samples 500",
               [arguments] { return run_verify(*arguments); });
}

} // namespace antumbra::app
