// How long a GLB of a million triangles takes from bytes to a Scene, and how much memory at the peak.
//
// Each case runs in a process of its own, so that the peak is its own: bench_import [CASE [TRIANGLES]].
#include <antumbra/import.hpp>

#include "base/file.hpp"

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

namespace {

using antumbra::Result;

struct Case {
    const char* name;
    bool indexed; ///< a grid with shared vertices, else every corner a vertex of its own
    int nodes;    ///< the triangles are spread over so many nodes, each with its own mesh
    bool shared;  ///< all nodes show the same mesh
};
constexpr Case kCases[] = {
    {"grid", true, 1, false}, {"soup", false, 1, false}, {"grid-1000", true, 1000, false}, {"shared-1000", true, 1000, true}};

void append_u32(std::string& text, std::uint32_t value) { text.append(reinterpret_cast<const char*>(&value), 4); }

/// Vertices and indices of a wavy grid of about `triangles` triangles.
void make_grid(int triangles, bool indexed, std::string& positions, std::string& indices, int& vertices, int& corners) {
    int side = 1;
    while (2 * side * side < triangles)
        ++side;
    auto point = [&](int x, int y) {
        float p[3] = {float(x), float((x * 7 + y * 3) % 5) * 0.1f, float(y)};
        positions.append(reinterpret_cast<const char*>(p), sizeof p);
        ++vertices;
    };
    if (indexed)
        for (int y = 0; y <= side; ++y)
            for (int x = 0; x <= side; ++x)
                point(x, y);
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            int cell[6][2] = {{0, 0}, {0, 1}, {1, 0}, {1, 0}, {0, 1}, {1, 1}};
            for (auto& corner : cell)
                if (indexed)
                    append_u32(indices, std::uint32_t((y + corner[1]) * (side + 1) + x + corner[0]));
                else
                    point(x + corner[0], y + corner[1]);
            corners += 6;
        }
}

std::string make_glb(const Case& which, int triangles) {
    std::string json = R"({"asset":{"version":"2.0"},"accessors":[)", views, meshes, nodes, binary;
    int meshes_count = which.shared ? 1 : which.nodes;
    for (int m = 0; m < meshes_count; ++m) {
        std::string positions, indices;
        int vertices = 0, corners = 0;
        make_grid(triangles / which.nodes, which.indexed, positions, indices, vertices, corners);
        auto add = [&](const std::string& data, const char* type, int code, int count, bool first) {
            char text[300];
            std::snprintf(text, sizeof text, R"(%s{"bufferView":%d,"componentType":%d,"type":"%s","count":%d})",
                          first ? "" : ",", which.indexed ? 2 * m + (code == 5125) : m, code, type, count);
            json += text;
            std::snprintf(text, sizeof text, R"(%s{"buffer":0,"byteOffset":%zu,"byteLength":%zu})", first ? "" : ",",
                          binary.size(), data.size());
            views += text;
            binary += data;
        };
        add(positions, "VEC3", 5126, vertices, m == 0);
        std::string primitive = R"({"attributes":{"POSITION":)" + std::to_string(which.indexed ? 2 * m : m) + "}";
        if (which.indexed) {
            add(indices, "SCALAR", 5125, corners, false);
            primitive += ",\"indices\":" + std::to_string(2 * m + 1);
        }
        meshes += std::string(m ? "," : "") + "{\"primitives\":[" + primitive + "}]}";
    }
    for (int n = 0; n < which.nodes; ++n)
        nodes += std::string(n ? "," : "") + "{\"mesh\":" + std::to_string(which.shared ? 0 : n) +
                 ",\"translation\":[0," + std::to_string(n) + ",0]}";
    json += "],\"bufferViews\":[" + views + "],\"meshes\":[" + meshes + "],\"nodes\":[" + nodes +
            "],\"buffers\":[{\"byteLength\":" + std::to_string(binary.size()) + "}]}";
    json.resize((json.size() + 3) / 4 * 4, ' ');
    std::string glb = "glTF";
    append_u32(glb, 2);
    append_u32(glb, std::uint32_t(12 + 8 + json.size() + 8 + binary.size()));
    append_u32(glb, std::uint32_t(json.size()));
    glb += "JSON" + json;
    append_u32(glb, std::uint32_t(binary.size()));
    glb += std::string("BIN\0", 4) + binary;
    return glb;
}

double peak_bytes() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return double(usage.ru_maxrss) * 1024;
}

int measure(const std::string& path) {
    double before = peak_bytes();
    auto start = std::chrono::steady_clock::now();
    auto seconds = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); };
    Result<antumbra::RawScene> raw = antumbra::import_file(path);
    double import_seconds = seconds();
    if (!raw)
        return std::fprintf(stderr, "%s\n", raw.status().message().c_str()), 1;
    Result<antumbra::Scene> scene = antumbra::Scene::create(std::move(*raw));
    if (!scene)
        return std::fprintf(stderr, "%s\n", scene.status().message().c_str()), 1;
    double all_seconds = seconds(), triangles = double(scene->triangles().size());
    std::printf("%9.0f %9.3f %9.3f %9.3f %12.1f\n", triangles, import_seconds, all_seconds - import_seconds,
                all_seconds, (peak_bytes() - before) / triangles);
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    // A child of itself measures: the peak of a process never falls, and making the file has one of its own.
    if (argc == 3 && std::strcmp(argv[1], "--measure") == 0)
        return measure(argv[2]);
    int triangles = argc > 2 ? std::atoi(argv[2]) : 1'000'000;
    std::printf("%-12s %9s %9s %9s %9s %12s\n", "case", "triangles", "import s", "create s", "all s", "bytes/tri");
    for (const Case& which : kCases) {
        if (argc > 1 && std::strcmp(argv[1], which.name) != 0 && std::strcmp(argv[1], "all") != 0)
            continue;
        std::string path = "/tmp/antumbra-bench-" + std::to_string(getpid()) + ".glb";
        if (antumbra::Status status = antumbra::write_file_atomically(path, make_glb(which, triangles)); !status)
            return std::fprintf(stderr, "%s\n", status.message().c_str()), 1;
        std::printf("%-12s ", which.name);
        std::fflush(stdout);
        pid_t child = fork();
        if (child == 0) {
            execl("/proc/self/exe", argv[0], "--measure", path.c_str(), static_cast<char*>(nullptr));
            _exit(127);
        }
        int code = 0;
        waitpid(child, &code, 0);
        unlink(path.c_str());
        if (code != 0)
            return 1;
    }
    return 0;
}
