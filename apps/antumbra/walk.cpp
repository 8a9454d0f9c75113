#include "command.hpp"

namespace antumbra::app {
void add_walk(CLI::App&) {}
} // namespace antumbra::app
