#include "command.hpp"

#include "base/file.hpp"

#include <antumbra/evaluate.hpp>

#include <fmt/format.h>

#include <fstream>
#include <map>
#include <sstream>

namespace antumbra::app {
namespace {

struct ProveArguments {
    Common common;
    SceneArguments scene;
    std::string cull, pvs, table, size = "160x90";
    ProofOptions options;
};

constexpr const char* kHead = "scene,fingerprint,objects,triangles,method,guarantee,seed,size,truth_scale,aimed,frames,"
                              "objects_in_frustum,objects_hidden,culled_percent,pixels,aimed_lines,lost_objects,"
                              "lost_pixels,grazing_pixels,unconfirmed_pixels";

std::vector<std::string> split(const std::string& text) {
    std::vector<std::string> parts;
    std::stringstream stream(text);
    for (std::string part; std::getline(stream, part, ',');)
        parts.push_back(part);
    return parts;
}

std::string file_name(const std::string& path) {
    std::size_t slash = path.find_last_of("/\\");
    std::string name = slash == std::string::npos ? path : path.substr(slash + 1);
    for (char& c : name)
        c = c == ',' || c == '"' ? '_' : c;
    return name;
}

/// Rows by what they are about; a row of another scene or with other settings is left as it is.
class Table {
  public:
    Table(const ProveArguments& arguments, const Scene& scene) : arguments_(arguments), scene_(scene) {}

    Status read() {
        std::ifstream file(arguments_.table);
        std::string line;
        if (!file || !std::getline(file, line))
            return {}; // begins
        for (; line.starts_with('#') && file; std::getline(file, line)) // remarks: which commit, which machine
            remarks_ += line + "\n";
        if (!file)
            return {}; // nothing but remarks
        if (line != kHead)
            return {ErrorCode::usage, arguments_.table + ": is no table of antumbra prove; choose another file"};
        while (std::getline(file, line)) {
            std::vector<std::string> cells = split(line);
            if (cells.size() != 20)
                return {ErrorCode::corrupt, arguments_.table + ": '" + line + "' has not 20 columns; delete the line"};
            rows_[key_of(cells)] = line;
        }
        return {};
    }

    /// What the table holds of this scene with these settings.
    ProofResult known() const {
        ProofResult result;
        for (const auto& [key, line] : rows_) {
            std::vector<std::string> cells = split(line);
            ProofMethod method;
            method.name = cells[4];
            std::uint64_t* const numbers[] = {&method.frames, &method.in_frustum, &method.hidden, nullptr,
                                              &method.pixels, &method.aimed, &method.lost_objects, &method.lost_pixels,
                                              &method.grazing_pixels, &method.unconfirmed_pixels};
            for (std::size_t k = 0; k < std::size(numbers); ++k)
                if (numbers[k])
                    *numbers[k] = std::strtoull(cells[10 + k].c_str(), nullptr, 10);
            if (key == key_of(split(row(method))))
                result.methods.push_back(method);
        }
        return result;
    }

    Status write(const ProofResult& result) {
        for (const ProofMethod& method : result.methods)
            if (method.frames > 0)
                rows_[key_of(split(row(method)))] = row(method);
        std::string text = remarks_ + kHead + "\n";
        for (const auto& [key, line] : rows_)
            text += line + "\n";
        return write_file_atomically(arguments_.table, text);
    }

  private:
    static std::string key_of(const std::vector<std::string>& cells) {
        std::string key = cells[0];
        for (std::size_t column : {1, 4, 6, 7, 8, 9})
            key += "," + cells[column];
        return key;
    }

    std::string row(const ProofMethod& method) const {
        double culled = method.in_frustum > 0 ? 100 * double(method.hidden) / double(method.in_frustum) : 0;
        return fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{:.2f},{},{},{},{},{},{}", file_name(scene_.source()),
                           to_hex(scene_.fingerprint()), scene_.objects().size(), scene_.triangles().size(), method.name,
                           to_string(method.guarantee), arguments_.common.seed, arguments_.size,
                           arguments_.options.truth_scale, arguments_.options.aimed, method.frames, method.in_frustum,
                           method.hidden, culled, method.pixels, method.aimed, method.lost_objects, method.lost_pixels,
                           method.grazing_pixels, method.unconfirmed_pixels);
    }

