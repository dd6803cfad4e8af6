// The journal: syncs, reads, repeats, cursors, restarts.
#include "takt/store/journal.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <optional>
#include <string>

#include "journal_rig.hpp"

namespace takt::store {
namespace journal_test {

using namespace std::chrono_literals;
using namespace test;

TEST_F(JournalTest, RejectsImpossibleArguments) {
    const std::vector<std::string_view> bad_names[] = {
        {""}, {"a/b"}, {".."}, {"Cloud"}, {std::string_view("a\0", 2)}};
    for (const auto& names : bad_names)
        EXPECT_EQ(Journal::open(disk_, options_, names, now_, 0).error().code, Code::malformed) << names[0];
    const std::vector<std::string_view> twice{"a", "a"};
    EXPECT_EQ(Journal::open(disk_, options_, twice, now_, 0).error().code, Code::busy);
    options_.quota_bytes = options_.segment_bytes;
    EXPECT_EQ(Journal::open(disk_, options_, kNames, now_, 0).error().code, Code::out_of_range);
}

TEST_F(JournalTest, ReadsARecordOnlyAfterItsSync) {
    start();
    ASSERT_TRUE(append(10));
    EXPECT_EQ(read_all(kCloud).size(), 0U);
    EXPECT_EQ(journal_->next_wakeup(), now_ + 100ms);
    tick(99ms);
    EXPECT_EQ(read_all(kCloud).size(), 0U);
    tick(1ms);
    const auto entries = read_all(kCloud);
    ASSERT_EQ(entries.size(), 2U);
    ASSERT_TRUE(entries[0].gap);
    EXPECT_EQ(entries[0].gap->cause, GapCause::restart);
    EXPECT_EQ(entries[1].header.sequence, 2U);
    EXPECT_EQ(entries[1].header.epoch, 1U);
    EXPECT_EQ(read_all(kSite).size(), 2U);
}

TEST_F(JournalTest, SyncsOnceForEachInterval) {
    start();
    for (int i = 0; i < 1000; ++i) {
        ASSERT_TRUE(append(20));
        tick(1ms);
    }
    EXPECT_LE(journal_->status().syncs, 11U);
    EXPECT_GE(journal_->status().syncs, 9U);
}

TEST_F(JournalTest, SyncsEarlierBeforeTheBufferIsFull) {
    start();
    ASSERT_TRUE(append(40'000));
    ASSERT_TRUE(append(40'000));
    EXPECT_EQ(journal_->next_wakeup(), now_);
}

TEST_F(JournalTest, ReadsAgainAfterARewindAndMarksIt) {
    options_.max_in_flight = 3;
    start();
    for (int i = 0; i < 5; ++i) ASSERT_TRUE(append(10));
    tick();
    EXPECT_EQ(read_all(kCloud).size(), 3U);
    ASSERT_TRUE(journal_->acknowledge(now_, kCloud, 2));
    EXPECT_EQ(journal_->acknowledge(now_, kCloud, 2).error().code, Code::out_of_range);
    EXPECT_EQ(journal_->acknowledge(now_, kCloud, 4).error().code, Code::out_of_range);
    journal_->rewind(kCloud);
    const auto entries = read_all(kCloud);
    ASSERT_EQ(entries.size(), 3U);
    EXPECT_EQ(entries[0].header.sequence, 3U);
    EXPECT_TRUE(entries[0].repeated);
    EXPECT_FALSE(entries[1].repeated);
}

TEST_F(JournalTest, MarksWhatAKilledRunMayHaveHandedOut) {
    start();
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(append(10));
    tick();
    EXPECT_EQ(repeated(kCloud), 0U);  // hands out the gap of the start and three records
    ASSERT_TRUE(append(10));
    tick();
    start();
    tick();
    EXPECT_EQ(repeated(kCloud), 5U);
    EXPECT_EQ(repeated(kSite), 0U);
}

TEST_F(JournalTest, MarksOnlyWhatWasHandedOutBeforeAnOrderlyEnd) {
    options_.max_in_flight = 3;
    start();
    for (int i = 0; i < 5; ++i) ASSERT_TRUE(append(10));
    tick();
    EXPECT_EQ(read_all(kCloud).size(), 3U);
    ASSERT_TRUE(journal_->close(now_));
    options_.max_in_flight = 100;
    start();
    tick();
    EXPECT_EQ(repeated(kCloud), 3U);
}

TEST_F(JournalTest, MarksOnlyWhatWasHandedOutBeforeTheConnectionWasLost) {
    start();
    ASSERT_TRUE(append(10));
    tick();
    EXPECT_EQ(repeated(kCloud), 0U);
    journal_->rewind(kCloud);
    ASSERT_TRUE(append(10));
    tick();
    tick(1s);  // the cursor is saved
    tick(1s);
    start();
    tick();
    EXPECT_EQ(repeated(kCloud), 2U);
}

TEST_F(JournalTest, MarksWhatIsReadAgainAfterGoingBack) {
    start();
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(append(10));
    tick();
    acknowledge_all(kCloud);
    ASSERT_TRUE(journal_->close(now_));
    start();
    ASSERT_TRUE(journal_->go_back(now_, kCloud, 1));
    ASSERT_TRUE(journal_->close(now_));
    start();
    tick();
    EXPECT_EQ(repeated(kCloud), 4U);
}

TEST_F(JournalTest, KnowsTheOldestSampleThatWaits) {
    start();
    tick();
    EXPECT_EQ(journal_->oldest_waiting_ns(kCloud), std::nullopt) << "a start without samples";
    std::vector<std::int64_t> times;
    for (int i = 0; i < 3; ++i) {
        times.push_back(wall());
        ASSERT_TRUE(append(10));
        now_ += 1ms;
    }
    EXPECT_EQ(journal_->oldest_waiting_ns(kCloud), std::nullopt) << "not durable";
    tick();
    EXPECT_EQ(journal_->oldest_waiting_ns(kCloud), times[0]);
    const auto entries = read_all(kCloud);
    ASSERT_EQ(entries.size(), 4U);
    EXPECT_EQ(journal_->oldest_waiting_ns(kCloud), times[0]) << "in flight";
    ASSERT_TRUE(journal_->acknowledge(now_, kCloud, entries[1].header.sequence));
    EXPECT_EQ(journal_->oldest_waiting_ns(kCloud), times[1]);
    journal_->rewind(kCloud);
    EXPECT_EQ(journal_->oldest_waiting_ns(kCloud), times[1]);
    acknowledge_all(kCloud);
    EXPECT_EQ(journal_->oldest_waiting_ns(kCloud), std::nullopt);
    EXPECT_EQ(journal_->oldest_waiting_ns(kSite), times[0]);
}

TEST_F(JournalTest, RejectedSamplesCountAsDropped) {
    start();
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(append(10));  // one sample each, after the gap of the start
    tick();
    EXPECT_EQ(read_all(kCloud).size(), 4U);
    EXPECT_EQ(journal_->reject(kCloud, 9, 1).error().code, Code::out_of_range);
    EXPECT_EQ(journal_->reject(kCloud, 2, 2).error().code, Code::out_of_range);
    ASSERT_TRUE(journal_->reject(kCloud, 2, 1));
    EXPECT_EQ(journal_->counters(kCloud).dropped, 1U);
    EXPECT_EQ(journal_->counters(kCloud).gaps, 0U);
    ASSERT_TRUE(journal_->acknowledge(now_, kCloud, 4));
    const auto counters = journal_->counters(kCloud);
    EXPECT_EQ(counters.delivered, 2U);
    EXPECT_EQ(counters.dropped, 1U);
    EXPECT_EQ(counters.waiting, 0U);
}

TEST_F(JournalTest, ADestinationCanGoBack) {
    start();
    for (int i = 0; i < 5; ++i) ASSERT_TRUE(append(10));
    tick();
    EXPECT_EQ(read_all(kCloud).size(), 6U);
    ASSERT_TRUE(journal_->acknowledge(now_, kCloud, 6));
    EXPECT_EQ(journal_->counters(kCloud).delivered, 5U);
    EXPECT_EQ(*journal_->go_back(now_, kCloud, 7), 0U);
    EXPECT_EQ(*journal_->go_back(now_, kCloud, 4), 3U);
    EXPECT_EQ(*journal_->go_back(now_, kCloud, 5), 0U);
    EXPECT_EQ(journal_->counters(kCloud).waiting, 3U);
    EXPECT_EQ(journal_->counters(kCloud).delivered, 2U);
    ASSERT_TRUE(journal_->close(now_));
    start();  // another gap
    const auto entries = read_all(kCloud);
    ASSERT_GE(entries.size(), 3U);
    EXPECT_EQ(entries[0].header.sequence, 4U);
    EXPECT_EQ(journal_->counters(kCloud).appended, 5U);
}

TEST_F(JournalTest, ContinuesAfterARestartWithAGap) {
    start();
    for (int i = 0; i < 4; ++i) ASSERT_TRUE(append(10));
    tick();
    const std::int64_t last = wall() - 100'000'000;
    acknowledge_all(kCloud);
    ASSERT_TRUE(append(10));
    ASSERT_TRUE(journal_->close(now_));
    const std::int64_t closed = wall();
    now_ += 10s;
    start();
    tick();
    const auto entries = read_all(kCloud);
    ASSERT_EQ(entries.size(), 2U);
    EXPECT_EQ(entries[0].header.sequence, 6U);
    ASSERT_TRUE(entries[1].gap);
    EXPECT_EQ(entries[1].gap->cause, GapCause::restart);
    EXPECT_EQ(entries[1].gap->first_wall_ns, closed);
    EXPECT_EQ(entries[1].gap->last_wall_ns, closed + 10 * kSecond);
    EXPECT_EQ(entries[1].header.epoch, 2U);
    EXPECT_EQ(read_all(kSite).size(), 7U);
    EXPECT_EQ(journal_->counters(kSite).waiting, 5U);
    EXPECT_GT(closed, last);
}

TEST_F(JournalTest, AStartSynchronisesTheLastSegmentOnly) {
    start();
    for (int i = 0; i < 8; ++i) {
        ASSERT_TRUE(append(40'000));
        tick();
    }
    ASSERT_TRUE(journal_->close(now_));
    ASSERT_GE(journal_->status().segments, 8U);
    const int before = disk_.operations();
    start();
    EXPECT_EQ(disk_.operations() - before, 3);  // the segment, and the cursors of two destinations
    EXPECT_EQ(journal_->counters(kCloud).waiting, 8U);
}

TEST_F(JournalTest, KeepsAcknowledgedSegmentsForTheRetention) {
    options_.retention = 1h;
    start();
    for (int i = 0; i < 20; ++i) {
        ASSERT_TRUE(append(15'000));
        tick();
    }
    acknowledge_all(kCloud);
    tick(2s);
    tick(2h);
    EXPECT_EQ(disk_.contents().begin()->first, 1U) << "the other destination has not acknowledged";
    acknowledge_all(kSite);
    tick(2s);
    EXPECT_EQ(disk_.contents().size(), 1U) << "the last segment stays";
}

TEST_F(JournalTest, ReplaysAcknowledgedRecords) {
    start();
    for (int i = 0; i < 20; ++i) {
        ASSERT_TRUE(append(15'000));
        tick();
    }
    acknowledge_all(kCloud);
    acknowledge_all(kSite);
    const auto stream = journal_->replay(7);
    for (std::uint64_t sequence = 7; sequence <= 21; ++sequence) {
        const auto entry = stream->next();
        ASSERT_TRUE(entry && *entry);
        EXPECT_EQ((*entry)->header.sequence, sequence);
    }
    EXPECT_FALSE(*stream->next());
    EXPECT_EQ(journal_->sequence_before(0), 1U);
    const std::uint64_t middle = journal_->sequence_before(kSecond + 1'000'000'000);
    EXPECT_GT(middle, 5U);
    EXPECT_LE(middle, 12U);
}

TEST_F(JournalTest, BeginsWithTheOldestRecordIfACursorIsDamaged) {
    start();
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(append(100));
    tick();
    acknowledge_all(kCloud);
    tick(2s);
    EXPECT_EQ(journal_->durable_cursor(kCloud), 4U);
    EXPECT_EQ(journal_->acknowledged(kCloud), 4U);
    disk_.flip_cursor("cloud", 30);
    disk_.flip_cursor("cloud", SimulatedDisk::kSlotOffset + 30);
    start();
    EXPECT_EQ(read_all(kCloud).size(), 4U);
}

TEST_F(JournalTest, DeliversWhatWaitsIfACursorFileIsMissing) {
    start();
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(append(100));
    tick();
    ASSERT_TRUE(journal_->close(now_));
    disk_.remove_cursor("cloud");
    for (int restart = 0; restart < 2; ++restart) {
        start();
        EXPECT_EQ(journal_->counters(kCloud).waiting, 3U);
        tick();
    }
    EXPECT_EQ(repeated(kCloud), 4U) << "the gap of the first start, and three records";
    EXPECT_EQ(repeated(kSite), 0U);
    journal_->rewind(kCloud);
    acknowledge_all(kCloud);
    EXPECT_EQ(journal_->counters(kCloud).waiting, 0U);
}

TEST_F(JournalTest, AJournalWhoseFilesWereRemovedUsesNoPairOfEpochAndNumberAgain) {
    start();
    ASSERT_TRUE(append(10));
    tick();
    const auto former = journal_->status().epoch;
    now_ += 5s;
    start();
    EXPECT_EQ(journal_->status().epoch, former + 1);
    tick();
    now_ += 5s;
    disk_ = SimulatedDisk{};
    start();
    EXPECT_GT(journal_->status().epoch, former + 1);
    EXPECT_EQ(journal_->status().epoch, static_cast<std::uint64_t>(wall() / kSecond));
}

TEST_F(JournalTest, DoesNotUseANumberAgainIfTheSegmentsAreGone) {
    start();
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(append(100));
    tick();
    acknowledge_all(kCloud);
    tick(2s);
    ASSERT_TRUE(disk_.remove(1));
    start();
    ASSERT_TRUE(append(100));
    tick();
    const auto entries = read_all(kCloud);
    ASSERT_EQ(entries.size(), 2U);
    EXPECT_EQ(entries[0].header.sequence, 5U);
    const auto others = read_all(kSite);
    ASSERT_EQ(others.size(), 3U);
    EXPECT_EQ(others[0].gap->samples, 3U);
}

TEST_F(JournalTest, WritesAgainInAnotherSegmentAfterAFailedSync) {
    start();
    tick();
    ASSERT_TRUE(append(100));
    disk_.fail_from = disk_.operations() + 1;  // after the append
    disk_.fail_count = 1;
    tick();
    EXPECT_EQ(journal_->status().durable_sequence, 1U);
    EXPECT_EQ(read_all(kCloud).size(), 1U);
    tick();
    EXPECT_EQ(journal_->status().durable_sequence, 2U);
    EXPECT_EQ(disk_.contents().size(), 2U);
    EXPECT_EQ(read_all(kCloud).size(), 1U);
    EXPECT_EQ(read_all(kSite).size(), 2U);
}

}  // namespace journal_test
}  // namespace takt::store
