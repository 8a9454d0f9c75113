#include "command.hpp"

namespace antumbra::app {
void add_query(CLI::App&) {}
} // namespace antumbra::app
