// Damaged rows of a history: each loss is reported, no value is wrong.
#include <gtest/gtest.h>

#include <SQLiteCpp/SQLiteCpp.h>
#include <algorithm>
#include <vector>
#include "directory.hpp"

#include "takt/store/history.hpp"
#include "takt/store/history_reader.hpp"

namespace takt::store {
namespace history_damage_test {

using Samples = std::vector<HistorySample>;

constexpr std::int64_t kSecond = 1'000'000'000;
constexpr std::int64_t kHour = 3600 * kSecond;
constexpr std::int64_t kStart = 500'000 * kHour;
const HistoryRange kAll{kStart - 1000 * kHour, kStart + 1000 * kHour};
const HistorySeries kLevel{"tank.level", "tank", DataType::int16, true, "m"};
const HistorySeries kPump{"pump.running", "pump", DataType::boolean, false, ""};

struct Read {
    Samples samples;
    std::vector<HistoryDamage> damage;
};

class HistoryDamageTest : public InDirectory {
protected:
    const std::string path_ = directory_ / "plant.history.db";

    /// 100 samples in ten commits; two series.
    void make(const HistoryOptions& options) {
        const auto history = std::move(History::open(path_, options)->history);
        const auto level = history->series(kLevel).value();
        const auto pump = history->series(kPump).value();
        for (std::int64_t i = 0; i < 100; ++i) {
            history->append(level, {.time_ns = kStart + i * kSecond, .value = static_cast<double>(i)});
            history->append(pump, {.time_ns = kStart + i * kSecond, .value = i % 2 == 0});
            if (i % 10 == 9) ASSERT_TRUE(history->commit(kStart + i * kSecond));
        }
    }
    void change(const std::string& statements) {
        SQLite::Database(path_, SQLite::OPEN_READWRITE).exec(statements);
    }
    [[nodiscard]] Read read() const {
        Read read;
        auto reader = HistoryReader::open(path_).value();
        EXPECT_TRUE(reader.read(SeriesId{1}, kAll, [&](const HistorySample& sample) {
            read.samples.push_back(sample);
            return true;
        }));
        read.damage = reader.damage();
        return read;
    }
};

TEST_F(HistoryDamageTest, OfTheLogIsReportedWithTheTimesOfItsNeighbours) {
    make({});
    change("UPDATE log SET data = zeroblob(length(data)) WHERE id IN (4, 5)");
    const auto [samples, damage] = read();
    EXPECT_EQ(samples.size(), 80U);
    ASSERT_EQ(damage.size(), 2U);
    EXPECT_EQ(damage[0].part, HistoryPart::log);
    EXPECT_EQ(damage[0].row, 4);
    EXPECT_EQ(damage[0].first_ns, kStart + 29 * kSecond);
    EXPECT_EQ(damage[0].last_ns, kStart + 50 * kSecond);
    auto reader = HistoryReader::open(path_).value();
    EXPECT_EQ(reader.picture(SeriesId{1}, kAll, 10)->damaged_chunks, 2U);
}

TEST_F(HistoryDamageTest, OfTheLogBecomesAGapWhenItIsOpenedForWriting) {
    make({});
    change("UPDATE log SET data = zeroblob(length(data)) WHERE id IN (4, 5)");
    for (int start = 0; start < 2; ++start) {
        const auto opened = History::open(path_).value();
        EXPECT_EQ(opened.damage.size(), start == 0 ? 2U : 0U);
        auto reader = HistoryReader::open(path_).value();
        const HistoryGap gap{kStart + 29 * kSecond, kStart + 50 * kSecond, GapCause::damaged, 0};
        EXPECT_EQ(reader.gaps(kAll).value(), std::vector{gap});
        const auto [samples, damage] = read();
        EXPECT_EQ(samples.size(), 80U);
        ASSERT_EQ(damage.size(), 1U);
        EXPECT_EQ(damage[0].part, HistoryPart::recorded);
    }
}

TEST_F(HistoryDamageTest, OfAnOpenChunkBecomesAGapWhenItIsOpenedForWriting) {
    make({.log_commits = 1});
    change("UPDATE chunk SET data = zeroblob(10) WHERE id = (SELECT chunk FROM rollup WHERE series = 1)");
    const auto before = read();
    EXPECT_TRUE(before.samples.empty());
    ASSERT_EQ(before.damage.size(), 1U);
    EXPECT_EQ(before.damage[0].part, HistoryPart::chunk);
    EXPECT_EQ(before.damage[0].variable, kLevel.name);
    EXPECT_EQ(before.damage[0].samples, 100U);
    EXPECT_EQ(History::open(path_)->damage.size(), 1U);
    auto reader = HistoryReader::open(path_).value();
    const HistoryGap gap{kStart, kStart + 99 * kSecond, GapCause::damaged, 100};
    EXPECT_EQ(reader.gaps(kAll).value(), std::vector{gap});
    EXPECT_TRUE(History::open(path_)->damage.empty());
}

}  // namespace history_damage_test
}  // namespace takt::store
