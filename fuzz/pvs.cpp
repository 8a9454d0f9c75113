// Any bytes, opened as a .pvs file, and as the scene of cullers: refused, or answered safely. The mutator makes the checksums right again, so that
// the fuzzer reaches what lies behind them; without a corpus it starts from small valid files.
#include "pvs/random_tree.hpp"
#include "pvs/reseal.hpp"

#include <antumbra/cull.hpp>
#include <antumbra/pvs.hpp>

#include <cstdlib>
#include <cstring>

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);

namespace {

using namespace antumbra;

/// Changes the content of one chunk in place, so that the container stays whole.
void mutate_one_chunk(std::span<std::byte> file, Random& random) {
    std::vector<test::TableEntry> entries = test::table_of(file);
    if (entries.empty())
        return;
    const test::TableEntry& entry = entries[random.below(static_cast<std::uint32_t>(entries.size()))];
    if (entry.bytes == 0 || entry.offset > file.size() || entry.bytes > file.size() - entry.offset)
        return;
    std::span<std::byte> chunk = file.subspan(std::size_t(entry.offset), std::size_t(entry.bytes));
    (void)LLVMFuzzerMutate(reinterpret_cast<std::uint8_t*>(chunk.data()), chunk.size(), chunk.size());
}

/// The objects of `data`, and their boxes' faces as occluders.
CullScene scene_of(const PvsData& data, Random& random) {
    OccluderSet set;
    std::vector<Box3f> bounds;
    std::vector<std::uint32_t> flags;
    constexpr std::uint32_t kFaces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    for (const PvsObject& object : data.objects) {
        bounds.push_back(object.bounds);
        flags.push_back(object.flags);
        Vec3f size = object.bounds.max - object.bounds.min;
        if (!(size.x > 0 && size.y > 0 && size.z > 0) || bounds.size() > 6)
            continue;
        auto base = static_cast<std::uint32_t>(set.vertices.size());
        for (int corner = 0; corner < 8; ++corner)
            set.vertices.push_back(object.bounds.corner(corner));
        for (const auto& face : kFaces) {
            OccluderPolygon polygon;
            polygon.first = static_cast<std::uint32_t>(set.loops.size());
            polygon.count = 4;
            polygon.double_sided = random.below(2);
            for (std::uint32_t corner : face)
                set.loops.push_back(base + corner);
            measure_occluder(set, polygon);
            set.polygons.push_back(polygon);
        }
    }
    connect_occluders(set);
    group_occluders(set);
    CullSceneInput input;
    input.bounds = bounds;
    input.flags = flags;
    input.occluders = &set;
    return CullScene::create(input);
}

/// Whatever scene a file holds, every method culls it.
void cull(const CullScene& scene) {
    View view;
    view.eye = {1, 2, 3};
    for (std::string_view name : culler_names()) {
        auto culler = make_culler(name, scene, {.occluder_choice = OccluderChoice::first_hit});
        ViewState state;
        CullResult result;
        if (culler)
            (*culler)->cull(view, state, result);
        if (result.visible_count > scene.object_count())
            std::abort();
    }
}

} // namespace

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most, unsigned seed) {
    Random random(seed);
    if (size < kHeaderBytes) {
        std::uint32_t which = random.below(1000);
        PvsData start = which % 2 ? test::random_pvs(which, 60) : test::random_pvs_tree(which, 60);
        std::vector<std::byte> file = *encode_pvs(start, PvsCoding(1 + which % 6));
        if (which % 3 == 0)
            file = *add_pvs_chunks(file, *prepare_chunks(scene_of(start, random), {.leaves = 4, .per_set = 3, .first_hit_leaves = 1}));
        size = std::min(file.size(), most);
        std::memcpy(data, file.data(), size);
    }
    std::span<std::byte> file(reinterpret_cast<std::byte*>(data), size);
    if (random.below(4) != 0)
        mutate_one_chunk(file, random);
    else
        size = LLVMFuzzerMutate(data, size, most);
    if (random.below(8) != 0)
        test::reseal({reinterpret_cast<std::byte*>(data), size});
    return size;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    Result<Pvs> pvs = Pvs::open(std::as_bytes(std::span(data, size)));
    if (!pvs)
        return 0;
    for (std::uint32_t o = 0; o < pvs->object_count(); ++o)
        (void)pvs->object(o);
    if (Result<CullScene> scene = CullScene::open(*pvs))
        cull(*scene);
    PvsCursor cursor;
    std::uint64_t cells = pvs->grid().cells();
    for (std::uint64_t c = 0; c < std::min<std::uint64_t>(cells, 500); ++c) {
        Vec3d eye = pvs->grid().cell(c).centre();
        (void)pvs->query(eye, cursor);
        // The centre of a cell lies in it unless cells are thinner than numbers can tell.
        if (cursor.visible_count > pvs->object_count() || cursor.cell < 0 || cursor.cell >= std::int64_t(cells))
            std::abort();
    }
    Box3d bounds = pvs->tree().nodes.empty() ? pvs->grid().bounds : pvs->tree().bounds;
    for (int corner = 0; corner < 8; ++corner) {
        Vec3d eye = bounds.corner(corner);
        (void)pvs->query(eye, cursor);
        (void)pvs->query_range(camera_range({eye, eye}, bounds.centre() - eye, {0.1, 1, 0.2}, 0.5, 1.5), cursor);
        (void)pvs->is_box_visible({eye, eye}, cursor);
        if (cursor.visible_count > pvs->object_count())
            std::abort();
    }
    return 0;
}
