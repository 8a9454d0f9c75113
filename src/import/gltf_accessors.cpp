#include "import/gltf_accessors.hpp"

#include <algorithm>
#include <cstring>

namespace antumbra::gltf {
namespace {

alignas(8) constexpr std::byte kZeros[64] = {};

template <class T>
T load(const std::byte* at) {
    T value;
    std::memcpy(&value, at, sizeof value);
    return value;
}

Status not_finite(std::uint64_t i) {
    return {ErrorCode::corrupt, "element " + std::to_string(i) + " is not finite; repair the mesh"};
}

/// Does `count` elements of `size` bytes, `stride` apart, from `offset` on, fit into `bytes`? Divides instead of
/// multiplying, so that nothing can wrap.
bool fits(std::uint64_t bytes, std::uint64_t offset, std::uint64_t count, std::uint64_t size, std::uint64_t stride) {
    if (count == 0)
        return offset <= bytes;
    return offset <= bytes && size <= bytes - offset && count - 1 <= (bytes - offset - size) / stride;
}

Status does_not_fit(std::uint64_t count, std::uint64_t size, std::int32_t view, std::uint64_t bytes) {
    return {ErrorCode::corrupt, std::to_string(count) + " elements of " + std::to_string(size) +
                                    " bytes do not fit into the " + std::to_string(bytes) + " bytes of bufferViews[" +
                                    std::to_string(view) + "]"};
}

std::uint32_t unsigned_value(ComponentType type, const std::byte* at) {
    switch (type) {
    case ComponentType::u8:
        return load<std::uint8_t>(at);
    case ComponentType::u16:
        return load<std::uint16_t>(at);
    default:
        return load<std::uint32_t>(at);
    }
}

} // namespace

const std::byte* Elements::element(std::uint64_t i) const {
    if (!sparse_indices.empty()) {
        auto found = std::lower_bound(sparse_indices.begin(), sparse_indices.end(), i);
        if (found != sparse_indices.end() && *found == i)
            return sparse_values + static_cast<std::size_t>(found - sparse_indices.begin()) * components *
                                       size_of(type);
    }
    return data ? data + stride * i : kZeros;
}

Result<Elements> Accessors::elements(std::int32_t index) {
    const Accessor& accessor = document_.accessors[static_cast<std::size_t>(index)];
    Elements elements;
    elements.count = accessor.count;
    elements.type = accessor.type;
    elements.components = accessor.components;
    elements.normalized = accessor.normalized;
    std::uint64_t size = std::uint64_t(size_of(accessor.type)) * accessor.components;
    if (accessor.count > UINT32_MAX - 1)
        return Status(ErrorCode::limit, "more than 2^32 - 2 elements").in(place(index) + ".count");
    if (accessor.view < 0) {
        if (accessor.count > zero_elements_)
            return Status(ErrorCode::limit, "elements without a buffer view outnumber the bytes of the file")
                .in(place(index) + ".count");
        zero_elements_ -= accessor.count;
    } else {
        Result<std::span<const std::byte>> bytes = buffers_.view(accessor.view);
        if (!bytes)
            return bytes.status().in(place(index));
        std::uint64_t stride = document_.views[static_cast<std::size_t>(accessor.view)].stride;
        elements.stride = static_cast<std::size_t>(stride ? stride : size);
        if (elements.stride < size)
            return Status(ErrorCode::corrupt, "byteStride is shorter than an element")
                .in("bufferViews[" + std::to_string(accessor.view) + "]");
        if (!fits(bytes->size(), accessor.offset, accessor.count, size, elements.stride))
            return does_not_fit(accessor.count, size, accessor.view, bytes->size()).in(place(index));
        elements.data = bytes->data() + accessor.offset;
    }
    if (accessor.sparse.count > 0)
        if (Status status = add_sparse(accessor, elements); !status)
            return status.in(place(index) + ".sparse");
    return elements;
}

Status Accessors::add_sparse(const Accessor& accessor, Elements& elements) {
    const Sparse& sparse = accessor.sparse;
    Result<std::span<const std::byte>> index_bytes = buffers_.view(sparse.index_view);
    if (!index_bytes)
        return index_bytes.status();
    Result<std::span<const std::byte>> value_bytes = buffers_.view(sparse.value_view);
    if (!value_bytes)
        return value_bytes.status();
    std::uint64_t index_size = size_of(sparse.index_type);
    std::uint64_t value_size = std::uint64_t(size_of(accessor.type)) * accessor.components;
    if (!fits(index_bytes->size(), sparse.index_offset, sparse.count, index_size, index_size))
        return does_not_fit(sparse.count, index_size, sparse.index_view, index_bytes->size()).in("indices");
    if (!fits(value_bytes->size(), sparse.value_offset, sparse.count, value_size, value_size))
        return does_not_fit(sparse.count, value_size, sparse.value_view, value_bytes->size()).in("values");
    elements.sparse_indices.resize(static_cast<std::size_t>(sparse.count));
    std::uint64_t next = 0;
    for (std::size_t i = 0; i < elements.sparse_indices.size(); ++i) {
        std::uint32_t value = unsigned_value(sparse.index_type,
                                             index_bytes->data() + sparse.index_offset + i * index_size);
        if (value < next || value >= accessor.count)
            return {ErrorCode::corrupt, "indices: " + std::to_string(value) +
                                            " is out of range or not greater than the one before"};
        next = std::uint64_t(value) + 1;
        elements.sparse_indices[i] = value;
    }
    elements.sparse_values = value_bytes->data() + sparse.value_offset;
    return {};
}

Result<Elements> Accessors::points(std::int32_t index) {
    const Accessor& accessor = document_.accessors[static_cast<std::size_t>(index)];
    if (accessor.components != 3 || accessor.type == ComponentType::u32)
        return Status(ErrorCode::corrupt, "positions must be VEC3 of floats or of 8- or 16-bit integers")
            .in(place(index));
    return elements(index);
}

Result<std::vector<std::uint32_t>> Accessors::indices(std::int32_t index, std::uint64_t limit) {
    const Accessor& accessor = document_.accessors[static_cast<std::size_t>(index)];
    bool is_unsigned = accessor.type == ComponentType::u8 || accessor.type == ComponentType::u16 ||
                       accessor.type == ComponentType::u32;
    if (accessor.components != 1 || !is_unsigned || accessor.normalized)
        return Status(ErrorCode::corrupt, "indices must be SCALAR and unsigned").in(place(index));
    Result<Elements> found = elements(index);
    if (!found)
        return found.status();
    const Elements& elements = *found;
    std::vector<std::uint32_t> values(static_cast<std::size_t>(elements.count));
    for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = elements.data ? unsigned_value(elements.type, elements.data + elements.stride * i) : 0;
    for (std::uint32_t i : elements.sparse_indices)
        values[i] = unsigned_value(elements.type, elements.element(i));
    std::uint32_t largest = values.empty() ? 0 : *std::max_element(values.begin(), values.end());
    if (!values.empty() && largest >= limit) {
        std::size_t at = static_cast<std::size_t>(std::max_element(values.begin(), values.end()) - values.begin());
        return Status(ErrorCode::corrupt, "element " + std::to_string(at) + " is " + std::to_string(largest) +
                                              ", but there are only " + std::to_string(limit) + " vertices")
            .in(place(index));
    }
    return values;
}

Result<std::vector<double>> Accessors::tuples(std::int32_t index, std::uint8_t components) {
    const Accessor& accessor = document_.accessors[static_cast<std::size_t>(index)];
    if (accessor.components != components || accessor.type == ComponentType::u32)
        return Status(ErrorCode::corrupt, "must have " + std::to_string(components) + " components")
            .in(place(index));
    Result<Elements> found = elements(index);
    if (!found)
        return found.status();
    std::vector<double> values;
    values.reserve(static_cast<std::size_t>(found->count) * components);
    for (std::uint64_t i = 0; i < found->count; ++i)
        for (std::uint32_t c = 0; c < components; ++c) {
            values.push_back(component(*found, found->element(i), c));
            if (!std::isfinite(values.back()))
                return not_finite(i).in(place(index));
        }
    return values;
}

double integer_value(ComponentType type, bool normalized, double value) {
    if (!normalized)
        return value;
    switch (type) {
    case ComponentType::i8:
        return std::max(value / 127, -1.0);
    case ComponentType::u8:
        return value / 255;
    case ComponentType::i16:
        return std::max(value / 32767, -1.0);
    case ComponentType::u16:
        return value / 65535;
    default:
        return value;
    }
}

double component(const Elements& elements, const std::byte* element, std::uint32_t c) {
    const std::byte* at = element + std::size_t(c) * size_of(elements.type);
    auto integer = [&](double value) { return integer_value(elements.type, elements.normalized, value); };
    switch (elements.type) {
    case ComponentType::i8:
        return integer(load<std::int8_t>(at));
    case ComponentType::u8:
        return integer(load<std::uint8_t>(at));
    case ComponentType::i16:
        return integer(load<std::int16_t>(at));
    case ComponentType::u16:
        return integer(load<std::uint16_t>(at));
    case ComponentType::u32:
        return load<std::uint32_t>(at);
    case ComponentType::f32:
        return static_cast<double>(load<float>(at));
    }
    return 0;
}

Status read_point(const Elements& elements, std::uint64_t i, Vec3d& point) {
    const std::byte* element = elements.element(i);
    for (std::uint32_t c = 0; c < 3; ++c)
        point[static_cast<int>(c)] = component(elements, element, c);
    return is_finite(point) ? Status() : not_finite(i);
}

Status read_points(const Elements& elements, Vec3d* points) {
    if (elements.type != ComponentType::f32 || !elements.data || !elements.sparse_indices.empty()) {
        for (std::uint64_t i = 0; i < elements.count; ++i)
            if (Status status = read_point(elements, i, points[i]); !status)
                return status;
        return {};
    }
    // Nearly every file: plain floats.
    const std::byte* at = elements.data;
    for (std::uint64_t i = 0; i < elements.count; ++i, at += elements.stride) {
        Vec3f p = load<Vec3f>(at);
        points[i] = to_double(p);
        if (!is_finite(p))
            return not_finite(i);
    }
    return {};
}

} // namespace antumbra::gltf
