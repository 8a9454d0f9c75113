#include "command.hpp"

#include <antumbra/evaluate.hpp>

#include <fmt/format.h>

#include <charconv>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <unistd.h>

namespace antumbra::app {
namespace {

std::atomic<bool> interrupted{false};

extern "C" void on_interrupt(int) {
    // A second Ctrl-C does not wait for the units under way.
    if (interrupted.exchange(true))
        ::_exit(130);
}

using Clock = std::chrono::steady_clock;

/// Prints at most ten bars a second on a terminal, one line every ten seconds elsewhere.
class ProgressPrinter {
  public:
    void operator()(const Progress& progress) {
        Clock::time_point now = Clock::now();
        if (progress.stage != stage_) {
            stage_ = progress.stage;
            start_ = last_ = now;
            first_ = progress.done;
        }
        bool finished = progress.done >= progress.total;
        double pause = terminal_ ? 0.1 : 10.0;
        if (!finished && std::chrono::duration<double>(now - last_).count() < pause)
            return;
        last_ = now;
        double seconds = std::chrono::duration<double>(now - start_).count();
        double rate = seconds > 0 ? double(progress.done - first_) / seconds : 0;
        double share = progress.total ? double(progress.done) / double(progress.total) : 1;
        std::string rest = rate > 0 ? fmt::format("{:.4g} {}/s, {} left", rate, progress.unit,
                                                  duration(double(progress.total - progress.done) / rate))
                                    : std::string();
        if (finished)
            rest = fmt::format("{:.4g} {}/s, took {}", rate, progress.unit, duration(seconds));
        if (terminal_) {
            int filled = static_cast<int>(share * 30);
            fmt::print(stderr, "\r\033[K{} [{:#<{}}{:.<{}}] {:3.0f}% {}{}", stage_, "", filled, "", 30 - filled,
                       share * 100, rest, finished ? "\n" : "");
            std::fflush(stderr);
        } else {
            fmt::print(stderr, "{}: {}/{} {} ({:.0f}%) {}\n", stage_, progress.done, progress.total,
                       progress.unit, share * 100, rest);
        }
    }

  private:
    static std::string duration(double seconds) {
        auto whole = static_cast<long>(seconds);
        if (whole < 60)
            return fmt::format("{:.1f} s", seconds);
        if (whole < 3600)
            return fmt::format("{} min {:02} s", whole / 60, whole % 60);
        return fmt::format("{} h {:02} min", whole / 3600, whole / 60 % 60);
    }

