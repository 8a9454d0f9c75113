#include "import/quake3_entities.hpp"

#include "import/text.hpp"

#include <algorithm>
#include <charconv>

namespace antumbra {
namespace {

bool read_vector(std::string_view text, Vec3d& v) {
    Vec3d read;
    for (int k = 0; k < 3; ++k) {
        std::string_view word = next_word(text);
        auto [rest, error] = std::from_chars(word.data(), word.data() + word.size(), read[k]);
        if (error != std::errc())
            return false;
    }
    if (!is_finite(read))
        return false;
    v = read;
    return true;
}

std::size_t model_number(std::string_view text) {
    std::size_t number = 0;
    if (text.size() < 2 || text[0] != '*')
        return 0;
    auto [rest, error] = std::from_chars(text.data() + 1, text.data() + text.size(), number);
    return error == std::errc() ? number : 0;
}

} // namespace

std::vector<Vec3d> model_origins(std::span<const std::byte> entities, std::size_t count) {
    std::vector<Vec3d> origins(count);
    std::string_view text(reinterpret_cast<const char*>(entities.data()), entities.size());
    std::string_view key;
    bool is_key = true;
    Vec3d origin;
    std::size_t model = 0;
    for (std::size_t at = 0; at < text.size(); ++at) {
        if (text[at] == '"') {
            std::size_t end = std::min(text.find('"', at + 1), text.size());
            std::string_view word = text.substr(at + 1, end - at - 1);
            at = end;
            if (!is_key && key == "origin")
                read_vector(word, origin);
            else if (!is_key && key == "model")
                model = model_number(word);
            key = word;
            is_key = !is_key;
        } else if (text[at] == '{' || text[at] == '}') {
            if (model > 0 && model < count)
                origins[model] = origin;
            origin = {};
            model = 0;
            is_key = true;
        }
    }
    return origins;
}

} // namespace antumbra
