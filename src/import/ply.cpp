// PLY: a header that declares elements with typed properties, then their values as text or binary of either
// byte order.
#include "import/findings.hpp"
#include "import/import_bytes.hpp"
#include "import/polygon.hpp"
#include "import/text.hpp"

#include <antumbra/import.hpp>

#include <bit>
#include <charconv>
#include <cmath>
#include <new>
#include <optional>

namespace antumbra {
namespace {

enum class Type : std::uint8_t { i8, u8, i16, u16, i32, u32, f32, f64 };
enum class Format : std::uint8_t { text, little, big };

constexpr std::size_t kSizes[] = {1, 1, 2, 2, 4, 4, 4, 8};

std::optional<Type> type_named(std::string_view name) {
    constexpr std::pair<std::string_view, Type> kNames[] = {
        {"char", Type::i8},   {"int8", Type::i8},   {"uchar", Type::u8},  {"uint8", Type::u8},
        {"short", Type::i16}, {"int16", Type::i16}, {"ushort", Type::u16}, {"uint16", Type::u16},
        {"int", Type::i32},   {"int32", Type::i32}, {"uint", Type::u32},  {"uint32", Type::u32},
        {"float", Type::f32}, {"float32", Type::f32}, {"double", Type::f64}, {"float64", Type::f64}};
    for (auto [known, type] : kNames)
        if (known == name)
            return type;
    return std::nullopt;
}

struct Property {
    std::string name;
    bool is_list = false;
    Type count_type = Type::u8, type = Type::f32;
};

struct Element {
    std::string name;
    std::uint64_t count = 0;
    std::vector<Property> properties;
};

/// The values after the header, one after the other. Every read moves on by at least a byte.
class Values {
  public:
    Values(std::span<const std::byte> bytes, Format format) : bytes_(bytes), format_(format) {}

    /// False at the end, and for a word that is no number.
    bool next(Type type, double& value) { return format_ == Format::text ? next_word_of_text(value) : next_binary(type, value); }
    std::size_t left() const { return bytes_.size() - at_; }

  private:
    bool next_word_of_text(double& value) {
        const char* data = reinterpret_cast<const char*>(bytes_.data());
        auto blank = [](char c) { return c == ' ' || (c >= '\t' && c <= '\r'); };
        while (at_ < bytes_.size() && blank(data[at_]))
            ++at_;
        std::size_t end = at_;
        while (end < bytes_.size() && !blank(data[end]))
            ++end;
        const char* begin = data + at_ + (end > at_ && data[at_] == '+');
        auto [rest, error] = std::from_chars(begin, data + end, value);
        bool good = error == std::errc() && rest == data + end;
        at_ = end;
        return good;
    }

    bool next_binary(Type type, double& value) {
        std::size_t size = kSizes[static_cast<std::size_t>(type)];
        if (left() < size)
            return false;
        std::uint64_t bits = 0;
        for (std::size_t i = 0; i < size; ++i) {
            std::size_t shift = format_ == Format::little ? i : size - 1 - i;
            bits |= std::uint64_t(bytes_[at_ + i]) << (8 * shift);
        }
        at_ += size;
        switch (type) {
        case Type::i8: value = static_cast<std::int8_t>(bits); break;
        case Type::u8: case Type::u16: case Type::u32: value = static_cast<double>(bits); break;
        case Type::i16: value = static_cast<std::int16_t>(bits); break;
        case Type::i32: value = static_cast<std::int32_t>(bits); break;
        case Type::f32: value = static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bits))); break;
        case Type::f64: value = std::bit_cast<double>(bits); break;
        }
        return true;
    }

    std::span<const std::byte> bytes_;
    Format format_;
    std::size_t at_ = 0;
};

class PlyReader {
  public:
    PlyReader(std::span<const std::byte> bytes, const ImportOptions& options) : bytes_(bytes), options_(options) {}

