#include "command.hpp"

namespace antumbra::app {
void add_bake(CLI::App&) {}
} // namespace antumbra::app
