#include "cull/occluder_interest.hpp"

namespace antumbra {

void OccluderInterest::look(const CullScene::Data& scene, OccluderChoice choice, const Pvs* pvs, const Camera& camera) {
    choice_ = choice;
    asks_cell_ = false;
    if (pvs) {
        (void)pvs->query(camera.eye + scene.origin, cell_);
        asks_cell_ = !cell_.everything;
    }
    list_ = {};
    if (choice != OccluderChoice::first_hit || scene.first_hit_sets.empty() || camera.orthographic)
        return;
    list_ = scene.first_hit_sets.at(camera.eye, camera.forward);
    listed_in_.resize(scene.occluders.polygons.size());
    if (++round_ == 0) { // once in four thousand million frames
        std::fill(listed_in_.begin(), listed_in_.end(), Listed{});
        round_ = 1;
    }
    for (std::uint32_t place = 0; place < list_.size(); ++place) {
        const ConvexGroups::Group& group = scene.groups.groups[list_[place]];
        for (std::uint32_t m = group.first; m < group.first + group.count; ++m)
            listed_in_[scene.groups.members[m]] = {round_, place};
    }
}

} // namespace antumbra
