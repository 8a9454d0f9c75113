// Wavefront OBJ to RawScene. Two passes over the text: the first reads and counts vertices, the second builds
// faces, so that every index can be judged, and every array sized, before it is used.
#include "import/findings.hpp"
#include "import/import_bytes.hpp"
#include "import/obj_materials.hpp"
#include "import/polygon.hpp"
#include "import/text.hpp"
#include "import/uri.hpp"

#include "base/file.hpp"

#include <antumbra/import.hpp>


#include <algorithm>
#include <charconv>
#include <new>
#include <unordered_map>

namespace antumbra {
namespace {

Status at_line(std::uint64_t line, ErrorCode code, const std::string& text) {
    return {code, "line " + std::to_string(line) + ": " + text};
}

std::string shown(std::string_view word) { return "'" + std::string(word.substr(0, 60)) + "'"; }

class ObjReader {
  public:
    ObjReader(std::span<const std::byte> bytes, std::string folder, const ImportOptions& options)
        : bytes_(bytes), folder_(std::move(folder)), options_(options) {}

    Result<RawScene> read() {
        if (Status status = read_vertices(); !status)
            return status;
        if (Status status = read_faces(); !status)
            return status;
        gather_triangles();
        return std::move(raw_);
    }

  private:
    Status read_vertices() {
        Lines lines(bytes_);
        for (std::string_view line; lines.next(line);)
            if (next_word(line) == "v")
                if (Status status = read_vertex(line, lines.number()); !status)
                    return status;
        return {};
    }

    Status read_vertex(std::string_view line, std::uint64_t number) {
        if (raw_.positions.size() >= vertex_limit_)
            return at_line(number, ErrorCode::limit,
                           "more vertices than the limit of " + std::to_string(vertex_limit_));
        Vec3d p;
        for (int k = 0; k < 3; ++k) {
            std::string_view word = next_word(line);
            if (!word.empty() && word.front() == '+')
                word.remove_prefix(1);
            auto [rest, error] = std::from_chars(word.data(), word.data() + word.size(), p[k]);
            if (error != std::errc() || rest != word.data() + word.size() || !std::isfinite(p[k]))
                return at_line(number, ErrorCode::corrupt,
                               "'v' wants three finite numbers, not " + shown(word) + "; repair the line");
        }
        raw_.positions.push_back(options_.up_axis == UpAxis::z ? Vec3d{p.x, p.z, -p.y} : p);
        return {};
    }

    Status read_faces() {
        Lines lines(bytes_);
        for (std::string_view line; lines.next(line);) {
            std::string_view key = next_word(line);
            Status status;
            if (key == "v")
                ++vertices_so_far_;
            else if (key == "f" || key == "fo")
                status = read_face(line, lines.number());
            else if (key == "o")
                start(object_name_, line, true);
            else if (key == "g")
                start(group_name_, line, false);
            else if (key == "usemtl")
                see_through_ = materials_.see_through(std::string(trimmed(line)));
            else if (key == "mtllib")
                read_library(std::string(trimmed(line)));
            else if (key == "l" || key == "p")
                add_finding(raw_.findings, "points or lines left out",
                            [&] { return "line " + std::to_string(lines.number()); });
            else if (key == "curv" || key == "curv2" || key == "surf")
                add_finding(raw_.findings, "curve or free-form surface left out",
                            [&] { return "line " + std::to_string(lines.number()); });
            if (!status)
                return status;
        }
        return {};
    }

    void start(std::string& name, std::string_view line, bool clears_group) {
        name = std::string(trimmed(line).substr(0, 4096));
        if (clears_group)
            group_name_.clear();
        current_ = kNone;
    }

    Status read_face(std::string_view line, std::uint64_t number) {
        corners_.clear();
        for (std::string_view word = next_word(line); !word.empty(); word = next_word(line)) {
            Result<std::uint32_t> corner = read_corner(word, number);
            if (!corner)
                return corner.status();
            corners_.push_back(*corner);
        }
        if (corners_.size() < 3) {
            add_finding(raw_.findings, "face with fewer than three corners left out",
                        [&] { return "line " + std::to_string(number); });
            return {};
        }
        if (corners_.size() - 2 > triangle_limit_ - raw_.triangles.size())
            return at_line(number, ErrorCode::limit,
                           "more triangles than the limit of " + std::to_string(triangle_limit_));
        if (Status status = choose_object(number); !status)
            return status;
        add_triangles(number);
        return {};
    }

    /// "7", "7/2", "7/2/3", "7//3" or negative numbers, which count back from the last vertex so far. Texture and
    /// normal indices do not matter to sight and are not judged.
    Result<std::uint32_t> read_corner(std::string_view word, std::uint64_t number) const {
        if (word.front() == '+')
            word.remove_prefix(1);
        std::int64_t value = 0;
        auto [rest, error] = std::from_chars(word.data(), word.data() + word.size(), value);
        const char* end = word.data() + word.size();
        if (error != std::errc() || (rest != end && *rest != '/'))
            return at_line(number, ErrorCode::corrupt, shown(word) + " is no vertex of a face; repair the line");
        std::int64_t count = static_cast<std::int64_t>(raw_.positions.size());
        std::int64_t index = value < 0 ? static_cast<std::int64_t>(vertices_so_far_) + value : value - 1;
        if (value == 0 || index < 0 || index >= count)
            return at_line(number, ErrorCode::corrupt, "vertex " + shown(word) + " does not exist; the file has " +
                                                           std::to_string(count));
        return static_cast<std::uint32_t>(index);
    }

