#include "mos/occluder_stack.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace antumbra {
namespace {

struct Corner {
    double x, y, z;          ///< camera space; later pixels
    bool silhouette = false; ///< the edge that begins here
};

/// Pixels wholly on the inner side: along_x * x + along_y * y + offset >= 0 at their centres.
struct InnerSide {
    double along_x, along_y, offset;
};

/// Whichever side it shows blocks; not edge-on.
bool blocks_towards(const OccluderPolygon& polygon, const Camera& camera) {
    double towards = dot(polygon.normal, camera.eye) + polygon.offset;
    return polygon.double_sided ? towards != 0 : towards > 0;
}

/// Nothing on the other side of an edge that blocks, too: as in patch_raster.hpp.
bool is_silhouette(const OccluderSet& set, const OccluderPolygon& polygon, std::uint32_t edge, const Camera& camera) {
    std::uint32_t neighbour = set.neighbours[polygon.first + edge], index = neighbour & ~kSameDirection;
    if (index == kNoPolygon || !blocks_towards(set.polygons[index], camera))
        return true;
    auto front = [&](const OccluderPolygon& p) { return dot(p.normal, camera.eye) + p.offset > 0; };
    return (front(polygon) == front(set.polygons[index])) == ((neighbour & kSameDirection) != 0);
}

/// Half-planes of the silhouette edges of a convex loop, moved in by half a pixel's reach.
std::vector<InnerSide> inner_sides(const std::vector<Corner>& loop) {
    double turn = 0;
    for (std::size_t i = 0; i < loop.size(); ++i) {
        const Corner &a = loop[i], &b = loop[(i + 1) % loop.size()];
        turn += a.x * b.y - b.x * a.y;
    }
    double sign = turn > 0 ? 1 : -1;
    std::vector<InnerSide> sides;
    for (std::size_t i = 0; i < loop.size(); ++i) {
        const Corner &a = loop[i], &b = loop[(i + 1) % loop.size()];
        if (!a.silhouette)
            continue;
        double nx = -(b.y - a.y) * sign, ny = (b.x - a.x) * sign;
        sides.push_back({nx, ny, -(nx * a.x + ny * a.y) - (0.5 + kEdgeSlack) * (std::abs(nx) + std::abs(ny))});
    }
    return sides;
}

/// No polygon of that area covers more pixels from there.
double most_pixels(const OccluderPolygon& polygon, const OccluderSet& set, const Screen& screen) {
    double reach = 0;
    for (std::uint32_t v : set.loop(polygon))
        reach = std::max(reach, length(to_double(set.vertices[v]) - polygon.centre));
    double nearest = length(polygon.centre - screen.camera.eye) - reach;
    return nearest <= 0 ? 1e300 : polygon.area / (nearest * nearest) * screen.scale_x * screen.scale_y * 3;
}

/// Sutherland and Hodgman, against depth alone; the picture's borders cut rows and columns.
void clip_near(std::vector<Corner>& loop, double depth, std::vector<Corner>& work) {
    work.clear();
    for (std::size_t i = 0; i < loop.size(); ++i) {
        const Corner &a = loop[i], &b = loop[(i + 1) % loop.size()];
        if (a.z >= depth)
            work.push_back(a);
        if ((a.z >= depth) != (b.z >= depth)) {
            double t = (depth - a.z) / (b.z - a.z);
            work.push_back({a.x + (b.x - a.x) * t, a.y + (b.y - a.y) * t, depth, a.z >= depth || a.silhouette});
        }
    }
    loop.swap(work);
}

/// A number for a member such that sums over sets hardly ever meet; verified covers do not depend on it.
std::uint64_t mix(std::uint64_t value) {
    value = (value + 0x9E3779B97F4A7C15u) * 0xBF58476D1CE4E5B9u;
    value = (value ^ value >> 27) * 0x94D049BB133111EBu;
    return value ^ value >> 31;
}

} // namespace

OccluderStack::OccluderStack(const OccluderSet& set, const Screen& screen, const StackOptions& options)
    : width_(screen.width) {
    Box3d start;
    start.extend(screen.camera.eye);
    for (std::uint32_t p = 0; p < set.polygons.size(); ++p) {
        const OccluderPolygon& polygon = set.polygons[p];
        if (!blocks_towards(polygon, screen.camera) || most_pixels(polygon, set, screen) < options.least_pixels)
            continue;
        if (polygon.synthetic && !set.solids[polygon.solid].serves(start))
            continue;
        add_polygon(set, p, screen, options);
    }
    sort_layers(static_cast<std::size_t>(screen.width) * static_cast<std::size_t>(screen.height), options.layers);
}

