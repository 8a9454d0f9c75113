#include "command.hpp"

namespace antumbra::app {
void add_generate(CLI::App&) {}
} // namespace antumbra::app