    /// The object of the lines `o` and `g` now in force; one that comes up again goes on.
    Status choose_object(std::uint64_t number) {
        if (current_ == kNone) {
            std::string name = object_name_;
            if (!group_name_.empty())
                name += (name.empty() ? "" : "/") + group_name_;
            if (name.empty())
                name = "default";
            auto [found, is_new] = objects_.try_emplace(name, static_cast<std::uint32_t>(raw_.objects.size()));
            if (is_new && raw_.objects.size() >= options_.limits.objects)
                return at_line(number, ErrorCode::limit,
                               "more objects than the limit of " + std::to_string(options_.limits.objects));
            if (is_new) {
                raw_.objects.emplace_back();
                raw_.objects.back().name = name;
                raw_.objects.back().flags = kOccludes | kDoubleSided;
            }
            current_ = found->second;
        }
        RawObject& object = raw_.objects[current_];
        if (see_through_ && (object.flags & kOccludes)) {
            object.flags &= ~std::uint32_t(kOccludes);
            add_finding(raw_.findings, "see-through object", [&] { return "'" + object.name + "'"; });
        }
        return {};
    }

    void add_triangles(std::uint64_t number) {
        cut_.clear();
        polygon_.clear();
        for (std::uint32_t corner : corners_)
            polygon_.push_back(raw_.positions[corner]);
        if (!triangulate(polygon_, cut_))
            add_finding(raw_.findings, "long concave polygon cut as a fan",
                        [&] { return "line " + std::to_string(number); });
        for (const TriangleIndices& t : cut_) {
            raw_.triangles.push_back({corners_[t[0]], corners_[t[1]], corners_[t[2]]});
            triangle_objects_.push_back(current_);
        }
        raw_.objects[current_].triangle_count += static_cast<std::uint32_t>(cut_.size());
    }

    /// A counting sort by object that keeps the order within each: groups may have come in pieces.
    void gather_triangles() {
        std::uint32_t first = 0;
        for (RawObject& object : raw_.objects) {
            object.first_triangle = first;
            first += object.triangle_count;
        }
        if (std::is_sorted(triangle_objects_.begin(), triangle_objects_.end()))
            return;
        std::vector<std::uint32_t> next(raw_.objects.size());
        for (std::size_t o = 0; o < next.size(); ++o)
            next[o] = raw_.objects[o].first_triangle;
        std::vector<TriangleIndices> sorted(raw_.triangles.size());
        for (std::size_t t = 0; t < sorted.size(); ++t)
            sorted[next[triangle_objects_[t]]++] = raw_.triangles[t];
        raw_.triangles = std::move(sorted);
    }

    /// A library that cannot be read costs us transparency only: a finding, no error.
    void read_library(const std::string& file_name) {
        auto note = [&](const std::string& why) {
            add_finding(raw_.findings, "material library not read", [&] { return why; });
        };
        if (!libraries_.emplace(file_name, 0).second)
            return;
        Result<std::string> path = path_inside(folder_, file_name);
        if (!path)
            return note(path.status().message());
        Result<MappedFile> file = MappedFile::open(*path, options_.limits.bytes - bytes_.size());
        if (!file)
            return note(file.status().message());
        materials_.read(file->bytes());
    }

    static constexpr std::uint32_t kNone = 0xFFFFFFFFu;

    std::span<const std::byte> bytes_;
    std::string folder_;
    const ImportOptions& options_;
    // Half of the memory each. 28 bytes: a triangle, its object and the copy made by gather_triangles.
    std::uint64_t vertex_limit_ = std::min(options_.limits.vertices, options_.limits.memory / 2 / sizeof(Vec3d));
    std::uint64_t triangle_limit_ = std::min(options_.limits.triangles, options_.limits.memory / 2 / 28);
    RawScene raw_;
    std::uint64_t vertices_so_far_ = 0;
    std::string object_name_, group_name_;
    std::unordered_map<std::string, std::uint32_t> objects_; // looked up only; the order is that of first use
    std::unordered_map<std::string, char> libraries_;
    std::uint32_t current_ = kNone;
    ObjMaterials materials_;
    bool see_through_ = false;
    std::vector<std::uint32_t> corners_, triangle_objects_;
    std::vector<Vec3d> polygon_;
    std::vector<TriangleIndices> cut_;
};

} // namespace

Result<RawScene> import_obj(std::span<const std::byte> bytes, const std::string& name, const std::string& folder,
                            const ImportOptions& options) {
    return import_bytes(bytes, name, options, [&] { return ObjReader(bytes, folder, options).read(); });
}

} // namespace antumbra