void OccluderStack::add_polygon(const OccluderSet& set, std::uint32_t index, const Screen& screen,
                                const StackOptions& options) {
    const OccluderPolygon& polygon = set.polygons[index];
    const Camera& camera = screen.camera;
    std::vector<Corner> loop, work;
    for (std::uint32_t i = 0; i < polygon.count; ++i) {
        Vec3d offset = to_double(set.vertices[set.loops[polygon.first + i]]) - camera.eye;
        loop.push_back({dot(camera.right, offset), dot(camera.up, offset), dot(camera.forward, offset),
                        is_silhouette(set, polygon, i, camera)});
    }
    clip_near(loop, screen.clip_depth, work);
    if (loop.size() < 3)
        return;
    double low = 1e300, high = -1e300;
    for (Corner& corner : loop) {
        corner.x = screen.centre_x + corner.x / corner.z * screen.scale_x;
        corner.y = screen.centre_y + corner.y / corner.z * screen.scale_y;
        low = std::min(low, corner.y);
        high = std::max(high, corner.y);
    }
    // 1 / z is affine over the screen.
    double c = -(dot(polygon.normal, camera.eye) + polygon.offset);
    double along_x = dot(polygon.normal, camera.right) / c / screen.scale_x;
    double along_y = dot(polygon.normal, camera.up) / c / screen.scale_y;
    double at_zero = dot(polygon.normal, camera.forward) / c - along_x * screen.centre_x - along_y * screen.centre_y;
    std::vector<InnerSide> sides;
    if (options.coverage == PixelCoverage::inner) {
        sides = inner_sides(loop);
        at_zero -= 0.5 * (std::abs(along_x) + std::abs(along_y)); // the farthest of the square
    }
    std::size_t begin = fragments_.size();
    int first = int(std::clamp(std::ceil(low - 0.5), 0.0, double(screen.height)));
    int last = int(std::clamp(std::floor(high - 0.5), -1.0, double(screen.height - 1)));
    for (int row = first; row <= last; ++row) {
        double y = row + 0.5, left = 1e300, right = -1e300;
        for (std::size_t i = 0; i < loop.size(); ++i) {
            const Corner &a = loop[i], &b = loop[(i + 1) % loop.size()];
            if ((a.y <= y) == (b.y <= y))
                continue;
            double x = a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y));
            left = std::min(left, x);
            right = std::max(right, x);
        }
        int from = int(std::clamp(std::ceil(left - 0.5), 0.0, double(screen.width)));
        int to = int(std::clamp(std::floor(right - 0.5), -1.0, double(screen.width - 1)));
        for (int x = from; x <= to; ++x)
            if (std::all_of(sides.begin(), sides.end(), [&](const InnerSide& side) {
                    return side.along_x * (x + 0.5) + side.along_y * y + side.offset >= 0;
                }))
                fragments_.push_back({static_cast<std::uint32_t>(row * screen.width + x),
                                  static_cast<float>(at_zero + along_x * (x + 0.5) + along_y * y)});
    }
    if (fragments_.size() - begin < options.least_pixels) {
        fragments_.resize(begin);
        return;
    }
    polygon_.push_back(index);
    first_fragment_.push_back(static_cast<std::uint32_t>(fragments_.size()));
}

void OccluderStack::sort_layers(std::size_t pixels, std::uint32_t most) {
    std::vector<std::uint32_t> begin(pixels + 1, 0);
    for (const Fragment& fragment : fragments_)
        ++begin[fragment.pixel + 1];
    for (std::size_t p = 0; p < pixels; ++p)
        begin[p + 1] += begin[p];
    std::vector<Layer> all(fragments_.size());
    std::vector<std::uint32_t> at(begin.begin(), begin.end() - 1);
    for (std::uint32_t member = 0; member < members(); ++member)
        for (const Fragment& fragment : fragments(member))
            all[at[fragment.pixel]++] = {member, fragment.nearness};
    first_.assign(1, 0);
    for (std::size_t p = 0; p < pixels; ++p) {
        auto from = all.begin() + begin[p], to = all.begin() + begin[p + 1];
        std::sort(from, to, [](const Layer& a, const Layer& b) {
            return a.nearness != b.nearness ? a.nearness > b.nearness : a.member < b.member;
        });
        to = from + std::min<std::ptrdiff_t>(to - from, std::ptrdiff_t(most));
        std::uint64_t sum = 0;
        for (auto layer = from; layer != to; ++layer) {
            sum += mix(layer->member);
            layers_.push_back(*layer);
            prefix_.push_back(sum);
        }
        first_.push_back(static_cast<std::uint32_t>(layers_.size()));
    }
}

std::size_t OccluderStack::in_front(std::size_t pixel, float nearness) const {
    std::span<const Layer> layers = stack(pixel);
    auto end = std::partition_point(layers.begin(), layers.end(),
                                    [&](const Layer& layer) { return layer.nearness > nearness; });
    return static_cast<std::size_t>(end - layers.begin());
}

bool OccluderStack::lists_of(const PixelRect& rect, float nearness, ItemTable& table,
                             std::vector<std::uint32_t>& members) const {
    table = {};
    members.clear();
    std::unordered_map<std::uint64_t, std::uint32_t> seen; // only asked whether, never walked through
    std::unordered_map<std::uint32_t, std::uint32_t> number;
    std::vector<std::uint32_t> list;
    for (int y = rect.y0; y <= rect.y1; ++y)
        for (int x = rect.x0; x <= rect.x1; ++x) {
            auto pixel = static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
            std::size_t count = in_front(pixel, nearness);
            if (count == 0)
                return false;
            if (!seen.emplace(prefix_[first_[pixel] + count - 1], 0).second)
                continue;
            list.clear();
            for (const Layer& layer : stack(pixel).first(count)) {
                auto [entry, fresh] = number.emplace(layer.member, static_cast<std::uint32_t>(members.size()));
                if (fresh)
                    members.push_back(layer.member);
                list.push_back(entry->second);
            }
            table.add(list);
        }
    table.items = static_cast<std::uint32_t>(members.size());
    return true;
}

bool OccluderStack::is_cover(const PixelRect& rect, float nearness, std::span<const std::uint32_t> cover) const {
    for (int y = rect.y0; y <= rect.y1; ++y)
        for (int x = rect.x0; x <= rect.x1; ++x) {
            auto pixel = static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
            std::span<const Layer> front = stack(pixel).first(in_front(pixel, nearness));
            if (std::none_of(front.begin(), front.end(), [&](const Layer& layer) {
                    return std::binary_search(cover.begin(), cover.end(), layer.member);
                }))
                return false;
        }
    return true;
}

} // namespace antumbra
