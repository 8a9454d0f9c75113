#include "capi/shared.hpp"

namespace antumbra::capi {
namespace {

/// Calls use(id) for every bit that `a` has and `b` has not.
template <class Use>
void for_difference(std::span<const std::uint64_t> a, std::span<const std::uint64_t> b, Use&& use) {
    for (std::size_t w = 0; w < a.size(); ++w)
        for (std::uint64_t rest = a[w] & ~b[w]; rest != 0; rest &= rest - 1)
            use(static_cast<std::uint32_t>(w * 64 + static_cast<unsigned>(std::countr_zero(rest))));
}

} // namespace

ant_status Told::read(std::span<const std::uint64_t> now, std::uint32_t objects, std::uint32_t* shown,
                      std::size_t shown_capacity, std::size_t* shown_count, std::uint32_t* hidden,
                      std::size_t hidden_capacity, std::size_t* hidden_count) {
    if (!shown_count || !hidden_count || (!shown && shown_capacity) || (!hidden && hidden_capacity))
        return ANT_USAGE;
    now = now.first((std::size_t(objects) + 63) / 64);
    if (words_.size() != now.size() || objects_ != objects) {
        words_.assign(now.size(), ~std::uint64_t(0));
        if (objects % 64)
            words_.back() = (std::uint64_t(1) << (objects % 64)) - 1;
        objects_ = objects;
    }
    std::size_t to_show = 0, to_hide = 0;
    for (std::size_t w = 0; w < now.size(); ++w) {
        to_show += static_cast<std::size_t>(std::popcount(now[w] & ~words_[w]));
        to_hide += static_cast<std::size_t>(std::popcount(words_[w] & ~now[w]));
    }
    *shown_count = to_show;
    *hidden_count = to_hide;
    if (shown_capacity < to_show || hidden_capacity < to_hide)
        return !shown && !hidden ? ANT_OK : ANT_LIMIT;
    for_difference(now, words_, [&](std::uint32_t id) { *shown++ = id; });
    for_difference(words_, now, [&](std::uint32_t id) { *hidden++ = id; });
    std::copy(now.begin(), now.end(), words_.begin());
    return ANT_OK;
}

} // namespace antumbra::capi
