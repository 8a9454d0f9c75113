// Procedural scenes in the manner of the papers. Deterministic: the same call gives the same scene
// everywhere.
#pragma once

#include <antumbra/scene.hpp>

namespace antumbra {

struct GenerateOptions {
    std::uint64_t triangles = 0; ///< wanted size, where the kind can scale; 0: the size of the paper's scene
    std::uint64_t seed = 1;
    std::uint32_t copies = 1; ///< apartment only: this many equal flats, six above each other, 11 m apart
    std::uint32_t storeys = 0; ///< office only: so many; 0: in proportion to the size
    std::uint32_t plants = 0;  ///< office only: exactly so many, spread at random; 0: in proportion to the size
};

/// Names that generate() knows, in alphabetical order.
std::span<const std::string_view> generator_names();

/// ErrorCode::usage for an unknown kind (the message lists the known ones), or a size or number of copies
/// that it cannot make.
Result<RawScene> generate(std::string_view kind, const GenerateOptions& options = {});

} // namespace antumbra
