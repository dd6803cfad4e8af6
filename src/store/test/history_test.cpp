#include "takt/store/history.hpp"

#include <sys/resource.h>

#include <cerrno>
#include <csignal>

#include <SQLiteCpp/SQLiteCpp.h>

#include "history_rig.hpp"

namespace takt::store {
namespace history_test {

using namespace history_rig;
using Samples = std::vector<HistorySample>;

HistorySample at(std::int64_t seconds, value::Value value) {
    return {.time_ns = kStart + seconds * kSecond,
            .previous_ns = kStart + (seconds - 1) * kSecond,
            .value = std::move(value)};
}

class HistoryTest : public HistoryInDirectory {
protected:
    std::unique_ptr<History> open(const HistoryOptions& options = {}) {
        auto opened = History::open(path_, options);
        EXPECT_TRUE(opened) << name(opened.error().code);
        return opened ? std::move(opened->history) : nullptr;
    }
    void expect_stored(const Samples& expected) {
        const auto stored = read().samples;
        ASSERT_EQ(stored.size(), expected.size());
        for (std::size_t i = 0; i < stored.size(); ++i) EXPECT_TRUE(same(stored[i], expected[i])) << i;
    }
};

TEST_F(HistoryTest, IsReadWhileItIsWritten) {
    const auto history = open();
    const auto id = history->series(kLevel).value();
    Samples expected;
    for (int i = 0; i < 2500; ++i) {
        expected.push_back(at(i, i / 10.0));
        history->append(id, expected.back());
        if (i % 100 == 99) {
            ASSERT_TRUE(history->commit(kStart + i * kSecond));
        }
    }
    expect_stored(expected);
    EXPECT_EQ(history->status().samples, 2500U);
}

TEST_F(HistoryTest, KeepsWhatWasCommittedAndNothingElse) {
    Samples expected;
    for (int run = 0; run < 5; ++run) {
        const auto history = open({.chunk_samples = 7, .log_commits = 3});
        const auto id = history->series(kLevel).value();
        for (int i = 0; i < 20; ++i) {
            expected.push_back(at(run * 4000 + i, std::int64_t{i}));
            history->append(id, expected.back());
            ASSERT_TRUE(history->commit(kStart + run * kHour));
        }
        history->append(id, at(run * 4000 + 99, std::int64_t{99}));  // not committed
    }
    expect_stored(expected);
}

TEST_F(HistoryTest, SkipsRecordsThatAreRepeatedAfterARestart) {
    const auto append_records = [](History& history, std::uint64_t first, std::uint64_t last) {
        const auto id = history.series(kLevel).value();
        for (std::uint64_t i = first; i <= last; ++i) {
            history.begin_record({17, i});
            history.append(id, at(static_cast<std::int64_t>(i), i));
            history.append(HistoryGap{kStart, kStart + 1, GapCause::quota, i});
        }
    };
    {
        const auto history = open();
        append_records(*history, 1, 10);
        ASSERT_TRUE(history->commit(kStart));
        append_records(*history, 11, 12);
    }
    const auto history = open();
    EXPECT_EQ(history->position(), (HistoryPosition{17, 10}));
    append_records(*history, 6, 14);
    ASSERT_TRUE(history->commit(kStart));
    EXPECT_EQ(read().samples.size(), 14U);
    EXPECT_EQ(history->status().repeated, 5U);
    EXPECT_EQ(HistoryReader::open(path_)->gaps(kAll)->size(), 14U);
    history->begin_record({18, 1});  // another journal
    history->append(history->series(kLevel).value(), at(100, 1.0));
    ASSERT_TRUE(history->commit(kStart));
    EXPECT_EQ(read().samples.size(), 15U);
}

TEST_F(HistoryTest, OrdersSamplesByTimeWhenTheClockWasSetBack) {
    const auto history = open({.log_commits = 1});
    const auto id = history->series(kLevel).value();
    for (const int second : {7000, 7001, 7002, 5000, 5001, 7001, 1, 20'000}) {
        history->append(id, at(second, std::int64_t{second}));
        ASSERT_TRUE(history->commit(kStart));
    }
    std::vector<std::int64_t> values;
    const auto stored = read().samples;
    for (const auto& sample : stored) values.push_back(std::get<std::int64_t>(sample.value));
    EXPECT_EQ(values, (std::vector<std::int64_t>{1, 5000, 5001, 7000, 7001, 7001, 7002, 20'000}));
}

TEST_F(HistoryTest, KeepsSamplesOfOneInstantInOrderOfArrival) {
    // The clock is set back: the second chunk ends at the instant at which the first one begins.
    const Samples arrived{at(10, 1.0), at(20, 2.0), at(0, 3.0), at(10, 4.0)};
    const auto history = open({.chunk_samples = 2, .log_commits = 1});
    const auto id = history->series(kLevel).value();
    for (const auto& sample : arrived) {
        history->append(id, sample);
        ASSERT_TRUE(history->commit(kStart));
    }
    expect_stored({arrived[2], arrived[0], arrived[3], arrived[1]});
    auto reader = HistoryReader::open(path_);
    ASSERT_TRUE(reader);
    const auto newest = reader->before(id, kStart + 11 * kSecond).value();
    ASSERT_TRUE(newest);
    EXPECT_TRUE(same(*newest, arrived[3]));
}

TEST_F(HistoryTest, DropsChunksThatAreTooOld) {
    const auto history = open({.retention = std::chrono::hours(10), .log_commits = 1});
    const auto id = history->series(kLevel).value();
    for (int hour = 0; hour < 100; ++hour) {
        history->append(id, at(hour * 3600, std::int64_t{hour}));
        history->append(HistoryGap{kStart + hour * kHour, kStart + hour * kHour, GapCause::quota, 1});
        ASSERT_TRUE(history->commit(kStart + hour * kHour));
    }
    const auto stored = read().samples;
    ASSERT_FALSE(stored.empty());
    EXPECT_LE(stored.size(), 12U);
    EXPECT_EQ(std::get<std::int64_t>(stored.back().value), 99);
    EXPECT_LE(HistoryReader::open(path_)->gaps(kAll)->size(), 12U);
}

TEST_F(HistoryTest, KeepsToItsQuotaAndUsesFreePagesAgain) {
    constexpr std::uint64_t kQuota = 1 << 20;
    const auto history = open({.quota_bytes = kQuota, .log_bytes = 64 << 10, .log_commits = 10});
    const auto id = history->series({"noise", "", DataType::float64, false, ""}).value();
    std::uint64_t seed = 1;
    for (int i = 0; i < 400'000; ++i) {
        seed = seed * 6364136223846793005 + 1442695040888963407;
        history->append(id, at(i, std::int64_t(seed)));
        if (i % 1000 == 0) {
            ASSERT_TRUE(history->commit(kStart + i * kSecond));
        }
    }
    EXPECT_GT(history->status().dropped, 100U);
    EXPECT_LE(history->status().used_bytes, kQuota + (128 << 10));
    EXPECT_LE(history->status().file_bytes, 2 * kQuota);
}

TEST_F(HistoryTest, MovesADamagedFileAside) {
    { ASSERT_TRUE(open()->series(kLevel)); }
    for (const std::string& bytes : {std::string(), std::string("SQLite fo"), std::string(5000, '\0')}) {
        overwrite(path_, bytes);
        auto opened = History::open(path_);
        ASSERT_TRUE(opened);
        EXPECT_TRUE(opened->set_aside.starts_with(path_ + ".damaged-"));
        EXPECT_EQ(bytes_of(opened->set_aside), bytes);
    }
}

TEST_F(HistoryTest, MovesAFileWhoseFirstPageIsDamagedAside) {
    {
        const auto history = open({.chunk_samples = 100, .log_commits = 1});
        const auto id = history->series(kLevel).value();
        for (int i = 0; i < 1000; ++i) history->append(id, at(i, std::int64_t{i}));
        ASSERT_TRUE(history->commit(kStart));
    }
    std::string bytes = bytes_of(path_);
    std::fill_n(bytes.begin(), 4096, 'x');
    overwrite(path_, bytes);
    EXPECT_EQ(HistoryReader::open(path_).error().code, Code::malformed);
    auto opened = History::open(path_);
    ASSERT_TRUE(opened);
    EXPECT_EQ(bytes_of(opened->set_aside), bytes);
}

TEST_F(HistoryTest, MovesAFileWithDamagedTablesAside) {
    {
        const auto history = open();
        ASSERT_TRUE(history->series(kLevel));
        ASSERT_TRUE(history->commit(kStart));
    }
    std::string bytes = bytes_of(path_);
    for (std::size_t i = 100; i < 4000; ++i) bytes[i] = 'x';
    overwrite(path_, bytes);
    auto opened = History::open(path_);
    ASSERT_TRUE(opened);
    EXPECT_FALSE(opened->set_aside.empty());
}

TEST_F(HistoryTest, ReadsTheRestWhenAChunkIsDamaged) {
    {
        const auto history = open({.chunk_samples = 100, .log_commits = 1});
        const auto id = history->series(kLevel).value();
        for (int i = 0; i < 1000; ++i) history->append(id, at(i, std::int64_t{i * i}));
        ASSERT_TRUE(history->commit(kStart));
    }
    {
        SQLite::Database database(path_, SQLite::OPEN_READWRITE);
        database.exec("UPDATE chunk SET data = zeroblob(200) WHERE id = 3");
    }
    EXPECT_EQ(read().samples.size(), 900U);
    auto reader = HistoryReader::open(path_);
    const auto picture = reader->picture(SeriesId{1}, {kStart, kStart + 1000 * kSecond}, 1000);
    ASSERT_TRUE(picture);
    EXPECT_EQ(picture->damaged_chunks, 1U);
}

// A power cut while the tables were made: the first page is on the disk, the transaction is not.
TEST_F(HistoryTest, BeginsInAnEmptyDatabase) {
    SQLite::Database(path_, SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE)
        .exec("PRAGMA journal_mode = WAL; VACUUM");
    ASSERT_EQ(std::filesystem::file_size(path_), 4096U);
    ASSERT_TRUE(History::open(path_));
    ASSERT_TRUE(HistoryReader::open(path_));
}

TEST_F(HistoryTest, LeavesAFileOfAnotherProgramAlone) {
    overwrite(path_, "not a database, but a text file");
    EXPECT_EQ(History::open(path_).error().code, Code::unsupported);
    EXPECT_EQ(HistoryReader::open(path_).error().code, Code::unsupported);
    overwrite(path_, std::string(20'000, 'x'));
    EXPECT_EQ(History::open(path_).error().code, Code::unsupported);
    std::filesystem::remove(path_);
    SQLite::Database(path_, SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE).exec("CREATE TABLE a (b)");
    EXPECT_EQ(History::open(path_).error().code, Code::unsupported);
    EXPECT_EQ(HistoryReader::open(path_).error().code, Code::unsupported);
    EXPECT_TRUE(std::filesystem::exists(path_));
}

TEST_F(HistoryTest, HasOneWriter) {
    const auto history = open();
    EXPECT_EQ(History::open(path_).error().code, Code::busy);
}

TEST_F(HistoryTest, ReportsThatThereIsNoFile) {
    EXPECT_EQ(HistoryReader::open(path_).error().code, Code::not_found);
}

TEST_F(HistoryTest, ReportsAFileThatWasReplaced) {
    const auto history = open();
    history->append(history->series(kLevel).value(), at(1, 1.0));
    std::filesystem::remove(path_);
    EXPECT_EQ(history->commit(kStart).error().code, Code::replaced);
}

// A limit of the size of files fails writes as a full disk does.
TEST_F(HistoryTest, LosesNothingOnAFullDisk) {
    const auto history = open({.log_commits = 4});
    const auto id = history->series(kLevel).value();
    Samples expected;
    const auto append_some = [&] {
        for (int i = 0; i < 500; ++i) {
            const auto second = static_cast<std::int64_t>(expected.size());
            expected.push_back(at(second, second * 7919 % 10'007));
            history->append(id, expected.back());
        }
    };
    append_some();
    ASSERT_TRUE(history->commit(kStart));
    std::signal(SIGXFSZ, SIG_IGN);
    ::rlimit limit{};
    ::getrlimit(RLIMIT_FSIZE, &limit);
    const ::rlimit small{std::filesystem::file_size(path_ + "-wal") + 5000, limit.rlim_max};
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
    int failed = 0;
    for (int i = 0; i < 10; ++i) {
        append_some();
        if (!history->commit(kStart)) ++failed;
    }
    ::setrlimit(RLIMIT_FSIZE, &limit);
    EXPECT_GT(failed, 0);
    EXPECT_GT(history->status().pending, 0U);
    ASSERT_TRUE(history->commit(kStart));
    EXPECT_EQ(history->status().pending, 0U);
    expect_stored(expected);
}

// What survives a kill is what is on the disk at that moment: a copy of the files.
TEST_F(HistoryTest, SurvivesAKillAfterEachCommit) {
    const auto history = open({.chunk_samples = 10, .log_commits = 4});
    const auto id = history->series(kLevel).value();
    Samples expected;
    for (int i = 0; i < 60; ++i) {
        expected.push_back(at(i, std::int64_t{i * 3}));
        history->append(id, expected.back());
        ASSERT_TRUE(history->commit(kStart));
        const std::string copy = directory_ / "copy.db";
        for (const char* suffix : {"", "-wal"})
            std::filesystem::copy_file(path_ + suffix, copy + suffix,
                                       std::filesystem::copy_options::overwrite_existing);
        std::filesystem::remove(copy + "-shm");
        auto reader = HistoryReader::open(copy);
        ASSERT_TRUE(reader);
        std::size_t count = 0;
        ASSERT_TRUE(reader->read(
            id, kAll, [&](const HistorySample& sample) { return same(sample, expected[count++]); }));
        ASSERT_EQ(count, expected.size());
    }
}

}  // namespace history_test
}  // namespace takt::store
