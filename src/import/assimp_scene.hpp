// Formats that assimp reads for us. Built without it (ANTUMBRA_WITH_ASSIMP=OFF), every call is unsupported.
#pragma once

#include <antumbra/import.hpp>

namespace antumbra {

/// Is this file ending (lower case, without a dot) one of those that go through assimp?
bool is_assimp_ending(const std::string& ending);

} // namespace antumbra
