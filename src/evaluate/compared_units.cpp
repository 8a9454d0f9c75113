#include "evaluate/compared_units.hpp"

#include "bake/exact/baked_cells.hpp"

#include <antumbra/evaluate.hpp>

#include <numeric>

namespace antumbra {
namespace {

using exact::Units;

/// Numbers of sets that grow together.
class Groups {
  public:
    explicit Groups(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0u); }
    std::uint32_t find(std::uint32_t at) {
        while (parent_[at] != at)
            at = parent_[at] = parent_[parent_[at]];
        return at;
    }
    void join(std::uint32_t a, std::uint32_t b) {
        a = find(a);
        b = find(b);
        parent_[std::max(a, b)] = std::min(a, b); // the lowest names the group
    }

  private:
    std::vector<std::uint32_t> parent_;
};

} // namespace

Result<ComparedUnits> ComparedUnits::make(const Scene& scene, const Pvs& a, const Pvs& b) {
    const Pvs* files[2] = {&a, &b};
    Units own[2];
    ComparedUnits units;
    bool same_width = crack_width(a) == crack_width(b);
    for (int side = 0; side < 2; ++side) {
        const Pvs& pvs = *files[side];
        bool is_of_scene = crack_width(pvs) == scene.crack_width();
        Result<Units> found = is_of_scene ? exact::units_of(scene, pvs) : Units::objects(scene);
        if (!found)
            return found.status().in(side ? "B" : "A");
        own[side] = std::move(*found);
        for (std::uint32_t u = 0; u < own[side].count(); ++u)
            units.drawn_[side].push_back({is_of_scene ? exact::bit_of(pvs, u) : u, u,
                                          static_cast<std::uint32_t>(own[side].triangles_of(u).size())});
    }
    if (!same_width || a.cluster_count() == 0 || b.cluster_count() == 0) {
        for (std::uint32_t o = 0; o < scene.objects().size(); ++o) {
            units.object_.push_back(o);
            for (auto& listed : units.listed_)
                listed.push_back({o, o, 0});
        }
        units.of_.assign(scene.triangle_objects().begin(), scene.triangle_objects().end());
    } else {
        Groups groups(std::size_t(own[0].count()) + own[1].count());
        for (std::uint32_t t = 0; t < scene.triangles().size(); ++t)
            groups.join(own[0].of[t], own[0].count() + own[1].of[t]);
        std::vector<std::uint32_t> number(own[0].count()); // a group's lowest member is a cluster of A
        for (std::uint32_t u = 0; u < own[0].count(); ++u)
            if (groups.find(u) == u) {
                number[u] = units.count();
                units.object_.push_back(scene.triangle_objects()[own[0].triangles_of(u)[0]]);
            }
        for (int side = 0; side < 2; ++side)
            for (std::uint32_t u = 0; u < own[side].count(); ++u)
                units.listed_[side].push_back(
                    {exact::bit_of(*files[side], u), number[groups.find(u + (side ? own[0].count() : 0))], 0});
        for (std::uint32_t t = 0; t < scene.triangles().size(); ++t)
            units.of_.push_back(number[groups.find(own[0].of[t])]);
        bool same = units.count() == own[0].count() && units.count() == own[1].count();
        units.kind_ = same ? CompareUnits::clusters : CompareUnits::groups;
    }
    for (std::uint32_t object : units.object_)
        units.counted_.push_back(!scene.objects()[object].has(kAlwaysVisible));
    return units;
}

std::vector<std::uint64_t> ComparedUnits::listed(int side, const std::vector<std::uint64_t>& row) const {
    std::vector<std::uint64_t> bits((object_.size() + 63) / 64, 0);
    for (const Part& part : listed_[side])
        if ((row[part.bit / 64] >> (part.bit % 64) & 1) && counted_[part.unit])
            bits[part.unit / 64] |= std::uint64_t(1) << (part.unit % 64);
    return bits;
}

std::uint64_t ComparedUnits::triangles(int side, const std::vector<std::uint64_t>& row) const {
    std::uint64_t sum = 0;
    for (const Part& part : drawn_[side])
        if (row[part.bit / 64] >> (part.bit % 64) & 1)
            sum += part.triangles;
    return sum;
}

} // namespace antumbra
