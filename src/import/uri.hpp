// Where a scene file may send us for its other files: into its own folder, nowhere else.
#pragma once

#include <antumbra/status.hpp>

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace antumbra {

/// Text with every %XX replaced by its byte; nothing for a broken escape.
std::optional<std::string> percent_decoded(std::string_view text);

/// The path of the file that `relative` (already decoded) names inside `folder`. ErrorCode::unsupported for
/// absolute paths, schemes, drives, `..`, backslashes, control characters and for links that lead out of the
/// folder; io if there is no such file. `folder` "" allows nothing.
Result<std::string> path_inside(const std::string& folder, const std::string& relative);

/// The bytes of a "data:" URI, base64 or percent-encoded. Memory: at most 3/4 of the text, or 1.
Result<std::vector<std::byte>> data_of_uri(std::string_view uri);

/// The folder of a path, "." for a bare name.
std::string folder_of(const std::string& path);

} // namespace antumbra
