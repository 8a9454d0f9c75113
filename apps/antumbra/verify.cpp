#include "command.hpp"

namespace antumbra::app {
void add_verify(CLI::App&) {}
} // namespace antumbra::app
