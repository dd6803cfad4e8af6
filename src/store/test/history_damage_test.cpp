// Damaged rows of a history: each loss is reported, no value is wrong.
#include <gtest/gtest.h>

#include <SQLiteCpp/SQLiteCpp.h>
#include <chrono>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "history_rig.hpp"

namespace takt::store {
namespace history_damage_test {

using namespace history_rig;

const HistorySeries kPump{"pump.running", "pump", DataType::boolean, false, ""};

class HistoryDamageTest : public HistoryInDirectory {
protected:
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
    /// The first byte of the first page of a table or an index.
    [[nodiscard]] std::size_t page_of(const std::string& name) const {
        SQLite::Database database(path_);
        SQLite::Statement select(database, "SELECT rootpage FROM sqlite_master WHERE name = ?");
        select.bind(1, name);
        select.executeStep();
        return (select.getColumn(0).getUInt() - std::size_t{1}) * kPage;
    }
    /// Changes bytes of the closed file.
    void change_bytes(const std::function<void(std::string&)>& change) const {
        for (const char* suffix : {"-wal", "-shm"}) std::filesystem::remove(path_ + suffix);
        auto bytes = bytes_of(path_);
        change(bytes);
        overwrite(path_, bytes);
    }
    [[nodiscard]] static HistoryDamage lost(std::int64_t row, const std::string& variable) {
        return {.part = HistoryPart::series,
                .row = row,
                .variable = variable,
                .first_ns = kStart,
                .last_ns = kStart + 99 * kSecond,
                .samples = 100};
    }
    static constexpr std::size_t kPage = 4096;
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

TEST_F(HistoryDamageTest, OfARollUpIsUndoneFromItsChunk) {
    make({.chunk_samples = 10, .log_commits = 1});
    change("UPDATE rollup SET samples = 11, min = -5, t1 = t1 + 1 WHERE chunk = 3");
    const auto reader_only = read();
    EXPECT_EQ(reader_only.samples.size(), 100U);
    EXPECT_TRUE(reader_only.damage.empty());
    EXPECT_TRUE(History::open(path_)->damage.empty());
    SQLite::Database database(path_);
    EXPECT_EQ(database.execAndGet("SELECT samples FROM rollup WHERE chunk = 3").getInt(), 10);
}

TEST_F(HistoryDamageTest, OfTheKeyOfARollUpIsUndoneFromItsChunk) {
    make({.chunk_samples = 10, .log_commits = 1});
    change("UPDATE rollup SET series = 2 WHERE series = 1 AND chunk < 10");
    EXPECT_EQ(read().samples.size(), 100U);
    change("UPDATE rollup SET t0 = 7 WHERE chunk = 11");
    EXPECT_EQ(read().samples.size(), 100U);
    change("DELETE FROM rollup WHERE series = 1 AND chunk > 10");
    EXPECT_EQ(read().samples.size(), 100U);
}

TEST_F(HistoryDamageTest, ChunksAreNotTakenForThoseOfAnotherVariable) {
    make({.chunk_samples = 10, .log_commits = 1});
    change("UPDATE chunk SET data = (SELECT data FROM chunk WHERE id = 2) WHERE id = 1");
    const auto [samples, damage] = read();
    EXPECT_EQ(samples.size(), 90U);
    ASSERT_EQ(damage.size(), 1U);
    EXPECT_EQ(damage[0].part, HistoryPart::chunk);
}

TEST_F(HistoryDamageTest, OfEachTableIsReported) {
    const struct {
        const char* change;
        HistoryPart part;
    } kCases[] = {
        {"UPDATE state SET known_until = known_until + 1", HistoryPart::state},
        {"DELETE FROM state", HistoryPart::state},
        {"UPDATE gap SET last = last + 1", HistoryPart::gap},
        {"DELETE FROM gap", HistoryPart::gap},
        {"UPDATE series SET unit = 'cm' WHERE id = 1", HistoryPart::series},
        {"DELETE FROM series WHERE id = 2", HistoryPart::series},
        {"DELETE FROM log WHERE id = 3", HistoryPart::log},
        {"DELETE FROM log WHERE id = 9", HistoryPart::log},
        {"UPDATE log SET data = (SELECT data FROM log WHERE id = 1) WHERE id = 2", HistoryPart::log},
    };
    for (const auto& [statements, part] : kCases) {
        std::filesystem::remove(path_);
        make({});
        {
            const auto history = std::move(History::open(path_)->history);
            history->append(HistoryGap{kStart, kStart + kSecond, GapCause::quota, 3});
            ASSERT_TRUE(history->commit(kStart + 100 * kSecond));
        }
        {
            const auto history = std::move(History::open(path_, {.log_commits = 100})->history);
            const auto level = history->series(kLevel).value();
            for (std::int64_t i = 200; i < 210; ++i) {
                history->append(level, {.time_ns = kStart + i * kSecond, .value = 1.0});
                ASSERT_TRUE(history->commit(kStart + i * kSecond));
            }
        }
        ASSERT_TRUE(read().damage.empty());
        change(statements);
        const auto damage = read().damage;
        ASSERT_EQ(damage.size(), 1U) << statements;
        EXPECT_EQ(damage[0].part, part) << statements;
        EXPECT_EQ(History::open(path_)->damage.size(), 1U) << statements;
    }
}

TEST_F(HistoryDamageTest, OfAVariableIsReportedWithItsNameAndSamples) {
    make({.log_commits = 3});
    change("UPDATE series SET unit = 'cm' WHERE id = 1");
    EXPECT_EQ(read(kPump).samples.size(), 100U);
    EXPECT_EQ(read(kPump).damage, std::vector{lost(1, kLevel.name)});
    auto reader = HistoryReader::open(path_).value();
    EXPECT_EQ(reader.series()->size(), 1U);
    EXPECT_TRUE(reader.is_lost(kLevel.name));
    EXPECT_FALSE(reader.is_lost("another"));
    EXPECT_EQ(reader.damage().size(), 1U);
}

TEST_F(HistoryDamageTest, OfTheNameOfAVariableIsUndone) {
    make({});
    const auto page = page_of("series");
    auto other = kLevel;
    other.name.back() ^= 1;
    ASSERT_TRUE(History::open(path_)->history->series(other));
    change_bytes(
        [&](std::string& bytes) { bytes[bytes.find(kLevel.name, page) + kLevel.name.size() - 1] ^= 1; });
    for (int i = 0; i < 2; ++i) {
        EXPECT_EQ(read().samples.size(), 100U);
        EXPECT_TRUE(read(other).samples.empty());
        EXPECT_TRUE(read().damage.empty());
        const auto opened = History::open(path_).value();
        EXPECT_EQ(opened.set_aside, "");
        EXPECT_TRUE(opened.damage.empty());
        EXPECT_EQ(opened.history->series(kLevel).value(), SeriesId{1});
    }
    SQLite::Database database(path_);
    EXPECT_EQ(database.execAndGet("SELECT name FROM series WHERE id = 1").getString(), kLevel.name);
}

TEST_F(HistoryDamageTest, OfAllVariablesIsReportedWithTheirNames) {
    for (const std::size_t length : {512U, 4096U}) {
        std::filesystem::remove(path_);
        make({});
        const auto end = page_of("series") + kPage;
        change_bytes([&](std::string& bytes) { bytes.replace(end - length, length, length, '\0'); });
        EXPECT_EQ(read().damage, (std::vector{lost(1, kLevel.name), lost(2, kPump.name)})) << length;
        const auto opened = History::open(path_);
        ASSERT_TRUE(opened);
        EXPECT_FALSE(opened->damage.empty() && opened->set_aside.empty()) << length;
    }
}

TEST_F(HistoryDamageTest, OfThePageOfATableIsReported) {
    const struct {
        const char* table;
        HistoryPart part;
        std::size_t samples;
    } kCases[] = {
        {"rollup", HistoryPart::rollup, 90},  // what the chunks have
        {"chunk", HistoryPart::chunk, 0},
        {"gap", HistoryPart::gap, 100},
        {"log", HistoryPart::log, 100},
    };
    for (const auto& [table, part, samples] : kCases) {
        std::filesystem::remove(path_);
        make({.chunk_samples = 10, .log_commits = 9});
        {
            const auto history = std::move(History::open(path_, {.log_commits = 2})->history);
            history->append(HistoryGap{kStart, kStart + kSecond, GapCause::quota, 3});
            const auto level = history->series(kLevel).value();
            for (std::int64_t i = 100; i < 102; ++i) {  // the first commit folds
                history->append(level, {.time_ns = kStart + i * kSecond, .value = 1.0});
                ASSERT_TRUE(history->commit(kStart + i * kSecond));
            }
        }
        const auto page = page_of(table);
        change_bytes([&](std::string& bytes) { bytes.replace(page, kPage, kPage, '\0'); });
        const auto whole = read();
        EXPECT_GE(whole.samples.size(), samples) << table;
        ASSERT_FALSE(whole.damage.empty()) << table;
        EXPECT_EQ(whole.damage[0].part, part) << table;
        const auto opened = History::open(path_);
        ASSERT_TRUE(opened) << table;
        EXPECT_FALSE(opened->damage.empty() && opened->set_aside.empty()) << table;
    }
}

TEST_F(HistoryDamageTest, OfVariablesWithoutNamesConcernsEachVariableThatIsMissing) {
    make({});
    const auto table = page_of("series");
    const auto index = page_of("sqlite_autoindex_series_1");
    change_bytes([&](std::string& bytes) {
        for (const auto page : {table, index}) bytes.replace(page, kPage, kPage, '\0');
    });
    auto reader = HistoryReader::open(path_).value();
    EXPECT_TRUE(reader.series()->empty());
    EXPECT_TRUE(reader.is_lost(kLevel.name));
    ASSERT_EQ(reader.damage().size(), 2U);
    EXPECT_EQ(reader.damage()[0].variable, "");
    EXPECT_EQ(reader.damage()[1].variable, kLevel.name);
}

TEST_F(HistoryDamageTest, OfAnIndexIsUndone) {
    const HistoryOptions options{.retention = std::chrono::hours(1), .chunk_samples = 10, .log_commits = 1};
    for (const char* index : {"rollup_by_end", "rollup_open", "gap_by_end"}) {
        for (const std::size_t at : {std::size_t{0}, std::size_t{12}, kPage - 1}) {
            std::filesystem::remove(path_);
            make(options);
            std::move(History::open(path_)->history)
                ->append(HistoryGap{.first_ns = kStart, .last_ns = kStart});
            const auto page = page_of(index);
            change_bytes([&](std::string& bytes) { bytes[page + at] ^= 1; });
            EXPECT_EQ(read().samples.size(), 100U) << index;
            EXPECT_TRUE(read().damage.empty()) << index;
            auto opened = History::open(path_, options).value();
            EXPECT_EQ(opened.set_aside, "") << index << ' ' << at;
            EXPECT_TRUE(opened.damage.empty()) << index;
            const auto level = opened.history->series(kLevel).value();
            opened.history->append(level, {.time_ns = kStart + 100 * kSecond, .value = 1.0});
            EXPECT_TRUE(opened.history->commit(kStart + 100 * kSecond)) << index << ' ' << at;
            EXPECT_EQ(read().samples.size(), 101U);
            EXPECT_TRUE(opened.history->commit(kStart + 3 * kHour)) << index << ' ' << at;
            EXPECT_GT(opened.history->status().dropped, 0U) << "all but the last hour";
        }
    }
}

// A commit meets damage that opening does not: the list of free pages names a page that does not exist.
TEST_F(HistoryDamageTest, OfTheFileBecomesAGapOfTheNewOne) {
    make({.chunk_samples = 10, .log_commits = 1});
    change_bytes(
        [](std::string& bytes) { bytes.replace(32, 8, std::string("\xFF\xFF\xFF\xFF\0\0\0\1", 8)); });
    const auto history = std::move(History::open(path_, {.retention = {}, .log_commits = 1})->history);
    const auto text = history->series({"text", "", DataType::string, false, ""}).value();
    history->append(text, {.time_ns = kStart + 100 * kSecond, .value = std::string(50'000, 'x')});
    EXPECT_EQ(history->commit(kStart + 200 * kSecond).error().code, Code::malformed);
    EXPECT_EQ(history->status().set_aside, path_ + ".damaged-1");
    auto reader = HistoryReader::open(path_).value();
    const HistoryGap gap{kStart, kStart + 99 * kSecond, GapCause::damaged, 0};
    EXPECT_EQ(reader.gaps(kAll).value(), std::vector{gap});
    ASSERT_EQ(reader.damage().size(), 1U);
    EXPECT_EQ(reader.damage()[0].part, HistoryPart::recorded);
}

// As a program leaves it that was killed while it began the file.
TEST_F(HistoryDamageTest, OfAFileWithoutTablesIsNoGap) {
    std::ofstream(path_).close();
    EXPECT_EQ(History::open(path_, {})->set_aside, path_ + ".damaged-1");
    EXPECT_TRUE(HistoryReader::open(path_)->gaps({0, INT64_MAX}).value().empty());
}

// The times of the samples are unknown: those of the retention may be lost.
TEST_F(HistoryDamageTest, OfAFileWithoutAReadablePageBecomesAGapOfTheRetention) {
    make({});
    change_bytes([](std::string& bytes) { bytes.assign(bytes.size(), '\0'); });
    EXPECT_EQ(History::open(path_, {.retention = std::chrono::hours(1)})->set_aside, path_ + ".damaged-1");
    const auto gaps = HistoryReader::open(path_)->gaps({0, INT64_MAX}).value();
    ASSERT_EQ(gaps.size(), 1U);
    EXPECT_EQ(gaps[0].cause, GapCause::damaged);
    EXPECT_EQ(gaps[0].last_ns - gaps[0].first_ns, kHour);
}

TEST_F(HistoryDamageTest, AFileOfVersion1IsReadAndUpgraded) {
    make({.chunk_samples = 30, .log_commits = 3});
    for (const auto& [table, columns] : std::map<std::string, std::vector<std::string>>{
             {"series", {"chunks", "chunk_sum", "sum"}},
             {"chunk", {"series", "sum"}},
             {"rollup", {"sum"}},
             {"gap", {"sum"}},
             {"state", {"log_rows", "log_sum", "gaps", "gap_sum", "all_series", "series_sum", "sum"}}})
        for (const auto& column : columns) change("ALTER TABLE " + table + " DROP COLUMN " + column);
    change("PRAGMA user_version = 1");
    for (int i = 0; i < 3; ++i) {
        const auto [samples, damage] = read();
        EXPECT_EQ(samples.size(), 100U);
        EXPECT_TRUE(damage.empty());
        EXPECT_TRUE(History::open(path_)->damage.empty());
    }
    change("UPDATE rollup SET samples = 11 WHERE chunk = 1");
    EXPECT_EQ(read().samples.size(), 100U);
    change("DELETE FROM rollup WHERE chunk = 1");
    ASSERT_EQ(read().damage.size(), 1U);
    EXPECT_EQ(read().damage[0].part, HistoryPart::rollup);
    EXPECT_EQ(read().damage[0].variable, kLevel.name);
}

}  // namespace history_damage_test
}  // namespace takt::store
