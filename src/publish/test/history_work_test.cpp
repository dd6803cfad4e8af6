#include "outputs/history_work.hpp"

#include <gtest/gtest.h>

#include <array>
#include <chrono>

#include "folder.hpp"
#include "simulated_disk.hpp"
#include "takt/publish/sample_codec.hpp"
#include "takt/store/history_reader.hpp"

namespace takt::publish {
namespace history_work_test {

using namespace std::chrono_literals;

constexpr std::array<std::string_view, 1> kNames{"local"};
constexpr store::DestinationId kLocal{0};
constexpr store::HistoryOptions kForEver{.retention = Duration{}};
constexpr std::int64_t kMs = 1'000'000;
const Series kSeries{"Power", "Meter", "rs485-1", "kW", DataType::int16, false};

class HistoryWorkTest : public ::testing::Test {
protected:
    void SetUp() override {
        auto opened = store::Journal::open(disk_, {}, kNames, now_, 0);
        ASSERT_TRUE(opened);
        journal_.emplace(*std::move(opened));
        start();
    }
    void start() {
        work_.emplace(folder_ / "plant.history.db", folder_.path(), kForEver);
        work_->begin(now_, *journal_, kLocal);
    }
    void append(std::int64_t first, std::size_t count) {
        SamplePayload payload(4096);
        for (std::size_t i = 0; i < count; ++i) {
            const auto number = first + static_cast<std::int64_t>(i);
            ASSERT_TRUE(payload.add(kSeries, {.series = 0, .value = number, .wall_ns = number * 100 * kMs}));
        }
        ASSERT_TRUE(journal_->append(now_, {count, 0, 0, payload.take()}));
        now_ += 200ms;
        journal_->on_tick(now_, 0);
    }
    void work() {
        now_ += 6s;
        work_->work(now_);
    }
    [[nodiscard]] std::vector<std::int64_t> kept() const {
        std::vector<std::int64_t> values;
        auto reader = store::HistoryReader::open(folder_ / "plant.history.db");
        EXPECT_TRUE(reader);
        const auto series = reader->series();
        EXPECT_TRUE(series);
        EXPECT_EQ(series->size(), 1U);
        EXPECT_TRUE(reader->read(series->at(0).id, {0, INT64_MAX}, [&](const store::HistorySample& sample) {
            values.push_back(std::get<std::int64_t>(sample.value));
            return true;
        }));
        return values;
    }
    [[nodiscard]] OutputStatus status() const {
        OutputStatus status;
        work_->report(now_, status);
        return status;
    }

    takt::test::Folder folder_;
    store::test::SimulatedDisk disk_;
    Instant now_{};
    std::optional<store::Journal> journal_;
    std::optional<HistoryWork> work_;
};

TEST_F(HistoryWorkTest, RecordsAreCommittedBeforeTheyAreAcknowledged) {
    append(0, 3);
    work();
    EXPECT_EQ(journal_->counters(kLocal).delivered, 3U);
    EXPECT_EQ(status().state, OutputState::delivering);
    append(3, 2);
    work_->stop(now_);
    EXPECT_EQ(journal_->counters(kLocal).delivered, 5U);
    EXPECT_EQ(kept(), (std::vector<std::int64_t>{0, 1, 2, 3, 4}));
}

// A crash between commit and acknowledgement: the journal gives the records again.
TEST_F(HistoryWorkTest, WhatIsCommittedAlreadyIsNotDoubled) {
    append(0, 3);
    work();
    work_->stop(now_);
    journal_.reset();
    // Without the cursor, which is synchronised a second later.
    disk_ = disk_.after_crash({.piece = [](auto...) { return std::size_t{0}; }});
    auto opened = store::Journal::open(disk_, {}, kNames, now_, 0);
    ASSERT_TRUE(opened);
    journal_.emplace(*std::move(opened));
    start();
    append(3, 1);
    work_->stop(now_);
    EXPECT_EQ(kept(), (std::vector<std::int64_t>{0, 1, 2, 3}));
    EXPECT_EQ(journal_->counters(kLocal).waiting, 0U);
}

TEST_F(HistoryWorkTest, ADatabaseThatCannotBeOpenedIsTriedAgain) {
    work_->stop(now_);
    work_.emplace(folder_ / "missing/plant.history.db", folder_.path(), kForEver);
    work_->begin(now_, *journal_, kLocal);
    append(0, 3);
    work();
    EXPECT_EQ(status().state, OutputState::waiting);
    EXPECT_NE(status().failure, "");
    EXPECT_EQ(journal_->counters(kLocal).waiting, 3U);
    folder_.write("missing/other", "");
    work();
    EXPECT_EQ(status().state, OutputState::delivering);
    EXPECT_EQ(journal_->counters(kLocal).waiting, 0U);
}

}  // namespace history_work_test
}  // namespace takt::publish
