// The exact method through the public door.
#include "bake/exact/proof.hpp"
#include "village.hpp"

#include <antumbra/bake.hpp>

#include <gtest/gtest.h>

#include <atomic>
#include <bit>
#include <filesystem>

namespace antumbra {
namespace {

bool listed(const PvsData& pvs, std::uint32_t row, std::uint32_t object) {
    return pvs.rows[row * pvs.words_per_row() + object / 64] >> (object % 64) & 1;
}

TEST(ExactBake, IsExactAndNoFreshRaySeesMore) {
    Scene scene = village();
    Result<BakeResult> result = bake(scene, exact_options());
    ASSERT_TRUE(result.ok()) << result.status().message();
    EXPECT_EQ(result->pvs.guarantee, Guarantee::exact);
    EXPECT_EQ(result->pvs.method, "exact");
    EXPECT_EQ(result->statistics.exact.undecided, 0u);
    EXPECT_EQ(result->statistics.holdout_misses, 0u);
    EXPECT_GT(result->statistics.holdout_rays, 10000u);
    EXPECT_GT(result->statistics.exact.found_by_query, 0u);
}

TEST(ExactBake, HoldsEverythingThatASampledBakeFindsAndTheSameWithMoreRays) {
    Scene scene = village();
    BakeOptions more = exact_options(), sampled = exact_options();
    more.rays_per_cell = 20000;
    more.seed = 9;
    sampled.method = "sampled";
    sampled.rays_per_cell = 50000;
    Result<BakeResult> a = bake(scene, exact_options()), b = bake(scene, more), c = bake(scene, sampled);
    ASSERT_TRUE(a.ok() && b.ok() && c.ok());
    EXPECT_EQ(a->pvs.cell_row, b->pvs.cell_row);
    EXPECT_EQ(a->pvs.rows, b->pvs.rows);
    for (std::size_t cell = 0; cell < a->pvs.cell_row.size(); ++cell) {
        std::uint32_t exact = a->pvs.cell_row[cell], found = c->pvs.cell_row[cell];
        ASSERT_EQ(exact == kCellSolid, found == kCellSolid);
        for (std::uint32_t o = 0; exact < kCellSolid && o < scene.objects().size(); ++o)
            EXPECT_TRUE(listed(a->pvs, exact, o) || !listed(c->pvs, found, o)) << cell << " " << o;
    }
}

TEST(ExactBake, IsTheSameForAnyNumberOfThreadsAndWhenResumed) {
    Scene scene = village();
    Job one, three;
    one.threads = 1;
    three.threads = 3;
    BakeOptions o = exact_options();
    Result<BakeResult> a = bake(scene, o, one), b = bake(scene, o, three);
    ASSERT_TRUE(a.ok() && b.ok());
    EXPECT_EQ(*encode_pvs(a->pvs), *encode_pvs(b->pvs));
    o.checkpoint = ::testing::TempDir() + "exact_bake.part";
    std::filesystem::remove(o.checkpoint);
    ASSERT_TRUE(bake(scene, o, one).ok());
    o.resume = true;
    Result<BakeResult> c = bake(scene, o, one);
    ASSERT_TRUE(c.ok()) << c.status().message();
    EXPECT_GT(c->statistics.cells_resumed, 0u);
    EXPECT_EQ(*encode_pvs(a->pvs), *encode_pvs(c->pvs));
    std::filesystem::remove(o.checkpoint);
}

TEST(ExactBake, ClustersAndTrianglesAreListedBesidesTheSameObjects) {
    Scene scene = village();
    Result<BakeResult> objects = bake(scene, exact_options());
    ASSERT_TRUE(objects.ok());
    std::uint64_t listed_triangles = 0, listed_clusters = 0;
    for (Granularity granularity : {Granularity::cluster, Granularity::triangle}) {
        BakeOptions o = exact_options();
        o.exact.granularity = granularity;
        o.exact.cluster_triangles = 4;
        Result<BakeResult> fine = bake(scene, o);
        ASSERT_TRUE(fine.ok()) << fine.status().message();
        EXPECT_EQ(fine->statistics.exact.undecided, 0u);
        EXPECT_EQ(fine->statistics.holdout_misses, 0u);
        std::size_t clusters = fine->pvs.cluster_count();
        if (granularity == Granularity::triangle) {
            ASSERT_EQ(clusters, scene.triangles().size());
        } else { // each of the 18 boxes has 12 triangles
            ASSERT_GE(clusters, 18u * 3);
            ASSERT_LT(clusters, 18u * 12);
            for (std::size_t c = 0; c < clusters; ++c)
                ASSERT_LE(fine->pvs.cluster_first[c + 1] - fine->pvs.cluster_first[c], 4u);
        }
        Result<std::vector<std::byte>> bytes = encode_pvs(fine->pvs);
        ASSERT_TRUE(bytes.ok()) << bytes.status().message();
        Result<Pvs> pvs = Pvs::open(*bytes);
        ASSERT_TRUE(pvs.ok()) << pvs.status().message();
        ASSERT_EQ(pvs->cluster_count(), clusters);
        EXPECT_EQ(pvs->cluster_first(0), 0u);
        EXPECT_EQ(pvs->cluster_first(pvs->cluster_count()), scene.triangles().size());
        PvsCursor cursor;
        for (std::size_t cell = 0; cell < objects->pvs.cell_row.size(); ++cell) {
            std::uint32_t coarse = objects->pvs.cell_row[cell];
            ASSERT_EQ(coarse >= kCellSolid, fine->pvs.cell_row[cell] >= kCellSolid);
            if (coarse >= kCellSolid)
                continue;
            pvs->query(fine->pvs.grid.cell(cell).centre(), cursor);
            for (std::uint32_t object = 0; object < scene.objects().size(); ++object) {
                bool some = false;
                for (std::uint32_t c = 0; c < pvs->cluster_count(); ++c)
                    if (pvs->first_cluster_of(object) <= c && c < pvs->first_cluster_of(object + 1) &&
                        pvs->is_cluster_visible(c, cursor)) {
                        some = true;
                        ++(granularity == Granularity::triangle ? listed_triangles : listed_clusters);
                    }
                EXPECT_EQ(some, listed(objects->pvs, coarse, object)) << cell << " " << object;
                EXPECT_EQ(some, (cursor.visible[object / 64] >> (object % 64) & 1) != 0);
            }
        }
    }
    EXPECT_LT(listed_triangles, 4 * listed_clusters); // some triangles of clusters that are seen are not
    EXPECT_GT(listed_triangles, listed_clusters);
}

TEST(ExactBake, ThePublishedFormListsTheSame) {
    Scene scene = village();
    BakeOptions o = exact_options();
    o.cells = {2, 1, 1};
    Result<BakeResult> fast = bake(scene, o);
    o.exact.form = ExactForm::published;
    Result<BakeResult> published = bake(scene, o);
    ASSERT_TRUE(fast.ok() && published.ok());
    EXPECT_EQ(published->statistics.exact.undecided, 0u);
    EXPECT_EQ(fast->pvs.cell_row, published->pvs.cell_row);
    EXPECT_EQ(fast->pvs.rows, published->pvs.rows);
}

TEST(ExactBake, StopsInsideACellAndKeepsTheFinishedOnes) {
    Scene scene = village();
    BakeOptions o = exact_options();
    o.checkpoint = ::testing::TempDir() + "exact_stopped.part";
    std::filesystem::remove(o.checkpoint);
    std::atomic<bool> stop{false};
    Job job;
    job.threads = 1;
    job.cancel = &stop;
    job.progress = [&](const Progress& progress) { stop = progress.done >= 3; };
    Result<BakeResult> stopped = bake(scene, o, job);
    ASSERT_FALSE(stopped.ok());
    EXPECT_EQ(stopped.status().code(), ErrorCode::cancelled);
    o.resume = true;
    Result<BakeResult> resumed = bake(scene, o);
    ASSERT_TRUE(resumed.ok()) << resumed.status().message();
    EXPECT_EQ(resumed->statistics.cells_resumed, 3u);
    std::filesystem::remove(o.checkpoint);
}

TEST(Certificates, EveryPairOfAnExactBakeIsProvedAsListed) {
    Scene scene = village();
    Result<BakeResult> result = bake(scene, exact_options());
    ASSERT_TRUE(result.ok());
    auto bytes = encode_pvs(result->pvs);
    Result<Pvs> pvs = Pvs::open(*bytes);
    ASSERT_TRUE(pvs.ok());
    CertificateOptions many;
    many.pairs = 60;
    Result<CertificateResult> proofs = check_certificates(scene, *pvs, many);
    ASSERT_TRUE(proofs.ok()) << proofs.status().message();
    EXPECT_EQ(proofs->pairs, 60u);
    EXPECT_EQ(proofs->first_problem, "");
    EXPECT_EQ(proofs->undecided, 0u);
    EXPECT_GT(proofs->visible, 5u);
    EXPECT_GT(proofs->hidden, 15u);
    EXPECT_GT(proofs->nodes, proofs->hidden);
}

TEST(Certificates, AFlippedBitIsFoundOut) {
    Scene scene = village();
    Result<BakeResult> result = bake(scene, exact_options());
    ASSERT_TRUE(result.ok());
    for (std::uint64_t& word : result->pvs.rows)
        word = ~word & ((std::uint64_t(1) << scene.objects().size()) - 1);
    auto bytes = encode_pvs(result->pvs);
    Result<Pvs> pvs = Pvs::open(*bytes);
    ASSERT_TRUE(pvs.ok());
    CertificateOptions few;
    few.pairs = 12;
    Result<CertificateResult> proofs = check_certificates(scene, *pvs, few);
    ASSERT_TRUE(proofs.ok());
    EXPECT_EQ(proofs->rejected, 0u);
    EXPECT_EQ(proofs->listed_but_hidden + proofs->visible_but_unlisted, 12u);
    EXPECT_NE(proofs->first_problem, "");
}

TEST(ExactBake, RefusesDirectionsAndCellsFarAway) {
    Scene scene = village();
    BakeOptions o = exact_options();
    o.tree.subdivision = Subdivision::five;
    EXPECT_EQ(bake(scene, o).status().code(), ErrorCode::usage);
    o = exact_options();
    o.where = {{{1000, 0, 0}, {1001, 1, 1}}};
    EXPECT_EQ(bake(scene, o).status().code(), ErrorCode::usage);
}

} // namespace
} // namespace antumbra
