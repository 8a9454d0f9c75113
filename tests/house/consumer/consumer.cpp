// Generates, bakes and asks, through nothing but the installed package.
#include <antumbra/bake.hpp>
#include <antumbra/generate.hpp>
#include <antumbra/pvs.hpp>

#include <cstdio>

int main() {
    auto raw = antumbra::generate("apartment");
    if (!raw)
        return std::puts(raw.status().message().c_str()), 1;
    auto scene = antumbra::Scene::create(std::move(*raw));
    if (!scene)
        return std::puts(scene.status().message().c_str()), 1;
    antumbra::BakeOptions options;
    options.cells = {2, 1, 2};
    options.rays_per_cell = 1024;
    auto baked = antumbra::bake(*scene, options);
    if (!baked)
        return std::puts(baked.status().message().c_str()), 1;
    auto bytes = antumbra::encode_pvs(baked->pvs);
    auto pvs = antumbra::Pvs::open(*bytes);
    if (!pvs)
        return std::puts(pvs.status().message().c_str()), 1;
    antumbra::PvsCursor cursor;
    pvs->query(scene->world_bounds().centre(), cursor);
    std::printf("%u of %u objects visible\n", cursor.visible_count, pvs->object_count());
    return cursor.visible_count > 0 && cursor.visible_count <= pvs->object_count() ? 0 : 1;
}
