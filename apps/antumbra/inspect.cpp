#include "command.hpp"

namespace antumbra::app {
void add_inspect(CLI::App&) {}
} // namespace antumbra::app
