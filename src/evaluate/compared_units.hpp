// What two files of one scene can both speak of.
#pragma once

#include <antumbra/compare.hpp>

#include <vector>

namespace antumbra {

/// The finest partition of the scene's triangles that the clusters of either file make up.
class ComparedUnits {
  public:
    ComparedUnits() = default;
    /// ErrorCode::mismatch if clusters of a file are not made of the scene's triangles. O(triangles).
    static Result<ComparedUnits> make(const Scene& scene, const Pvs& a, const Pvs& b);

    CompareUnits kind() const { return kind_; }
    std::uint32_t count() const { return static_cast<std::uint32_t>(object_.size()); }
    std::uint32_t object(std::uint32_t unit) const { return object_[unit]; }
    std::uint32_t of(std::uint32_t triangle) const { return of_[triangle]; }
    /// It is not always visible.
    bool is_counted(std::uint32_t unit) const { return counted_[unit]; }
    /// Units of which a row of file `side` (0: A) lists some part, among those that are counted.
    std::vector<std::uint64_t> listed(int side, const std::vector<std::uint64_t>& row) const;
    /// Triangles of what a row lists, as finely as the file does.
    std::uint64_t triangles(int side, const std::vector<std::uint64_t>& row) const;

  private:
    struct Part {
        std::size_t bit = 0; ///< in a row of the file
        std::uint32_t unit = 0, triangles = 0;
    };
    CompareUnits kind_ = CompareUnits::objects;
    std::vector<std::uint32_t> object_, of_;
    std::vector<bool> counted_;
    std::vector<Part> listed_[2], drawn_[2]; ///< of either file: what decides about units; what it lists most finely
};

} // namespace antumbra
