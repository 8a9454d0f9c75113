// Names of random streams. A stream depends on the cell's own box and the object's own id, never on the scene as a
// whole: part of a bake can be repeated alone.
#pragma once

#include <antumbra/pvs.hpp>
#include <antumbra/scene.hpp>

#include <bit>
#include <cstdint>

namespace antumbra {

/// Finaliser of splitmix64 (Steele, Lea, Flood 2014): a bijection that spreads every bit.
constexpr std::uint64_t mix_bits(std::uint64_t value) {
    value = (value ^ (value >> 30)) * 0xbf58476d1ce4e5b9u;
    value = (value ^ (value >> 27)) * 0x94d049bb133111ebu;
    return value ^ (value >> 31);
}

inline std::uint64_t cell_key(const Box3d& cell) {
    std::uint64_t key = 0;
    for (int k = 0; k < 3; ++k) {
        key = mix_bits(key + 0x9e3779b97f4a7c15u + std::bit_cast<std::uint64_t>(cell.min[k] + 0.0));
        key = mix_bits(key + 0x9e3779b97f4a7c15u + std::bit_cast<std::uint64_t>(cell.max[k] + 0.0));
    }
    return key;
}

inline std::uint64_t object_key(const ObjectId& id) {
    std::uint64_t key = mix_bits(std::uint32_t(id.node) + 1);
    key = mix_bits(key + std::uint32_t(id.primitive) + 1);
    return mix_bits(key + std::uint32_t(id.instance) + 1);
}

} // namespace antumbra
