#include "command.hpp"

#include <fmt/format.h>

#include <csignal>
#include <unistd.h>

namespace {

// Files are mapped, not copied. One that another program cuts short meanwhile can only be met here, where it is too late
// to do more than to say so.
extern "C" void on_lost_bytes(int) {
    static constexpr char words[] =
        "antumbra: a file was made shorter by another program while it was read; nothing was written, try again\n";
    [[maybe_unused]] ssize_t done = ::write(STDERR_FILENO, words, sizeof words - 1);
    ::_exit(1);
}

} // namespace

int main(int argc, char** argv) {
    using namespace antumbra::app;
    CLI::App app("Antumbra: what can be seen from here?", "antumbra");
    app.require_subcommand(1);
    std::signal(SIGBUS, on_lost_bytes);
    app.set_version_flag("--version", ANTUMBRA_VERSION);
    app.failure_message([](const CLI::App*, const CLI::Error& error) {
        return fmt::format("antumbra: {}; see --help\n", error.what());
    });
    add_info(app);
    add_generate(app);
    add_bake(app);
    add_query(app);
    add_inspect(app);
    add_verify(app);
    add_explain(app);
    add_compare(app);
    add_merge(app);
    add_split(app);
    add_walk(app);
    add_prove(app);
    add_cull(app);
    add_occluders(app);
    add_prepare(app);
#ifdef ANTUMBRA_VIEWER
    add_view(app);
#endif
    try {
        app.parse(argc, argv);
    } catch (const CLI::RuntimeError& error) {
        return error.get_exit_code();
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : 2;
    } catch (const std::exception& error) {
        fmt::print(stderr, "antumbra: {}\n", error.what());
        return 1;
    }
    return 0;
}