    Result<RawScene> read() {
        if (Status status = read_header(); !status)
            return status;
        Values values(bytes_.subspan(body_), format_);
        for (const Element& element : elements_) {
            Status status = element.name == "vertex" ? read_vertices(element, values)
                            : element.name == "face" ? read_faces(element, values)
                                                     : skip(element, values);
            if (!status)
                return status;
        }
        return finish();
    }

  private:
    /// Ends behind "end_header" and its line's end.
    Status read_header() {
        std::string_view text(reinterpret_cast<const char*>(bytes_.data()), bytes_.size());
        bool has_format = false;
        for (std::uint64_t number = 1;; ++number) {
            std::size_t end = text.find('\n', body_);
            if (end == std::string_view::npos)
                return {ErrorCode::corrupt, "the header does not end; copy the file anew"};
            std::string_view line = text.substr(body_, end - body_);
            body_ = end + 1;
            std::string_view key = next_word(line);
            Status status;
            if (number == 1 && key != "ply")
                return {ErrorCode::corrupt, "is not a PLY file: it does not begin with 'ply'"};
            if (key == "end_header")
                return has_format ? Status() : Status(ErrorCode::corrupt, "the header names no format");
            if (key == "format")
                status = read_format(next_word(line)), has_format = true;
            else if (key == "element")
                status = add_element(line);
            else if (key == "property")
                status = add_property(line);
            if (!status)
                return status.in("line " + std::to_string(number));
        }
    }

    Status read_format(std::string_view name) {
        format_ = name == "ascii" ? Format::text : name == "binary_big_endian" ? Format::big : Format::little;
        return name == "ascii" || name == "binary_big_endian" || name == "binary_little_endian"
                   ? Status()
                   : Status(ErrorCode::unsupported, "format '" + std::string(name.substr(0, 40)) + "' is not read");
    }

    Status add_element(std::string_view line) {
        Element element;
        element.name = std::string(next_word(line).substr(0, 100));
        std::string_view count = next_word(line);
        auto [rest, error] = std::from_chars(count.data(), count.data() + count.size(), element.count);
        if (error != std::errc() || rest != count.data() + count.size() || count.empty())
            return {ErrorCode::corrupt, "'element' wants a name and a number"};
        if (element.count > bytes_.size())
            return {ErrorCode::corrupt, std::to_string(element.count) + " elements do not fit into the file"};
        elements_.push_back(std::move(element));
        return {};
    }

    Status add_property(std::string_view line) {
        Property property;
        std::string_view word = next_word(line);
        property.is_list = word == "list";
        std::optional<Type> count_type = Type::u8;
        if (property.is_list) {
            count_type = type_named(next_word(line));
            word = next_word(line);
        }
        std::optional<Type> type = type_named(word);
        property.name = std::string(next_word(line).substr(0, 100));
        if (!type || !count_type || property.name.empty() || elements_.empty())
            return {ErrorCode::corrupt, "this property makes no sense"};
        property.type = *type;
        property.count_type = *count_type;
        elements_.back().properties.push_back(std::move(property));
        return {};
    }

    static Status cut_off(const Element& element, std::uint64_t i) {
        return {ErrorCode::corrupt, element.name + "[" + std::to_string(i) + "]: is cut off or no number"};
    }

    /// Reads one property; `list` receives the values of a list, `value` a single one.
    static bool read_property(const Property& property, Values& values, double& value, std::vector<double>* list) {
        if (!property.is_list)
            return values.next(property.type, value);
        double count = 0;
        if (!values.next(property.count_type, count) || !(count >= 0 && count <= double(values.left())))
            return false;
        for (std::uint64_t i = 0; i < static_cast<std::uint64_t>(count); ++i) {
            if (!values.next(property.type, value))
                return false;
            if (list)
                list->push_back(value);
        }
        return true;
    }

    static Status skip(const Element& element, Values& values) {
        double value = 0;
        for (std::uint64_t i = 0; i < element.count; ++i)
            for (const Property& property : element.properties)
                if (!read_property(property, values, value, nullptr))
                    return cut_off(element, i);
        return {};
    }

