#include "evaluate/item_buffer.hpp"

#include "base/parallel.hpp"
#include "base/random.hpp"

#include <map>

namespace antumbra {
namespace {

/// The picture point of a pixel's ray: a pure function of (options, pixel).
Ray ray_of(const PixelRays& rays, const ItemOptions& options, std::uint32_t x, std::uint32_t y) {
    if (options.sampling == PixelSampling::centre)
        return rays.at(x + 0.5, y + 0.5);
    // The first two numbers of Random(seed, stream, pixel), without the others that it would make in advance.
    auto [d, c, b, a] = philox({0, y * rays.width() + x, std::uint32_t(options.stream), std::uint32_t(options.stream >> 32)},
                               {std::uint32_t(options.seed), std::uint32_t(options.seed >> 32)});
    auto uniform = [](std::uint32_t high, std::uint32_t low) {
        return double((std::uint64_t(high) << 32 | low) >> 11) * 0x1p-53;
    };
    return rays.at(x + uniform(a, b), y + uniform(c, d));
}

} // namespace

ItemBuffer ItemBuffer::render(const Tracer& tracer, const PixelRays& rays, const ItemOptions& options, const Job& job) {
    struct Row {
        std::vector<std::uint32_t> triangles, end;
    };
    std::vector<Row> rows(rays.height());
    parallel_for(rays.height(), job, [&](std::size_t y, unsigned) {
        thread_local SeenBatch seen;
        std::vector<Ray> batch(rays.width()); // neighbours in a row share their way through the tree
        for (std::uint32_t x = 0; x < rays.width(); ++x)
            batch[x] = ray_of(rays, options, x, std::uint32_t(y));
        tracer.seen_batch(batch, seen);
        rows[y].triangles = seen.triangles;
        rows[y].end.assign(seen.begin.begin() + 1, seen.begin.end());
    });
    ItemBuffer buffer(rays, options);
    buffer.begin_.assign(1, 0);
    buffer.begin_.reserve(rays.pixels() + 1);
    for (Row& row : rows) {
        std::uint64_t first = buffer.triangles_.size();
        row.end.resize(rays.width(), row.end.empty() ? 0 : row.end.back()); // rows left out after a cancel
        for (std::uint32_t end : row.end)
            buffer.begin_.push_back(first + end);
        buffer.triangles_.insert(buffer.triangles_.end(), row.triangles.begin(), row.triangles.end());
    }
    return buffer;
}

Ray ItemBuffer::ray(std::uint32_t x, std::uint32_t y) const {
    return ray_of(rays_, options_, x, y);
}

void mark_seen(const Scene& scene, const ItemBuffer& buffer, std::span<std::uint64_t> bits) {
    for (std::uint32_t y = 0; y < buffer.height(); ++y)
        for (std::uint32_t x = 0; x < buffer.width(); ++x)
            for (std::uint32_t triangle : buffer.seen(x, y))
                set_bit(bits, scene.triangle_objects()[triangle]);
}

std::vector<LostPixels> find_lost_pixels(const Scene& scene, const Arbiter& arbiter, const ItemBuffer& buffer,
                                         std::span<const std::uint64_t> reported) {
    std::map<std::uint32_t, LostPixels> lost;
    for (std::uint32_t y = 0; y < buffer.height(); ++y)
        for (std::uint32_t x = 0; x < buffer.width(); ++x)
            for (std::uint32_t triangle : buffer.seen(x, y)) {
                std::uint32_t object = scene.triangle_objects()[triangle];
                if (has_bit(reported, object))
                    continue;
                auto [entry, fresh] = lost.try_emplace(object);
                LostPixels& pixels = entry->second;
                Ray ray = buffer.ray(x, y);
                Verdict verdict = arbiter.sees(ray.origin, ray.origin + ray.direction, triangle);
                bool first_confirmed = verdict == Verdict::clear && pixels.confirmed == 0;
                ++(verdict == Verdict::clear        ? pixels.confirmed
                   : verdict == Verdict::degenerate ? pixels.grazing
                                                    : pixels.unconfirmed);
                if (fresh || first_confirmed) {
                    pixels.object = object;
                    pixels.x = x;
                    pixels.y = y;
                }
            }
    std::vector<LostPixels> result;
    for (const auto& [object, pixels] : lost)
        result.push_back(pixels);
    return result;
}

} // namespace antumbra
