#include "import/uri.hpp"

#include "base/file.hpp"

#include <array>
#include <cstdint>

namespace antumbra {
namespace {

int hex_digit(char c) {
    if (c >= '0' && c <= '9')
        return c - '0';
    if (c >= 'a' && c <= 'f')
        return c - 'a' + 10;
    return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

int base64_digit(char c) {
    if (c >= 'A' && c <= 'Z')
        return c - 'A';
    if (c >= 'a' && c <= 'z')
        return c - 'a' + 26;
    if (c >= '0' && c <= '9')
        return c - '0' + 52;
    // Both alphabets of RFC 4648.
    return c == '+' || c == '-' ? 62 : c == '/' || c == '_' ? 63 : -1;
}

Status refused(const std::string& relative, const char* why) {
    std::string shown = relative.substr(0, 200);
    for (char& c : shown)
        c = static_cast<unsigned char>(c) < 0x20 ? '?' : c;
    return {ErrorCode::unsupported, "'" + shown + "': " + why + "; only files below the scene's own folder are read"};
}

const char* why_refused(const std::string& relative) {
    if (relative.empty())
        return "the path is empty";
    if (relative.front() == '/' || relative.front() == '~')
        return "the path is absolute";
    for (char c : relative)
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F || c == '\\')
            return "the path holds a backslash or control character";
    // A colon before the first slash is a scheme ("http:", "file:") or a drive ("C:").
    if (relative.find(':') < relative.find('/'))
        return "the path names a scheme or a drive";
    for (std::size_t begin = 0; begin <= relative.size();) {
        std::size_t end = std::min(relative.find('/', begin), relative.size());
        if (relative.substr(begin, end - begin) == "..")
            return "the path holds '..'";
        begin = end + 1;
    }
    return nullptr;
}

std::optional<std::vector<std::byte>> base64_decoded(std::string_view text) {
    std::vector<std::byte> bytes;
    bytes.reserve(text.size() / 4 * 3 + 3);
    while (!text.empty() && text.back() == '=')
        text.remove_suffix(1);
    std::uint32_t bits = 0;
    int count = 0;
    for (char c : text) {
        int digit = base64_digit(c);
        if (digit < 0)
            return std::nullopt;
        bits = bits << 6 | static_cast<std::uint32_t>(digit);
        count += 6;
        if (count >= 8) {
            count -= 8;
            bytes.push_back(static_cast<std::byte>(bits >> count & 0xFF));
        }
    }
    if (text.size() % 4 == 1)
        return std::nullopt;
    return bytes;
}

} // namespace

std::optional<std::string> percent_decoded(std::string_view text) {
    std::string decoded;
    decoded.reserve(text.size());
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] != '%') {
            decoded += text[i];
            continue;
        }
        int high = i + 2 < text.size() ? hex_digit(text[i + 1]) : -1;
        int low = high >= 0 ? hex_digit(text[i + 2]) : -1;
        if (low < 0)
            return std::nullopt;
        decoded += static_cast<char>(high * 16 + low);
        i += 2;
    }
    return decoded;
}

Result<std::string> path_inside(const std::string& folder, const std::string& relative) {
    if (const char* why = why_refused(relative))
        return refused(relative, why);
    if (folder.empty())
        return refused(relative, "a scene read from memory has no folder");
    Result<std::string> base = real_path(folder);
    if (!base)
        return base;
    Result<std::string> path = real_path(folder + "/" + relative);
    if (!path)
        return path;
    if (base->back() != '/')
        *base += '/';
    if (path->compare(0, base->size(), *base) != 0)
        return refused(relative, "the path leads out of the folder through a link");
    return path;
}

Result<std::vector<std::byte>> data_of_uri(std::string_view uri) {
    std::size_t comma = uri.find(',');
    if (comma == std::string_view::npos)
        return Status(ErrorCode::corrupt, "data URI without a comma");
    std::string_view header = uri.substr(0, comma), body = uri.substr(comma + 1);
    if (header.size() >= 7 && header.substr(header.size() - 7) == ";base64") {
        std::optional<std::vector<std::byte>> bytes = base64_decoded(body);
        if (!bytes)
            return Status(ErrorCode::corrupt, "data URI is not valid base64");
        return std::move(*bytes);
    }
    std::optional<std::string> text = percent_decoded(body);
    if (!text)
        return Status(ErrorCode::corrupt, "data URI holds a broken %XX");
    std::vector<std::byte> bytes(text->size());
    for (std::size_t i = 0; i < bytes.size(); ++i)
        bytes[i] = static_cast<std::byte>((*text)[i]);
    return bytes;
}

std::string folder_of(const std::string& path) {
    std::size_t slash = path.find_last_of('/');
    return slash == std::string::npos ? "." : slash == 0 ? "/" : path.substr(0, slash);
}

} // namespace antumbra
