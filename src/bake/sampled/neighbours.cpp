#include "bake/sampled/neighbours.hpp"

#include "tree/bvh.hpp"

#include <algorithm>
#include <queue>
#include <tuple>

namespace antumbra {
namespace {

double squared_distance(const Box3f& a, const Box3f& b) {
    double sum = 0;
    for (int k = 0; k < 3; ++k) {
        double apart = std::max({0.0, double(b.min[k]) - a.max[k], double(a.min[k]) - b.max[k]});
        sum += apart * apart;
    }
    return sum;
}

double squared_centre_distance(const Box3f& a, const Box3f& b) {
    Vec3d apart = to_double(a).centre() - to_double(b).centre();
    return dot(apart, apart);
}

/// Objects and nodes by how near they are; nodes come before objects at the same distance.
struct Entry {
    double distance, centre_distance;
    bool object;
    std::uint32_t index;
    auto order() const { return std::tie(distance, object, centre_distance, index); }
    bool operator<(const Entry& other) const { return order() > other.order(); } // a min-heap
};

} // namespace

ObjectNeighbours::ObjectNeighbours(const Scene& scene) {
    std::vector<Box3f> boxes;
    for (const Object& object : scene.objects())
        boxes.push_back(object.bounds);
    Bvh tree = build_bvh(boxes);
    begin_.push_back(0);
    for (std::uint32_t o = 0; o < boxes.size(); ++o) {
        std::priority_queue<Entry> open;
        open.push({0, 0, false, 0});
        std::size_t found = 0;
        while (!open.empty() && found < kMost) {
            Entry entry = open.top();
            open.pop();
            if (entry.object) {
                neighbours_.push_back(entry.index);
                ++found;
                continue;
            }
            const BvhNode& node = tree.nodes[entry.index];
            if (!node.leaf()) {
                for (std::uint32_t child : {node.first, node.first + 1})
                    open.push({squared_distance(boxes[o], tree.nodes[child].box), 0, false, child});
                continue;
            }
            for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
                if (std::uint32_t other = tree.order[i]; other != o)
                    open.push({squared_distance(boxes[o], boxes[other]), squared_centre_distance(boxes[o], boxes[other]),
                               true, other});
        }
        begin_.push_back(std::uint32_t(neighbours_.size()));
    }
}

} // namespace antumbra
