// Options of a bake that contradict themselves or make no sense.
#pragma once

#include <antumbra/bake.hpp>

namespace antumbra {

/// ErrorCode::usage or limit, in words.
Status check_options(const BakeOptions& options);

} // namespace antumbra
