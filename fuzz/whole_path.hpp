// What every reader's fuzz driver does with what was read: everything that a user's file goes through.
#pragma once

#include <antumbra/import.hpp>

#include <cstdlib>
#include <utility>

namespace antumbra::fuzz {

/// Small enough that a run of libFuzzer with its default memory limit never comes near it.
inline ImportOptions small_limits() {
    ImportOptions options;
    options.limits.memory = 64u << 20;
    options.limits.triangles = 200'000;
    options.limits.objects = 100'000;
    return options;
}

/// Makes the scene, checks that its parts fit together, validates it.
inline void go_on_with(Result<RawScene> raw) {
    if (!raw)
        return;
    Result<Scene> scene = Scene::create(std::move(*raw));
    if (!scene) {
        // Whatever a reader accepts is at worst corrupt, never inconsistent.
        if (scene.status().code() == ErrorCode::internal)
            std::abort();
        return;
    }
    std::size_t triangles = 0;
    for (const Object& object : scene->objects())
        triangles += object.triangle_count;
    if (triangles != scene->triangles().size())
        std::abort();
    validate(*scene);
}

} // namespace antumbra::fuzz
