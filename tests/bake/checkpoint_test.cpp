#include "bake/checkpoint.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace antumbra {
namespace {

class CheckpointTest : public testing::Test {
  protected:
    void SetUp() override {
        path_ = testing::TempDir() + "checkpoint_" + std::to_string(::getpid()) + ".part";
        std::filesystem::remove(path_);
    }
    void TearDown() override { std::filesystem::remove(path_); }

    static std::vector<std::byte> payload(int n) { return std::vector<std::byte>(std::size_t(n), std::byte(n)); }

    void write_three() {
        Checkpoint::Records none;
        auto log = Checkpoint::open(path_, "key", false, none);
        ASSERT_TRUE(log);
        for (int n : {5, 0, 9})
            ASSERT_TRUE((*log)->append(std::uint64_t(n), payload(n)));
    }

    Checkpoint::Records resumed(const std::string& key = "key") {
        Checkpoint::Records records;
        EXPECT_TRUE(Checkpoint::open(path_, key, true, records));
        return records;
    }

    std::string path_;
};

TEST_F(CheckpointTest, ResumeFindsEveryRecord) {
    write_three();
    Checkpoint::Records records = resumed();
    EXPECT_EQ(records.size(), 3u);
    EXPECT_EQ(records[5], payload(5));
    EXPECT_EQ(records[9], payload(9));
}

TEST_F(CheckpointTest, WithoutResumeBeginsAnew) {
    write_three();
    Checkpoint::Records records;
    ASSERT_TRUE(Checkpoint::open(path_, "key", false, records));
    EXPECT_TRUE(records.empty());
    EXPECT_TRUE(resumed().empty());
}

// A kill can cut the log anywhere: every prefix gives a prefix of the records, and appending goes on behind it.
TEST_F(CheckpointTest, EveryTruncationKeepsTheWholeRecords) {
    write_three();
    auto size = std::filesystem::file_size(path_);
    std::size_t last = 0;
    for (std::uintmax_t cut = 0; cut <= size; ++cut) {
        write_three();
        std::filesystem::resize_file(path_, cut);
        std::size_t found = resumed().size();
        EXPECT_GE(found, last);
        last = found;
        Checkpoint::Records records;
        auto log = Checkpoint::open(path_, "key", true, records);
        ASSERT_TRUE(log);
        ASSERT_TRUE((*log)->append(77, payload(3)));
        EXPECT_EQ(resumed().size(), found + 1) << "cut at " << cut;
    }
    EXPECT_EQ(last, 3u);
}

TEST_F(CheckpointTest, EveryFlippedBitOfARecordDropsItAndWhatFollows) {
    write_three();
    std::ifstream in(path_, std::ios::binary);
    std::string good((std::istreambuf_iterator<char>(in)), {});
    std::size_t first_record = 8 + 8 + 3;
    for (std::size_t bit = first_record * 8; bit < good.size() * 8; ++bit) {
        std::string bad = good;
        bad[bit / 8] = char(bad[bit / 8] ^ (1 << bit % 8));
        std::ofstream(path_, std::ios::binary) << bad;
        EXPECT_LT(resumed().size(), 3u) << "bit " << bit;
    }
}

TEST_F(CheckpointTest, AnotherKeyIsRefused) {
    write_three();
    Checkpoint::Records records;
    auto log = Checkpoint::open(path_, "kex", true, records);
    ASSERT_FALSE(log);
    EXPECT_EQ(log.status().code(), ErrorCode::mismatch);
    EXPECT_NE(log.status().message().find(path_), std::string::npos);
}

} // namespace
} // namespace antumbra
