// Any bytes, opened as a .pvs file: refused, or answered safely. The mutator makes the checksums right again, so that
// the fuzzer reaches what lies behind them; without a corpus it starts from small valid files.
#include "pvs/random_tree.hpp"
#include "pvs/reseal.hpp"

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

} // namespace

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most, unsigned seed) {
    Random random(seed);
    if (size < kHeaderBytes) {
        std::uint32_t which = random.below(1000);
        PvsData start = which % 2 ? test::random_pvs(which, 60) : test::random_pvs_tree(which, 60);
        std::vector<std::byte> file = *encode_pvs(start, PvsCoding(1 + which % 6));
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
