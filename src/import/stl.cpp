// STL: a soup of triangles, as text or binary.
#include "import/import_bytes.hpp"
#include "import/text.hpp"

#include <antumbra/import.hpp>

#include <bit>
#include <charconv>
#include <cmath>
#include <new>

namespace antumbra {
namespace {

constexpr std::uint64_t kHeader = 84, kFacet = 50;

class StlReader {
  public:
    StlReader(std::span<const std::byte> bytes, const ImportOptions& options) : bytes_(bytes), options_(options) {}

    Result<RawScene> read() {
        // Many binary files begin with "solid", too; their length gives them away.
        std::uint64_t facets = bytes_.size() >= kHeader ? word(80) : 0;
        bool binary = bytes_.size() >= kHeader && bytes_.size() == kHeader + facets * kFacet;
        std::string_view first_line;
        Lines lines(bytes_); // outlives the line
        lines.next(first_line);
        if (!binary && next_word(first_line) != "solid")
            return Status(ErrorCode::corrupt, "is neither a text STL (solid ..) nor as long as a binary one of " +
                                                  std::to_string(facets) + " facets must be");
        if (Status status = binary ? read_binary(facets) : read_text(); !status)
            return status;
        return std::move(raw_);
    }

  private:
    std::uint32_t word(std::size_t at) const {
        std::uint32_t value = 0;
        for (std::size_t i = 0; i < 4; ++i)
            value |= static_cast<std::uint32_t>(bytes_[at + i]) << (8 * i);
        return value;
    }

    Status read_binary(std::uint64_t facets) {
        if (Status status = make_room(facets); !status)
            return status;
        raw_.positions.reserve(static_cast<std::size_t>(3 * facets));
        raw_.triangles.reserve(static_cast<std::size_t>(facets));
        start("solid");
        for (std::uint64_t f = 0; f < facets; ++f) {
            for (std::size_t c = 0; c < 3; ++c) {
                // The normal comes first; the winding says the same.
                std::size_t at = static_cast<std::size_t>(kHeader + f * kFacet + 12 + 12 * c);
                Vec3d p{double(std::bit_cast<float>(word(at))), double(std::bit_cast<float>(word(at + 4))),
                        double(std::bit_cast<float>(word(at + 8)))};
                if (!is_finite(p))
                    return {ErrorCode::corrupt, "facet " + std::to_string(f) + ": is not finite; repair the mesh"};
                add_vertex(p);
            }
            add_triangle();
        }
        return {};
    }

    Status read_text() {
        Lines lines(bytes_);
        std::size_t corners = 0;
        for (std::string_view line; lines.next(line);) {
            std::string_view key = next_word(line);
            Status status;
            if (key == "solid") {
                std::string name(trimmed(line).substr(0, 4096));
                if (raw_.objects.size() >= options_.limits.objects)
                    return {ErrorCode::limit, "more solids than the limit of " + std::to_string(options_.limits.objects)};
                start(name.empty() ? "solid" : name);
            } else if (key == "facet") {
                corners = 0;
            } else if (key == "vertex") {
                status = ++corners > 3 ? Status(ErrorCode::corrupt, "a facet of more than three corners")
                                       : read_vertex(line);
            } else if (key == "endfacet") {
                status = corners == 3 ? make_room(1) : Status(ErrorCode::corrupt, "a facet without three corners");
                if (status)
                    add_triangle();
                corners = 0;
            }
            if (!status)
                return status.in("line " + std::to_string(lines.number()));
        }
        if (corners > 0)
            return {ErrorCode::corrupt, "the file ends within a facet; copy it anew"};
        return {};
    }

    Status read_vertex(std::string_view line) {
        Vec3d p;
        for (int k = 0; k < 3; ++k) {
            std::string_view number = next_word(line);
            if (!number.empty() && number.front() == '+')
                number.remove_prefix(1);
            const char* end = number.data() + number.size();
            auto [rest, error] = std::from_chars(number.data(), end, p[k]);
            if (error != std::errc() || rest != end || !std::isfinite(p[k]))
                return {ErrorCode::corrupt, "'vertex' wants three finite numbers; repair the line"};
        }
        add_vertex(p);
        return {};
    }

    Status make_room(std::uint64_t facets) const {
        const ImportLimits& limits = options_.limits;
        std::uint64_t all = raw_.triangles.size() + facets;
        if (all > limits.triangles || 3 * all > limits.vertices || all > limits.memory / (3 * sizeof(Vec3d) + 12))
            return {ErrorCode::limit, "more triangles, vertices or memory than the limit"};
        return {};
    }

    void start(const std::string& name) {
        raw_.objects.emplace_back();
        raw_.objects.back().name = name;
        raw_.objects.back().flags = kOccludes | kDoubleSided;
        raw_.objects.back().first_triangle = static_cast<std::uint32_t>(raw_.triangles.size());
    }
    void add_vertex(const Vec3d& p) {
        raw_.positions.push_back(options_.up_axis == UpAxis::z ? Vec3d{p.x, p.z, -p.y} : p);
    }
    /// Of the last three vertices.
    void add_triangle() {
        std::uint32_t end = static_cast<std::uint32_t>(raw_.positions.size());
        raw_.triangles.push_back({end - 3, end - 2, end - 1});
        ++raw_.objects.back().triangle_count;
    }

    std::span<const std::byte> bytes_;
    const ImportOptions& options_;
    RawScene raw_;
};

} // namespace

Result<RawScene> import_stl(std::span<const std::byte> bytes, const std::string& name,
                            const ImportOptions& options) {
    return import_bytes(bytes, name, options, [&] { return StlReader(bytes, options).read(); });
}

} // namespace antumbra
