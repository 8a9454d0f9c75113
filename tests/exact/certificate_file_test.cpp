#include "bake/exact/certificate_file.hpp"

#include "base/crc32c.hpp"
#include "base/random.hpp"
#include "support/make_scene.hpp"

#include <antumbra/bake.hpp>

namespace antumbra {
namespace {

struct Proved {
    Scene scene = make();
    std::vector<std::byte> pvs_bytes, proof;
    std::optional<Pvs> pvs;
    CertificateFileResult made;

    static Scene make() {
        test::SceneMaker maker;
        for (int k = 0; k < 4; ++k) {
            double x = 5.0 * k;
            std::uint32_t flags = kOccludes | (k % 2 ? std::uint32_t(kDoubleSided) : 0u);
            maker.object("house", flags).box({x, 0, k % 2 * 3.0}, {x + 4, 2.5, k % 2 * 3.0 + 2});
            maker.object("thing").box({x + 1, 0.5, k % 2 * 3.0 + 0.5}, {x + 1.5, 1, k % 2 * 3.0 + 1});
            maker.object("bin").box({x + 4.2, 0, 1}, {x + 4.6, 0.7, 1.5});
        }
        return maker.scene();
    }
    explicit Proved(const char* method = "exact", BakeOptions options = {}) {
        options.method = method;
        options.cells = {3, 1, 2};
        options.rays_per_cell = 300;
        options.holdout_rays = 0;
        options.sequential.most_rays = 16;
        Result<BakeResult> baked = bake(scene, options);
        EXPECT_TRUE(baked) << baked.status().message();
        pvs_bytes = *encode_pvs(baked->pvs);
        pvs.emplace(*Pvs::open(pvs_bytes));
        Result<std::vector<std::byte>> bytes = make_certificates(scene, *pvs, pvs_bytes, made);
        EXPECT_TRUE(bytes) << bytes.status().message();
        proof = std::move(*bytes);
    }
    Result<CertificateFileResult> check(std::span<const std::byte> bytes) const {
        return check_certificate_file(scene, *pvs, pvs_bytes, bytes);
    }
};

TEST(CertificateFile, HoldsAProofForEveryPairThatTheVerifierAccepts) {
    Proved proved;
    Result<CertificateFileResult> checked = proved.check(proved.proof);
    ASSERT_TRUE(checked) << checked.status().message();
    EXPECT_EQ(checked->first_problem, "");
    EXPECT_EQ(checked->rejected + checked->disagree + checked->undecided, 0u);
    EXPECT_EQ(checked->pairs, checked->cells * 12);
    EXPECT_EQ(checked->pairs, checked->visible + checked->hidden + checked->by_definition);
    EXPECT_EQ(checked->hidden, proved.made.hidden);
    EXPECT_EQ(checked->trees, proved.made.trees);
    EXPECT_EQ(checked->nodes, proved.made.nodes);
    EXPECT_GT(checked->visible, 10u);
    EXPECT_GT(checked->hidden, 15u);
    EXPECT_GT(checked->by_definition, 3u);
}

/// Files that list clusters or triangles, and files whose cells are boxes or the leaves of an adaptive tree.
TEST(CertificateFile, SpeaksOfClustersTrianglesAndCellsOfEveryKind) {
    for (int kind = 0; kind < 4; ++kind) {
        BakeOptions options;
        if (kind == 0 || kind == 3) {
            options.exact.granularity = Granularity::cluster;
            options.exact.cluster_triangles = 5;
        }
        if (kind == 1)
            options.exact.granularity = Granularity::triangle;
        if (kind == 2) {
            options.tree.subdivision = Subdivision::boxes;
            options.where = {{{-2, 0.5, -2}, {-1, 1.5, 2}}, {{4.1, 0.5, -3}, {6, 1.5, -1}}};
        }
        if (kind == 3) {
            options.tree.subdivision = Subdivision::spatial;
            options.tree.min_extent = 0.25;
        }
        Proved proved("exact", options);
        Result<CertificateFileResult> checked = proved.check(proved.proof);
        ASSERT_TRUE(checked) << kind << ": " << checked.status().message();
        EXPECT_EQ(checked->first_problem, "") << kind;
        EXPECT_EQ(checked->rejected + checked->disagree + checked->undecided, 0u) << kind;
        std::uint64_t units = proved.pvs->cluster_count() ? proved.pvs->cluster_count() : 12;
        EXPECT_EQ(checked->pairs, checked->cells * units) << kind;
        EXPECT_GT(checked->hidden, 5u);
        EXPECT_GT(checked->visible, 5u);
        CertificateOptions some;
        some.pairs = 8;
        Result<CertificateResult> again = check_certificates(proved.scene, *proved.pvs, some);
        ASSERT_TRUE(again) << kind << ": " << again.status().message();
        EXPECT_EQ(again->pairs, 8u);
        EXPECT_EQ(again->rejected + again->listed_but_hidden + again->visible_but_unlisted, 0u) << again->first_problem;
    }
}

TEST(CertificateFile, DoesNotDependOnThreads) {
    Proved proved;
    Job one;
    one.threads = 1;
    CertificateFileResult counted;
    EXPECT_EQ(*make_certificates(proved.scene, *proved.pvs, proved.pvs_bytes, counted, one), proved.proof);
}

TEST(CertificateFile, WhatASamplerMissedDisagrees) {
    Proved proved("sampled");
    Result<CertificateFileResult> checked = proved.check(proved.proof);
    ASSERT_TRUE(checked) << checked.status().message();
    EXPECT_EQ(checked->rejected, 0u);
    EXPECT_GT(checked->disagree, 0u);
    EXPECT_NE(checked->first_problem.find("not listed"), std::string::npos) << checked->first_problem;
}

TEST(CertificateFile, BelongsToItsPvsAndNoOther) {
    Proved proved;
    std::vector<std::byte> other = proved.pvs_bytes;
    other.push_back(std::byte(0));
    EXPECT_EQ(check_certificate_file(proved.scene, *proved.pvs, other, proved.proof).status().code(), ErrorCode::mismatch);
}

/// Block headers and CRCs made right again after a forgery, so that only the content is wrong.
void reseal(std::vector<std::byte>& file) {
    auto put = [&](std::size_t at, std::uint32_t value) {
        for (int k = 0; k < 4; ++k)
            file[at + std::size_t(k)] = std::byte(value >> (8 * k));
    };
    for (std::size_t at = 56; at < file.size();) {
        std::size_t size = 0;
        for (int k = 0; k < 8; ++k)
            size |= std::to_integer<std::size_t>(file[at + 8 + std::size_t(k)]) << (8 * k);
        put(at + 16, crc32c(std::span<const std::byte>(file).subspan(at + 24, size)));
        put(at + 20, crc32c(std::span<const std::byte>(file).subspan(at, 20)));
        at += 24 + size;
    }
}

TEST(CertificateFile, EveryFlippedBitIsNoticedAndForgeriesAreNeverACrashNorAccepted) {
    Proved proved;
    Random random(5);
    int refused = 0, rejected = 0, harmless = 0;
    for (int k = 0; k < 300; ++k) {
        std::vector<std::byte> file = proved.proof;
        std::size_t at = 56 + 24 + random.below(std::uint32_t(file.size() - 80));
        file[at] ^= std::byte(1 << random.below(8));
        EXPECT_EQ(proved.check(file).status().code(), ErrorCode::corrupt); // the CRC
        if (k % 12)
            continue;
        reseal(file);
        Result<CertificateFileResult> checked = proved.check(file);
        if (!checked) {
            ++refused;
            EXPECT_EQ(checked.status().code(), ErrorCode::corrupt);
        } else if (checked->rejected + checked->disagree > 0) {
            ++rejected;
        } else {
            ++harmless; // another point of the same witness, another name for an empty leaf
        }
    }
    EXPECT_GT(refused, 0);
    EXPECT_GT(rejected, 5);
    EXPECT_LT(harmless, 13);
    for (std::size_t size = 0; size < proved.proof.size(); size += 1 + proved.proof.size() / 50)
        EXPECT_EQ(proved.check(std::span(proved.proof).first(size)).status().code(), ErrorCode::corrupt);
}

} // namespace
} // namespace antumbra
