// Opens a .pvs and asks what an eye can see.   usage: query FILE.pvs X Y Z
#include <antumbra/pvs.hpp>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <vector>

int main(int argc, char** argv) {
    if (argc != 5)
        return std::fprintf(stderr, "usage: query FILE.pvs X Y Z\n"), 2;
    std::ifstream in(argv[1], std::ios::binary);
    std::vector<char> file((std::istreambuf_iterator<char>(in)), {});

    auto pvs = antumbra::Pvs::open(std::as_bytes(std::span(file)));
    if (!pvs)
        return std::fprintf(stderr, "%s: %s\n", argv[1], pvs.status().message().c_str()), 1;
    antumbra::PvsCursor cursor; // one per view: keeps the last answer
    pvs->query({std::atof(argv[2]), std::atof(argv[3]), std::atof(argv[4])}, cursor);
    std::printf("%u of %u objects (%s)\n", cursor.visible_count, pvs->object_count(),
                antumbra::to_string(cursor.everything ? antumbra::Guarantee::conservative : pvs->guarantee()));
}
