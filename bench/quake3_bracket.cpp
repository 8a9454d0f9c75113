// The Quake III bracket over whole maps: sampled within exact within what the map's own compiler baked.
//
//   bench_quake3_bracket MAP.bsp.. [--cells N] [--manifest FILE]   prints CSV; exits 1 on a breach that FILE does not name
//
// See tests/support/quake3_bracket.hpp for the law. FILE holds one exception a line ("MAP leaf L cluster C surface S", the
// rest of a line after " #" is a remark).
#include "../tests/support/quake3_bracket.hpp"

#include "base/file.hpp"

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>

using namespace antumbra;

int main(int argc, char** argv) {
    std::uint32_t cells = 100;
    std::set<std::string> known;
    std::vector<std::string> maps;
    for (int i = 1; i < argc; ++i) {
        if (i + 1 < argc && std::strcmp(argv[i], "--cells") == 0)
            cells = std::uint32_t(std::strtoul(argv[++i], nullptr, 10));
        else if (i + 1 < argc && std::strcmp(argv[i], "--manifest") == 0) {
            std::ifstream file(argv[++i]);
            for (std::string line; std::getline(file, line);)
                known.insert(line.substr(0, line.find(" #")));
        } else
            maps.push_back(argv[i]);
    }
    BakeOptions options;
    options.rays_per_cell = 20000;
    options.holdout_rays = 1000;
    int failed = 0;
    std::puts("map,leaves,brushes,cells,solid,sampled_per_cell,exact_per_cell,sampled_not_exact,surfaces_exact,"
              "surfaces_baked,undecided,exceptions,unnamed");
    for (const std::string& path : maps) {
        Result<MappedFile> file = MappedFile::open(path);
        if (!file)
            return std::fprintf(stderr, "%s\n", file.status().message().c_str()), 1;
        Result<Quake3Map> map = import_quake3(file->bytes(), path);
        if (!map)
            return std::fprintf(stderr, "%s\n", map.status().message().c_str()), 1;
        std::string name = path.substr(path.rfind('/') + 1);
        test::Quake3Bracket bracket(*map, name);
        test::Quake3Bracket::Counts counts = bracket.check(cells, 1, options);
        std::size_t unnamed = 0;
        for (const std::string& one : counts.exceptions) {
            unnamed += !known.contains(one);
            std::fprintf(stderr, "%s\n", one.c_str());
        }
        double n = double(std::max<std::uint64_t>(counts.cells, 1));
        std::printf("%s,%zu,%zu,%llu,%llu,%.1f,%.1f,%llu,%.1f,%.1f,%llu,%zu,%zu\n", name.c_str(), bracket.leaves(),
                    bracket.brushes(), (unsigned long long)counts.cells, (unsigned long long)counts.solid,
                    double(counts.sampled) / n, double(counts.exact) / n, (unsigned long long)counts.sampled_not_exact,
                    double(counts.surfaces) / n, double(counts.baked_surfaces) / n, (unsigned long long)counts.undecided,
                    counts.exceptions.size(), unnamed);
        std::fflush(stdout);
        failed |= counts.sampled_not_exact > 0 || unnamed > 0;
    }
    return failed;
}
