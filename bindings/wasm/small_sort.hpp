// Included before every file of a module (-include): sorts of vectors take a tenth of the bytes of libc++'s, which unrolls
// five cases for each type and order. Overloads in std are not what one does; they are kept to this build, where a
// download is at stake, and tests compare its answers with the native ones bit for bit.
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

namespace std {

/// Heap sort (Williams 1964): n log n in the worst case, in place. Not stable, as std::sort is not.
template <class T, class Less>
__attribute__((noinline)) void antumbra_heap_sort(T* items, size_t count, Less less) {
    auto sink = [&](size_t at, size_t end) {
        for (size_t child; (child = 2 * at + 1) < end; at = child) {
            if (child + 1 < end && less(items[child], items[child + 1]))
                ++child;
            if (!less(items[at], items[child]))
                return;
            std::swap(items[at], items[child]);
        }
    };
    for (size_t at = count / 2; at-- > 0;)
        sink(at, count);
    for (size_t end = count; end-- > 1;) {
        std::swap(items[0], items[end]);
        sink(0, end);
    }
}

template <class T, class Less>
void sort(__wrap_iter<T*> begin, __wrap_iter<T*> end, Less less) {
    if (begin != end)
        antumbra_heap_sort(&*begin, static_cast<size_t>(end - begin), less);
}

template <class T>
void sort(__wrap_iter<T*> begin, __wrap_iter<T*> end) {
    sort(begin, end, [](const T& a, const T& b) { return a < b; });
}

} // namespace std
