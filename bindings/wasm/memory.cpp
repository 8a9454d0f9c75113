// A small allocator: pieces of 2^n or 3 * 2^n / 2 bytes, each size with a list of free ones; what is larger than a
// page goes by the same rule, so that no more than a third of any piece is wasted. Nothing is ever united: an instance lives as long
// as one opened file, whose memory the engine takes back as a whole. A third of the bytes of the C library's.
#include <cstddef>
#include <cstdint>
#include <new>

/// 1 once memory ran out: the trap that follows is told from a broken promise by it.
extern "C" int ant_wasm_out_of_memory = 0;
extern "C" unsigned char __heap_base;

namespace {

constexpr std::size_t kHeader = 16; ///< before each piece, so that pieces are aligned to it
constexpr std::size_t kPage = 65536;
constexpr unsigned kClasses = 56;

struct Piece {
    std::uint32_t size_class;
    Piece* next; ///< while free
};

Piece* free_pieces[kClasses];
std::uintptr_t top = 0; ///< from here to the end of memory nothing was ever handed out

/// Class 2k: 16 * 2^k bytes, class 2k + 1: 24 * 2^k.
std::size_t bytes_of(unsigned size_class) { return (size_class % 2 ? std::size_t(24) : std::size_t(16)) << size_class / 2; }

unsigned class_for(std::size_t bytes) {
    unsigned size_class = 0;
    while (size_class < kClasses && bytes_of(size_class) < bytes)
        ++size_class;
    return size_class;
}

Piece* carve(unsigned size_class) {
    if (top == 0)
        top = (reinterpret_cast<std::uintptr_t>(&__heap_base) + kHeader - 1) & ~(kHeader - 1);
    std::size_t bytes = kHeader + ((bytes_of(size_class) + kHeader - 1) & ~(kHeader - 1));
    std::size_t end = std::size_t(__builtin_wasm_memory_size(0)) * kPage; // at most 2^32: 0 means that
    if (end - top < bytes) {
        std::size_t pages = (bytes - (end - top) + kPage - 1) / kPage;
        if (__builtin_wasm_memory_grow(0, pages) == static_cast<std::size_t>(-1))
            return nullptr;
    }
    auto* piece = reinterpret_cast<Piece*>(top);
    piece->size_class = size_class;
    top += bytes;
    return piece;
}

Piece* piece_of(void* memory) { return reinterpret_cast<Piece*>(static_cast<unsigned char*>(memory) - kHeader); }

} // namespace

// Eight bytes at a time: a sixth of the bytes of the C library's, which are unrolled.
extern "C" __attribute__((no_builtin)) void* memmove(void* to, const void* from, std::size_t bytes) {
    auto* target = static_cast<unsigned char*>(to);
    auto* source = static_cast<const unsigned char*>(from);
    std::uint64_t eight;
    if (static_cast<std::size_t>(target - source) >= bytes) { // the target does not begin within the source
        for (; bytes >= sizeof eight; bytes -= sizeof eight, target += sizeof eight, source += sizeof eight) {
            __builtin_memcpy_inline(&eight, source, sizeof eight);
            __builtin_memcpy_inline(target, &eight, sizeof eight);
        }
        for (; bytes > 0; --bytes)
            *target++ = *source++;
        return to;
    }
    for (; bytes >= sizeof eight; bytes -= sizeof eight) {
        __builtin_memcpy_inline(&eight, source + bytes - sizeof eight, sizeof eight);
        __builtin_memcpy_inline(target + bytes - sizeof eight, &eight, sizeof eight);
    }
    for (; bytes > 0; --bytes)
        target[bytes - 1] = source[bytes - 1];
    return to;
}

extern "C" __attribute__((no_builtin)) void* memcpy(void* to, const void* from, std::size_t bytes) {
    return memmove(to, from, bytes);
}

extern "C" void* malloc(std::size_t bytes) {
    if (bytes > 0x7FFF0000u)
        return nullptr;
    unsigned size_class = class_for(bytes);
    Piece* piece = free_pieces[size_class];
    if (piece)
        free_pieces[size_class] = piece->next;
    else
        piece = carve(size_class);
    return piece ? reinterpret_cast<unsigned char*>(piece) + kHeader : nullptr;
}

extern "C" void free(void* memory) {
    if (!memory)
        return;
    Piece* piece = piece_of(memory);
    piece->next = free_pieces[piece->size_class];
    free_pieces[piece->size_class] = piece;
}

namespace {

void* or_trap(void* memory) {
    if (!memory) {
        ant_wasm_out_of_memory = 1;
        __builtin_trap();
    }
    return memory;
}

} // namespace

void* operator new(std::size_t size) { return or_trap(malloc(size)); }
void* operator new(std::size_t size, const std::nothrow_t&) noexcept { return malloc(size); } // std::stable_sort
void operator delete(void* memory) noexcept { free(memory); }
void operator delete(void* memory, const std::nothrow_t&) noexcept { free(memory); }
void operator delete(void* memory, std::size_t) noexcept { free(memory); }

// Alignment beyond 16 bytes only serves speed on other machines, where cache lines have 64: but the promise is kept. The
// place of the true piece stands before the aligned one.
void* operator new(std::size_t size, std::align_val_t alignment) {
    auto unit = static_cast<std::size_t>(alignment);
    auto start = reinterpret_cast<std::uintptr_t>(or_trap(malloc(size + unit + sizeof(void*))));
    std::uintptr_t aligned = (start + sizeof(void*) + unit - 1) & ~(unit - 1);
    reinterpret_cast<void**>(aligned)[-1] = reinterpret_cast<void*>(start);
    return reinterpret_cast<void*>(aligned);
}
void operator delete(void* memory, std::align_val_t) noexcept {
    if (memory)
        free(static_cast<void**>(memory)[-1]);
}
void operator delete(void* memory, std::size_t, std::align_val_t alignment) noexcept { operator delete(memory, alignment); }