    const ProveArguments& arguments_;
    const Scene& scene_;
    std::string remarks_; ///< lines with # before the head
    std::map<std::string, std::string> rows_;
};

Json to_json(const Scene& scene, const ProofResult& result) {
    Json document{{"scene", scene.source()}, {"fingerprint", to_hex(scene.fingerprint())}};
    document["methods"] = Json::array();
    for (const ProofMethod& method : result.methods)
        document["methods"].push_back({{"name", method.name},
                                       {"guarantee", to_string(method.guarantee)},
                                       {"frames", method.frames},
                                       {"objects_in_frustum", method.in_frustum},
                                       {"objects_hidden", method.hidden},
                                       {"pixels", method.pixels},
                                       {"aimed_lines", method.aimed},
                                       {"lost_objects", method.lost_objects},
                                       {"lost_pixels", method.lost_pixels},
                                       {"grazing_pixels", method.grazing_pixels},
                                       {"unconfirmed_pixels", method.unconfirmed_pixels}});
    document["losses"] = Json::array();
    for (const ProofLoss& loss : result.losses)
        document["losses"].push_back({{"method", loss.method},
                                      {"frame", loss.frame},
                                      {"eye", {loss.view.eye.x, loss.view.eye.y, loss.view.eye.z}},
                                      {"target", {loss.view.target.x, loss.view.target.y, loss.view.target.z}},
                                      {"object", loss.object},
                                      {"name", std::string(scene.name(loss.object))},
                                      {"pixels", loss.pixels}});
    return document;
}

void print_text(const Scene& scene, const ProofResult& result) {
    fmt::print("scene      {}: {} objects, {} triangles\n\n", scene.source(), scene.objects().size(),
               scene.triangles().size());
    fmt::print("{:<18}{:>8}{:>14}{:>10}{:>14}{:>12}{:>10}{:>10}{:>9}{:>13}\n", "method", "frames", "in frustum", "culled",
               "pixels", "aimed", "lost obj", "lost px", "grazing", "unconfirmed");
    for (const ProofMethod& m : result.methods)
        fmt::print("{:<18}{:>8}{:>14}{:>9.1f}%{:>14}{:>12}{:>10}{:>10}{:>9}{:>13}\n", m.name, m.frames, m.in_frustum,
                   m.in_frustum ? 100 * double(m.hidden) / double(m.in_frustum) : 0, m.pixels, m.aimed, m.lost_objects,
                   m.lost_pixels, m.grazing_pixels, m.unconfirmed_pixels);
    for (const ProofLoss& loss : result.losses)
        fmt::print("lost       {} frame {}: {} pixels of {} '{}' from {:.17g},{:.17g},{:.17g} (local)\n", loss.method,
                   loss.frame, loss.pixels, loss.object, scene.name(loss.object), loss.view.eye.x, loss.view.eye.y,
                   loss.view.eye.z);
}

int run_prove(ProveArguments& arguments) {
    ProofOptions& options = arguments.options;
    if (int end = 0; std::sscanf(arguments.size.c_str(), "%ux%u%n", &options.width, &options.height, &end) != 2 ||
                     std::size_t(end) != arguments.size.size())
        return fail({ErrorCode::usage, "--size wants WIDTHxHEIGHT such as 160x90, not '" + arguments.size + "'"});
    Result<Scene> scene = arguments.scene.load();
    if (!scene)
        return fail(scene.status());
    std::optional<PvsFile> baked;
    if (!arguments.pvs.empty()) {
        Result<PvsFile> opened = open_pvs(arguments.pvs, *scene);
        if (!opened)
            return fail(opened.status());
        options.pvs = &baked.emplace(std::move(*opened)).pvs;
    }
    options.seed = arguments.common.seed;
    if (!arguments.cull.empty() && arguments.cull != "all")
        options.methods = split(arguments.cull);
    ProofResult result;
    Table table(arguments, *scene);
    if (!arguments.table.empty()) {
        if (Status status = table.read(); !status)
            return fail(status);
        result = table.known();
        options.keep = [&](const ProofResult& so_far) { return table.write(so_far); };
    }
    if (Status status = prove(*scene, options, result, make_job(arguments.common)); !status)
        return fail(status);
    if (arguments.common.json)
        print_json(to_json(*scene, result));
    else
        print_text(*scene, result);
    for (const ProofMethod& method : result.methods)
        if (method.lost_pixels > 0 && !may_lose_pixels(method.guarantee))
            return fail({ErrorCode::internal,
                         fmt::format("{}: method '{}' promises to be {}, but lost {} confirmed pixels of {} objects; "
                                     "please report this with the scene and the seed",
                                     arguments.scene.path, method.name, to_string(method.guarantee), method.lost_pixels,
                                     method.lost_objects)});
    return 0;
}

} // namespace

void add_prove(CLI::App& app) {
    auto arguments = std::make_shared<ProveArguments>();
    ProofOptions& options = arguments->options;
    CLI::App& command = *app.add_subcommand(
        "prove", "Random frames of every method against the truth: was a pixel lost? Goes on where it stopped");
    arguments->scene.add_to(command);
    command.add_option("--cull", arguments->cull, "Methods, by commas, or all [all]");
    command.add_option("--pvs", arguments->pvs, "The .pvs file of the method pvs");
    command.add_option("--random-frames", options.frames, "Frames, rounded up to blocks of 64")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    command.add_option("--size", arguments->size, "Width and height of the picture")->capture_default_str();
    command.add_option("--truth-scale", options.truth_scale, "The truth has that many times the picture's sides")
        ->check(CLI::Range(1, 8))
        ->capture_default_str();
    command.add_option("--aimed", options.aimed, "Lines of sight per frame and method aimed at what it hides")
        ->capture_default_str();
    command.add_option("--occluders", options.occluders, "Occluders per frame, for methods that choose some [theirs]");
    command.add_option("-o,--table", arguments->table,
                       "Table (.csv) of what is proved: kept after every block, read again by the next run; lines with # before its head stay");
    add_common(command, arguments->common, "antumbra prove house.glb --random-frames 2000 -o proof.csv",
               [arguments] { return run_prove(*arguments); });
}

} // namespace antumbra::app
