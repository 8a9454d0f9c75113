// The independent check of one cell's certificates.
#pragma once

#include "bake/exact/certificate_parts.hpp"

#include <map>

namespace antumbra::certificates {

/// Checks the certificates of one cell. Knows the scene's triangles and the rules of what makes an object hidden, not the
/// solver.
class CellChecker {
  public:
    CellChecker(const exact::SceneTree& tree, const GridBox& cell) : tree_(tree), cell_(cell) {}

    /// Which answer the next certificate proves; `problem` says what is wrong with it.
    Kind check(Reader& in, std::uint32_t unit, CertificateFileResult& result, std::string& problem);

  private:
    using Key = std::pair<int, std::vector<std::array<std::int64_t, 3>>>;
    struct Tree {
        std::vector<std::uint32_t> blockers;
        HiddenTree tree;
    };

    static Key key_of(int face, const std::vector<GridPoint>& corners) {
        Key key{face, {}};
        for (const GridPoint& p : corners)
            key.second.push_back({p.x, p.y, p.z});
        return key;
    }
    bool looks(int face, const GridBox& box) const {
        return face % 2 ? box.max[face / 2] > cell_.max[face / 2] : box.min[face / 2] < cell_.min[face / 2];
    }
    Status hides(const std::map<Key, Tree>& trees, int face, const Polygon& part) const;
    Status covers_box(const std::map<Key, Tree>& trees, const GridBox& box) const;
    Status covers_triangle(const std::map<Key, Tree>& trees, std::uint32_t t) const;
    void sides(std::uint32_t t, bool& front, bool& back) const;
    bool is_of(std::uint64_t triangle, std::uint32_t unit) const {
        return triangle < tree_.corners_count() && tree_.units().of[std::size_t(triangle)] == unit;
    }
    Status check_hidden(Reader& in, std::uint32_t unit, CertificateFileResult& result) const;
    Status check_visible(Reader& in, std::uint32_t unit) const;
    Status check_touch(Reader& in, std::uint32_t unit) const;

    const exact::SceneTree& tree_;
    GridBox cell_;
};

} // namespace antumbra::certificates
