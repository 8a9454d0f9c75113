#include "command.hpp"

#include <fmt/format.h>

int main(int argc, char** argv) {
    using namespace antumbra::app;
    CLI::App app("Antumbra: what can be seen from here?", "antumbra");
    app.require_subcommand(1);
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
