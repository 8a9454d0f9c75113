#include "command.hpp"
#include "view_server.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>
#include <spawn.h>

extern char** environ;

namespace antumbra::app {
namespace {

constexpr int kUsualPort = 8017;

struct ViewArguments {
    Common common;
    SceneArguments scene;
    std::string pvs;
    int port = -1; ///< -1: the usual one, or any other
    bool no_open = false;
};

/// Asks the desktop to show an address. Whether there is one is not our business: the address was printed.
void open_in_browser(const std::string& address) {
    if (!std::getenv("DISPLAY") && !std::getenv("WAYLAND_DISPLAY"))
        return;
    std::string program = "xdg-open", argument = address;
    char* arguments[] = {program.data(), argument.data(), nullptr};
    pid_t child = 0;
    (void)posix_spawnp(&child, "xdg-open", nullptr, nullptr, arguments, environ);
}

int run_view(const ViewArguments& arguments) {
    Job job = make_job(arguments.common); // Ctrl-C
    Result<Scene> scene = arguments.scene.load();
    if (!scene)
        return fail(scene.status());
    Result<std::unique_ptr<ViewedScene>> viewed = open_viewed(std::move(*scene), arguments.scene.path, arguments.pvs);
    if (!viewed)
        return fail(viewed.status());
    (*viewed)->threads = arguments.common.threads;
    ViewServer server(**viewed);
    Result<int> port = server.bind(arguments.port < 0 ? kUsualPort : arguments.port, arguments.port < 0);
    if (!port)
        return fail(port.status());
    std::string address = fmt::format("http://127.0.0.1:{}/", *port);
    if (arguments.common.json)
        print_json({{"url", address}, {"port", *port}, {"objects", (*viewed)->scene.objects().size()}});
    else
        fmt::print("{}\n", address);
    std::fflush(stdout);
    note("only this computer can reach it; Ctrl-C stops");
    if (!arguments.no_open)
        open_in_browser(address);
    server.serve(*job.cancel);
    return 0;
}

} // namespace

void add_view(CLI::App& app) {
    auto arguments = std::make_shared<ViewArguments>();
    CLI::App& command = *app.add_subcommand("view", "The viewer in a browser: walk, freeze the culling, see what is hidden and why");
    arguments->scene.add_to(command);
    command.add_option("PVS", arguments->pvs, "A bake of the scene: .pvs");
    command.add_option("--port", arguments->port, "Port on 127.0.0.1; 0: any; without: 8017 or any")
        ->check(CLI::Range(0, 65535));
    command.add_flag("--no-open", arguments->no_open, "Print the address, open no browser");
    add_common(command, arguments->common, "antumbra view house.glb house.pvs", [arguments] { return run_view(*arguments); });
}

} // namespace antumbra::app
