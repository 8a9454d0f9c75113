// What the commands share. One file per command; main.cpp lists them.
#pragma once

#include "base/file.hpp"

#include <antumbra/cull.hpp>
#include <antumbra/import.hpp>
#include <antumbra/job.hpp>
#include <antumbra/pvs.hpp>
#include <antumbra/scene.hpp>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace antumbra::app {

/// Every key of a --json document keeps the order in which it was written.
using Json = nlohmann::ordered_json;

/// Options that every command has.
struct Common {
    bool json = false;
    unsigned threads = 0;
    std::uint64_t seed = 1;
};

/// A command returns the exit code: 0, or the Status of what failed through fail().
using Command = std::function<int()>;

/// Adds --json, --threads, --seed, the footer with `example`, and `run` as what the command does.
void add_common(CLI::App& command, Common& common, const std::string& example, Command run);

/// Prints "antumbra: message" on stderr; 2 for ErrorCode::usage, else 1.
int fail(const Status& status);

/// A note for the user: stderr, one line.
void note(const std::string& text);

/// The one document on stdout.
void print_json(const Json& document);

/// A job that honours --threads and Ctrl-C and shows progress: a bar with rate and time left on a terminal, plain
/// lines otherwise, always on stderr.
Job make_job(const Common& common);

/// Options that choose and read a scene.
struct SceneArguments {
    std::string path;
    std::string sides = "material", up_axis = "y";
    std::vector<std::string> never_cull, never_occlude, ignore;
    double crack_width = 0;
    bool count_cracks = false; ///< for commands that tell of them
    ImportLimits limits;
    void add_to(CLI::App& command);
    Result<Scene> load() const;
};

/// A baked file and what is in it; movable.
struct PvsFile {
    MappedFile file; ///< pvs refers to its bytes
    Pvs pvs;
    std::span<const std::byte> bytes() const { return file.bytes(); }
};

/// Opens `path`; errors name it.
Result<PvsFile> open_pvs(const std::string& path);
/// The same, refused with ErrorCode::mismatch unless it was baked from `scene`.
Result<PvsFile> open_pvs(const std::string& path, const Scene& scene);

/// --occluder-choice, and what its words mean.
void add_occluder_choice(CLI::App& command, std::string& words);
OccluderChoice parse_occluder_choice(const std::string& words);

/// "X,Y,Z" to a vector; ErrorCode::usage names the option.
Result<Vec3d> parse_vec3(const std::string& text, const char* option);

void add_info(CLI::App& app);
void add_generate(CLI::App& app);
void add_bake(CLI::App& app);
void add_query(CLI::App& app);
void add_inspect(CLI::App& app);
void add_verify(CLI::App& app);
void add_explain(CLI::App& app);
void add_compare(CLI::App& app);
void add_merge(CLI::App& app);
void add_split(CLI::App& app);
void add_walk(CLI::App& app);
void add_prove(CLI::App& app);
void add_cull(CLI::App& app);
void add_occluders(CLI::App& app);
void add_prepare(CLI::App& app);
void add_view(CLI::App& app);

} // namespace antumbra::app
