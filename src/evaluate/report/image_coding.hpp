// Pictures and bytes as text that a page can hold.
#pragma once

#include "evaluate/gl/drawing.hpp"

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace antumbra {

/// A PNG file in memory, 8-bit RGB. Empty if libpng refuses (only for a picture without pixels).
std::vector<std::byte> encode_png(const Image& image);

/// RFC 4648, with padding.
std::string to_base64(std::span<const std::byte> bytes);

} // namespace antumbra
