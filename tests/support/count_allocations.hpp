// Counts what this thread allocates. Replaces operator new: include it in one file of a test program.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <new>

namespace antumbra::test {
inline thread_local std::uint64_t allocations = 0;
} // namespace antumbra::test

// Not inlined: else the compiler sees malloc on one side and delete on the other, and warns.
[[gnu::noinline]] void* operator new(std::size_t size) {
    ++antumbra::test::allocations;
    if (void* memory = std::malloc(size ? size : 1))
        return memory;
    throw std::bad_alloc();
}
// The sanitizers bring one of their own, whose memory is not for free().
[[gnu::noinline]] void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
    ++antumbra::test::allocations;
    return std::malloc(size ? size : 1);
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
