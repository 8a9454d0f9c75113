// One function per kind; generate() chooses.
#pragma once

#include <antumbra/generate.hpp>

namespace antumbra::generation {

/// Two furnished rooms: 159 objects (Gotsman, Sudarsky, Fayman 1999, section 8). No size but this one.
Result<RawScene> apartment(const GenerateOptions& options);
/// Storeys of rooms along a corridor, with stairs and plants (Bittner, Havran, Slavik 1998, section 7).
Result<RawScene> office(const GenerateOptions& options);

} // namespace antumbra::generation
