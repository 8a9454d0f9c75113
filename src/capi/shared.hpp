// What the files of the C interface share: the handles that both know, buffers, texts.
#pragma once

#include <antumbra/antumbra.h>

#include <antumbra/pvs.hpp>

#include <algorithm>
#include <bit>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#if (defined(__EMSCRIPTEN__) || defined(__wasm__)) && !defined(ANTUMBRA_NO_FILES)
#define ANTUMBRA_NO_FILES
#endif
#ifndef ANTUMBRA_NO_FILES
#include "base/file.hpp"
#endif

struct ant_pvs {
    explicit ant_pvs(antumbra::Pvs opened) : pvs(std::move(opened)) {}
    antumbra::Pvs pvs;
#ifndef ANTUMBRA_NO_FILES
    std::optional<antumbra::MappedFile> file; ///< what pvs lies in, if open_file mapped it
#endif
};

namespace antumbra::capi {

inline void copy_error(const std::string& message, char* error, std::size_t error_size) {
    if (!error || error_size == 0)
        return;
    std::size_t length = std::min(message.size(), error_size - 1);
    std::memcpy(error, message.data(), length);
    error[length] = 0;
}

inline ant_status answer(const Status& status, char* error, std::size_t error_size) {
    copy_error(status.message(), error, error_size);
    return static_cast<ant_status>(status.code());
}

/// The rule of every "read" function: `needed` units go to `buffer` if it is there and large enough.
inline ant_status check_buffer(const void* buffer, std::size_t capacity, std::size_t needed) {
    if (!buffer)
        return capacity == 0 ? ANT_OK : ANT_USAGE;
    return capacity < needed ? ANT_LIMIT : ANT_OK;
}

inline ant_status read_text(std::string_view text, char* buffer, std::size_t capacity, std::size_t* length) {
    ant_status status = check_buffer(buffer, capacity, text.size() + 1);
    if (status == ANT_USAGE)
        return status;
    *length = text.size();
    if (status == ANT_OK && buffer) {
        std::copy(text.begin(), text.end(), buffer);
        buffer[text.size()] = 0;
    }
    return status;
}

inline void copy(const Vec3d& from, double (&to)[3]) {
    for (int axis = 0; axis < 3; ++axis)
        to[axis] = from[axis];
}

inline Vec3d vector(const double from[3]) { return {from[0], from[1], from[2]}; }


/// The numbers of the set bits, ascending.
inline ant_status read_ids(std::span<const std::uint64_t> words, std::uint32_t set_bits, std::uint32_t* ids,
                           std::size_t capacity, std::size_t* count) {
    ant_status status = check_buffer(ids, capacity, set_bits);
    if (status == ANT_USAGE)
        return status;
    *count = set_bits;
    if (status != ANT_OK || !ids)
        return status;
    for (std::size_t w = 0; w < words.size(); ++w)
        for (std::uint64_t rest = words[w]; rest != 0; rest &= rest - 1)
            *ids++ = static_cast<std::uint32_t>(w * 64 + static_cast<unsigned>(std::countr_zero(rest)));
    return ANT_OK;
}

inline ant_status read_bits(std::span<const std::uint64_t> words, std::uint32_t objects, std::uint8_t* bytes,
                            std::size_t capacity, std::size_t* count) {
    std::size_t needed = (std::size_t(objects) + 7) / 8;
    ant_status status = check_buffer(bytes, capacity, needed);
    if (status == ANT_USAGE)
        return status;
    *count = needed;
    for (std::size_t i = 0; status == ANT_OK && bytes && i < needed; ++i)
        bytes[i] = static_cast<std::uint8_t>(words[i / 8] >> (i % 8 * 8));
    return status;
}

/// What a renderer was told last; before that, that everything is visible.
class Told {
  public:
    ant_status read(std::span<const std::uint64_t> now, std::uint32_t objects, std::uint32_t* shown,
                    std::size_t shown_capacity, std::size_t* shown_count, std::uint32_t* hidden,
                    std::size_t hidden_capacity, std::size_t* hidden_count);

  private:
    std::vector<std::uint64_t> words_;
    std::uint32_t objects_ = 0;
};

} // namespace antumbra::capi