    bool terminal_ = ::isatty(STDERR_FILENO) != 0;
    std::string stage_;
    Clock::time_point start_, last_;
    std::uint64_t first_ = 0;
};

} // namespace

void add_common(CLI::App& command, Common& common, const std::string& example, Command run) {
    command.add_flag("--json", common.json, "Print one JSON document on stdout");
    command.add_option("--threads", common.threads, "Worker threads; 0 means all")->capture_default_str();
    command.add_option("--seed", common.seed, "Seed of everything that is sampled")->capture_default_str();
    command.footer("Example:\n  " + example);
    command.final_callback([run = std::move(run)] {
        if (int code = run())
            throw CLI::RuntimeError(code);
    });
}

int fail(const Status& status) {
    fmt::print(stderr, "antumbra: {}\n", status.message());
    return status.code() == ErrorCode::usage ? 2 : 1;
}

void note(const std::string& text) { fmt::print(stderr, "note: {}\n", text); }

void print_json(const Json& document) {
    // Names come from files and need not be UTF-8.
    fmt::print("{}\n", document.dump(2, ' ', false, Json::error_handler_t::replace));
}

Job make_job(const Common& common) {
    std::signal(SIGINT, on_interrupt);
    std::signal(SIGTERM, on_interrupt);
    Job job;
    job.threads = common.threads;
    job.cancel = &interrupted;
    job.progress = [printer = std::make_shared<ProgressPrinter>()](const Progress& progress) { (*printer)(progress); };
    return job;
}

void SceneArguments::add_to(CLI::App& command) {
    command.add_option("SCENE", path, "Scene file: .glb, .gltf, .obj, .ply, .stl, .bsp, .off, .dae, .3ds or .fbx")->required();
    command.add_option("--sides", sides, "Which sides of a face are drawn")
        ->check(CLI::IsMember({"material", "both"}))
        ->capture_default_str();
    command.add_option("--up-axis", up_axis, "The axis of the file that points up")
        ->check(CLI::IsMember({"y", "z"}))
        ->capture_default_str();
    command.add_option("--never-cull", never_cull, "Objects by name pattern that stay visible (* and ?)");
    command.add_option("--never-occlude", never_occlude, "Objects by name pattern that hide nothing");
    command.add_option("--ignore", ignore, "Objects by name pattern to leave out");
    command.add_option("--crack-width", crack_width,
                       "Close cracks up to so wide (scene units): answers are then those of the repaired scene, not for sight "
                       "lines through such cracks")
        ->check(CLI::Range(0.0, 1e30));
    command.add_option("--max-triangles", limits.triangles, "Refuse scenes with more triangles")
        ->capture_default_str();
    command.add_option("--max-bytes", limits.bytes, "Refuse files with more bytes")->capture_default_str();
}

Result<Scene> SceneArguments::load() const {
    ImportOptions import_options;
    import_options.limits = limits;
    import_options.up_axis = up_axis == "z" ? UpAxis::z : UpAxis::y;
    SceneOptions scene_options;
    scene_options.sides = sides == "both" ? SidesOption::both : SidesOption::material;
    scene_options.never_cull = never_cull;
    scene_options.never_occlude = never_occlude;
    scene_options.ignore = ignore;
    scene_options.crack_width = crack_width;
    scene_options.count_cracks = count_cracks;
    return load_scene(path, import_options, scene_options);
}

Result<PvsFile> open_pvs(const std::string& path) {
    Result<MappedFile> file = MappedFile::open(path);
    if (!file)
        return file.status();
    Result<Pvs> pvs = Pvs::open(file->bytes());
    if (!pvs)
        return pvs.status().in(path);
    return PvsFile{std::move(*file), std::move(*pvs)};
}

Result<PvsFile> open_pvs(const std::string& path, const Scene& scene) {
    Result<PvsFile> opened = open_pvs(path);
    if (!opened)
        return opened;
    if (Status status = check_belongs(scene, opened->pvs); !status)
        return status.in(path);
    return opened;
}

void add_occluder_choice(CLI::App& command, std::string& words) {
    command.add_option("--occluder-choice", words,
                       "How planes, tree and opacity methods choose: area-angle, projected-size or first-hit (from a prepared --pvs); "
                       "masked and hzb always go by projected size")
        ->check(CLI::IsMember({"area-angle", "projected-size", "first-hit"}))
        ->capture_default_str();
}

OccluderChoice parse_occluder_choice(const std::string& words) {
    return words == "first-hit"        ? OccluderChoice::first_hit
           : words == "projected-size" ? OccluderChoice::projected_size
                                       : OccluderChoice::area_angle;
}

Result<Vec3d> parse_vec3(const std::string& text, const char* option) {
    Vec3d value;
    const char* at = text.data();
    const char* end = at + text.size();
    for (int k = 0; k < 3; ++k) {
        if (k > 0 && (at == end || *at++ != ','))
            return Status(ErrorCode::usage, std::string(option) + " wants three numbers X,Y,Z, not '" + text + "'");
        auto [rest, error] = std::from_chars(at, end, value[k]);
        if (error != std::errc())
            return Status(ErrorCode::usage, std::string(option) + " wants three numbers X,Y,Z, not '" + text + "'");
        at = rest;
    }
    if (at != end)
        return Status(ErrorCode::usage, std::string(option) + " wants three numbers X,Y,Z, not '" + text + "'");
    return value;
}

} // namespace antumbra::app