    Status read_vertices(const Element& element, Values& values) {
        const ImportLimits& limits = options_.limits;
        if (element.count > limits.vertices || element.count > limits.memory / 2 / sizeof(Vec3d))
            return {ErrorCode::limit, "more vertices or memory than the limit"};
        int found = 0;
        for (const Property& property : element.properties)
            found += !property.is_list && (property.name == "x" || property.name == "y" || property.name == "z");
        if (found != 3 || !raw_.positions.empty())
            return {ErrorCode::corrupt, "vertices without exactly one x, y and z"};
        raw_.positions.reserve(static_cast<std::size_t>(element.count));
        for (std::uint64_t i = 0; i < element.count; ++i) {
            Vec3d p;
            for (const Property& property : element.properties) {
                double value = 0;
                if (!read_property(property, values, value, nullptr))
                    return cut_off(element, i);
                if (!property.is_list && property.name.size() == 1 && property.name[0] >= 'x' && property.name[0] <= 'z')
                    p[property.name[0] - 'x'] = value;
            }
            if (!is_finite(p))
                return {ErrorCode::corrupt, "vertex[" + std::to_string(i) + "]: is not finite; repair the mesh"};
            raw_.positions.push_back(options_.up_axis == UpAxis::z ? Vec3d{p.x, p.z, -p.y} : p);
        }
        return {};
    }

    Status read_faces(const Element& element, Values& values) {
        std::vector<double> corners;
        for (std::uint64_t i = 0; i < element.count; ++i) {
            corners.clear();
            for (const Property& property : element.properties) {
                bool names_corners = property.is_list &&
                                     (property.name == "vertex_indices" || property.name == "vertex_index");
                double value = 0;
                if (!read_property(property, values, value, names_corners ? &corners : nullptr))
                    return cut_off(element, i);
            }
            if (Status status = add_face(corners); !status)
                return status.in("face[" + std::to_string(i) + "]");
        }
        return {};
    }

    Status add_face(const std::vector<double>& corners) {
        if (corners.size() < 3) {
            add_finding(raw_.findings, "face with fewer than three corners left out", [] { return std::string("a face"); });
            return {};
        }
        const ImportLimits& limits = options_.limits;
        std::uint64_t all = raw_.triangles.size() + corners.size() - 2;
        if (all > limits.triangles || all > limits.memory / 2 / sizeof(TriangleIndices))
            return {ErrorCode::limit, "more triangles or memory than the limit"};
        polygon_.clear();
        cut_.clear();
        for (double corner : corners) {
            if (!(corner >= 0 && corner < double(raw_.positions.size()) && corner == std::floor(corner)))
                return {ErrorCode::corrupt, "names a vertex that does not exist (faces come after vertices)"};
            polygon_.push_back(raw_.positions[static_cast<std::size_t>(corner)]);
        }
        if (!triangulate(polygon_, cut_))
            add_finding(raw_.findings, "long concave polygon cut as a fan", [] { return std::string("a face"); });
        for (const TriangleIndices& t : cut_) {
            TriangleIndices triangle;
            for (std::size_t c = 0; c < 3; ++c)
                triangle[c] = static_cast<std::uint32_t>(corners[t[c]]);
            raw_.triangles.push_back(triangle);
        }
        return {};
    }

    Result<RawScene> finish() {
        RawObject object;
        object.name = "mesh";
        object.flags = kOccludes | kDoubleSided;
        object.triangle_count = static_cast<std::uint32_t>(raw_.triangles.size());
        raw_.objects.push_back(std::move(object));
        return std::move(raw_);
    }

    std::span<const std::byte> bytes_;
    const ImportOptions& options_;
    Format format_ = Format::text;
    std::size_t body_ = 0;
    std::vector<Element> elements_;
    RawScene raw_;
    std::vector<Vec3d> polygon_;
    std::vector<TriangleIndices> cut_;
};

} // namespace

Result<RawScene> import_ply(std::span<const std::byte> bytes, const std::string& name,
                            const ImportOptions& options) {
    return import_bytes(bytes, name, options, [&] { return PlyReader(bytes, options).read(); });
}

} // namespace antumbra
