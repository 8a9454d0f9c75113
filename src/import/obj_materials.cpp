#include "import/obj_materials.hpp"

#include "import/text.hpp"

#include <charconv>

namespace antumbra {
namespace {

/// The last number of the line: "d -halo 0.5" has an option before it. `fallback` if there is none.
double last_number(std::string_view line, double fallback) {
    double value = fallback;
    for (std::string_view word = next_word(line); !word.empty(); word = next_word(line)) {
        double read = 0;
        if (std::from_chars(word.data(), word.data() + word.size(), read).ec == std::errc())
            value = read;
    }
    return value;
}

} // namespace

void ObjMaterials::read(std::span<const std::byte> text) {
    Material* current = nullptr;
    Lines lines(text);
    for (std::string_view line; lines.next(line);) {
        std::string_view key = next_word(line);
        if (key == "newmtl") {
            current = &materials_[std::string(trimmed(line))];
        } else if (current && key == "d") {
            current->opacity = last_number(line, 0);
            current->has_opacity = true;
        } else if (current && key == "Tr") {
            current->transparency = last_number(line, 1);
        } else if (current && key == "map_d") {
            current->has_map = true;
        }
    }
}

bool ObjMaterials::see_through(const std::string& material) const {
    auto found = materials_.find(material);
    if (found == materials_.end())
        return false;
    const Material& m = found->second;
    // Negated, so that NaN counts as see-through.
    return m.has_map || (m.has_opacity ? !(m.opacity >= 1) : !(m.transparency <= 0));
}

} // namespace antumbra
