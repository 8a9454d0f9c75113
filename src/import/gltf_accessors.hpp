// From accessors to numbers. elements() is the only gate: what passed it can be read without further checks.
#pragma once

#include "import/gltf_buffers.hpp"

#include <antumbra/math.hpp>

namespace antumbra::gltf {

/// The elements of one accessor, proved to lie inside their buffers.
struct Elements {
    std::uint64_t count = 0;
    const std::byte* data = nullptr; ///< null: every element is zero unless `sparse_indices` replaces it
    std::size_t stride = 0;
    ComponentType type = ComponentType::f32;
    std::uint8_t components = 1;
    bool normalized = false;
    std::vector<std::uint32_t> sparse_indices; ///< strictly increasing, below count
    const std::byte* sparse_values = nullptr;  ///< tightly packed

    const std::byte* element(std::uint64_t i) const;
};

class Accessors {
  public:
    /// `zero_elements`: how many elements the accessors without a buffer view may have together, for they cost
    /// memory without costing file.
    Accessors(const Document& document, Buffers& buffers, std::uint64_t zero_elements)
        : document_(document), buffers_(buffers), zero_elements_(zero_elements) {}

    Result<Elements> elements(std::int32_t accessor);

    /// VEC3 of any component type. ErrorCode::corrupt for other shapes, NaN and infinities.
    Result<Elements> points(std::int32_t accessor);
    /// Unsigned SCALAR, all values below `limit`.
    Result<std::vector<std::uint32_t>> indices(std::int32_t accessor, std::uint64_t limit);
    /// Floating-point or normalised tuples of `components` numbers, one after the other.
    Result<std::vector<double>> tuples(std::int32_t accessor, std::uint8_t components);

    /// "accessors[3]"
    static std::string place(std::int32_t accessor) { return "accessors[" + std::to_string(accessor) + "]"; }

  private:
    Status add_sparse(const Accessor& accessor, Elements& elements);

    const Document& document_;
    Buffers& buffers_;
    std::uint64_t zero_elements_;
};

/// Component `c` of one element: integers as they are, or mapped to [0, 1] and [-1, 1] if normalised.
double component(const Elements& elements, const std::byte* element, std::uint32_t c);

/// The value of an integer of this type: as it is, or mapped to [0, 1] or [-1, 1] if normalised.
double integer_value(ComponentType type, bool normalized, double value);

/// One point; ErrorCode::corrupt if it is not finite.
Status read_point(const Elements& elements, std::uint64_t i, Vec3d& point);
/// All points, to `points[0 .. count)`.
Status read_points(const Elements& elements, Vec3d* points);

} // namespace antumbra::gltf
