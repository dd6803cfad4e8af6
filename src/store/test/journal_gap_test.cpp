// What the journal loses, and what its counters say of it: overflow, quota, damage, a full disk.
#include <gtest/gtest.h>

#include <functional>

#include <algorithm>
#include <array>
#include <cerrno>
#include <optional>
#include <string>

#include "journal_rig.hpp"

namespace takt::store {
namespace journal_gap_test {

using namespace std::chrono_literals;
using namespace test;

using JournalGapTest = JournalTest;

TEST_F(JournalGapTest, TurnsOverflowIntoAGapInItsPlace) {
    start();
    ASSERT_TRUE(append(60'000));
    ASSERT_TRUE(append(60'000));
    now_ += 1ms;
    const std::int64_t first = wall();
    EXPECT_EQ(append(60'000, 5).error().code, Code::queue_full);
    now_ += 1ms;
    EXPECT_EQ(append(60'000, 7).error().code, Code::queue_full);
    EXPECT_EQ(append(kMaxPayloadBytes + 1).error().code, Code::too_long);
    const std::int64_t last = wall();
    EXPECT_EQ(journal_->counters(kCloud).waiting, 2U);
    EXPECT_EQ(journal_->counters(kCloud).dropped, 12U);
    EXPECT_EQ(journal_->counters(kCloud).gaps, 1U);
    tick();
    EXPECT_EQ(journal_->counters(kCloud).dropped, 12U);
    ASSERT_TRUE(append(10));
    tick();
    tick();
    const auto entries = read_all(kCloud);
    ASSERT_EQ(entries.size(), 5U);
    ASSERT_TRUE(entries[3].gap);
    EXPECT_EQ(*entries[3].gap, (Gap{GapCause::buffer_full, 12, 4, 4, first, last}));
    EXPECT_EQ(entries[4].header.samples_before, 14U);
    ASSERT_TRUE(journal_->acknowledge(now_, kCloud, 4));
    const DestinationCounters counters = journal_->counters(kCloud);
    EXPECT_EQ(counters.appended, 15U);
    EXPECT_EQ(counters.delivered, 2U);
    EXPECT_EQ(counters.dropped, 12U);
    EXPECT_EQ(counters.waiting, 1U);
}

TEST_F(JournalGapTest, WritesTheLossesOfTheSource) {
    start();
    ASSERT_TRUE(append(10));
    journal_->append_loss(now_, {.samples = 9, .first_wall_ns = 100, .last_wall_ns = 200});
    ASSERT_TRUE(append(10));
    tick();
    const auto entries = read_all(kCloud);
    ASSERT_EQ(entries.size(), 4U);
    ASSERT_TRUE(entries[2].gap);
    EXPECT_EQ(*entries[2].gap, (Gap{GapCause::source_lost, 9, 3, 3, 100, 200}));
}

TEST_F(JournalGapTest, AGapBeginsWithTheOldestSampleThatIsMissing) {
    start();
    ASSERT_TRUE(append(60'000));
    ASSERT_TRUE(append(60'000));
    const std::vector<std::uint8_t> payload(60'000);
    const auto lost =
        journal_->append(now_, {.samples = 3, .wall_ns = 900, .payload = payload, .oldest_wall_ns = 700});
    EXPECT_EQ(lost.error().code, Code::queue_full);
    tick();
    const auto entries = read_all(kCloud);
    ASSERT_EQ(entries.size(), 4U);
    EXPECT_EQ(*entries[3].gap, (Gap{GapCause::buffer_full, 3, 4, 4, 700, 900}));
}

TEST_F(JournalGapTest, ALossBeforeTheJournalHasTheCauseOfAFullBuffer) {
    start();
    tick();
    const JournalLoss loss{.samples = 2, .first_wall_ns = 100, .last_wall_ns = 200, .buffer_full = true};
    journal_->append_loss(now_, loss);
    tick();
    disk_.error_number = ENOSPC;
    disk_.fail_from = disk_.operations();
    disk_.fail_count = 1;
    ASSERT_TRUE(append(10));
    tick();
    journal_->append_loss(now_, loss);
    tick();
    tick();
    const auto entries = read_all(kCloud);
    ASSERT_EQ(entries.size(), 4U);
    EXPECT_EQ(entries[1].gap->cause, GapCause::buffer_full);
    EXPECT_EQ(entries[3].gap->cause, GapCause::disk_full);
}

TEST_F(JournalGapTest, TheOldestSampleThatWaitsIsNotInAGap) {
    options_.quota_bytes = 2 * options_.segment_bytes;
    start();
    append_records(1);
    const auto first = journal_->oldest_waiting_ns(kCloud);
    ASSERT_TRUE(first);
    append_records(12);
    ASSERT_GT(journal_->status().dropped_segments, 0U);
    const auto oldest = journal_->oldest_waiting_ns(kCloud);
    const auto entries = read_all(kCloud);
    ASSERT_TRUE(entries.front().gap);
    EXPECT_EQ(oldest, entries[1].header.wall_ns);
    EXPECT_GT(oldest, first);
}

TEST_F(JournalGapTest, DropsTheOldestSegmentAboveTheQuota) {
    start();
    tick();
    acknowledge_all(kCloud);
    for (int i = 0; i < 100; ++i) {
        ASSERT_TRUE(append(15'000, 2));
        tick();
        acknowledge_all(kCloud);
    }
    const JournalStatus status = journal_->status();
    EXPECT_LE(status.disk_bytes, options_.quota_bytes);
    EXPECT_GT(status.dropped_segments, 0U);
    EXPECT_EQ(journal_->counters(kCloud).dropped, 0U);
    const auto counters = journal_->counters(kSite);
    EXPECT_EQ(counters.waiting + counters.dropped, 200U);
    EXPECT_EQ(counters.gaps, 1U);
    const auto entries = read_all(kSite);
    ASSERT_TRUE(entries[0].gap);
    EXPECT_EQ(counters.dropped, entries[0].gap->samples) << "known before it was read";
    EXPECT_EQ(entries[0].gap->cause, GapCause::quota);
    EXPECT_EQ(entries[0].gap->first_sequence, 1U);
    EXPECT_EQ(entries[0].gap->last_sequence + 1, entries[1].header.sequence);
    EXPECT_EQ(entries[0].gap->first_wall_ns, kSecond);  // the first start
    std::uint64_t samples = 0;
    for (const JournalEntry& entry : entries) samples += entry.header.samples;
    EXPECT_EQ(samples, 200U);
    acknowledge_all(kSite);
}

TEST_F(JournalGapTest, AGapBehindAGapBeginsWithTheLastRecordBeforeBoth) {
    options_.quota_bytes = 2 * options_.segment_bytes;
    start();
    tick();
    acknowledge_all(kCloud);  // the gap of the start
    const std::int64_t before = kSecond;
    const auto gap_after_drops = [&] {
        for (int i = 0; i < 8; ++i) {
            EXPECT_TRUE(append(30'000));
            tick();
        }
        const auto entry = journal_->read(kCloud);
        return entry && *entry && (*entry)->gap ? *(*entry)->gap : Gap{};
    };
    const Gap first = gap_after_drops();
    const Gap second = gap_after_drops();
    EXPECT_EQ(first.cause, GapCause::quota);
    EXPECT_EQ(first.first_wall_ns, before);
    EXPECT_EQ(second.cause, GapCause::quota);
    EXPECT_EQ(second.first_sequence, first.last_sequence + 1);
    EXPECT_EQ(second.first_wall_ns, before);
}

TEST_F(JournalGapTest, TurnsADamagedRecordIntoAnExactGap) {
    start();
    for (int i = 0; i < 20; ++i) {
        ASSERT_TRUE(append(15'000, 3));
        tick();
    }
    ASSERT_TRUE(journal_->close(now_));
    disk_.flip(2, 15'100);  // its second record
    disk_.flip(3, 5);       // the length of its first record
    start();
    std::vector<Gap> gaps;
    for (const JournalEntry& entry : read_all(kCloud))
        if (entry.gap) gaps.push_back(*entry.gap);
    ASSERT_EQ(gaps.size(), 3U);  // the first is the first start
    EXPECT_EQ(gaps[1].cause, GapCause::damaged);
    EXPECT_EQ(gaps[1].samples, 3U);
    EXPECT_EQ(gaps[1].first_sequence, gaps[1].last_sequence);
    EXPECT_EQ(gaps[2].samples, 3U);
    EXPECT_EQ(gaps[2].first_sequence, gaps[2].last_sequence);
}

TEST_F(JournalGapTest, DamageOfTheFirstRecordsIsNotTakenForTheQuota) {
    for (const bool file_is_gone : {false, true}) {
        disk_ = SimulatedDisk{};
        start();
        append_records(6);
        const std::uint64_t first = disk_.contents().begin()->first;
        if (file_is_gone) {
            ASSERT_TRUE(disk_.remove(first));
        } else {
            disk_.flip(first, 9);
        }
        start();
        const auto entry = journal_->read(kCloud);
        ASSERT_TRUE(entry && *entry && (*entry)->gap);
        EXPECT_EQ((*entry)->gap->cause, GapCause::damaged);
        EXPECT_EQ((*entry)->gap->first_sequence, 1U);
        EXPECT_EQ((*entry)->gap->last_sequence, file_is_gone ? 3U : 1U)
            << "the gap of the start, two records";
        EXPECT_EQ((*entry)->gap->samples, file_is_gone ? 2U : 0U);
    }
}

TEST_F(JournalGapTest, ALaterStartKnowsWhatTheQuotaHasRemoved) {
    options_.quota_bytes = 3 * options_.segment_bytes;
    start();
    append_records(12);
    const std::uint64_t dropped = (*journal_->read(kCloud))->gap->last_sequence;
    EXPECT_GE(dropped, 3U);
    options_.quota_bytes = 20 * options_.segment_bytes;  // a user has raised it
    start();
    EXPECT_EQ((*journal_->read(kCloud))->gap->cause, GapCause::quota);
    disk_.flip(disk_.contents().begin()->first, 9);
    start();
    for (const auto& [id, cause] :
         {std::pair(kCloud, GapCause::quota), std::pair(kCloud, GapCause::damaged)}) {
        const auto entry = journal_->read(id);
        ASSERT_TRUE(entry && *entry && (*entry)->gap);
        EXPECT_EQ((*entry)->gap->cause, cause);
        EXPECT_EQ((*entry)->gap->first_sequence, cause == GapCause::quota ? 1U : dropped + 1);
        EXPECT_EQ((*entry)->gap->last_sequence, cause == GapCause::quota ? dropped : dropped + 1);
    }
}

// The quota removes what was acknowledged, but not durably: the cursors become durable first. Otherwise a
// start after a kill would take the segment for a damaged one.
TEST_F(JournalGapTest, TheQuotaRemovesNothingBehindADurableCursor) {
    options_.quota_bytes = 3 * options_.segment_bytes;
    start();
    append_records(3);
    for (const auto id : {kCloud, kSite}) acknowledge_all(id);
    const auto first = disk_.contents().begin()->first;
    while (disk_.contents().contains(first)) append_records(1);
    start();  // without close()
    const auto entry = journal_->read(kCloud);
    ASSERT_TRUE(entry && *entry);
    EXPECT_FALSE((*entry)->gap);
    EXPECT_EQ((*entry)->header.sequence, 5U);
}

TEST_F(JournalGapTest, ASegmentThatIsGoneBetweenOthersHasTheCauseOfItsRemoval) {
    options_.quota_bytes = 4 * options_.segment_bytes;
    for (const bool by_quota : {true, false}) {
        disk_ = SimulatedDisk{};
        start();
        append_records(6);
        ASSERT_EQ(disk_.contents().size(), 3U);
        const std::uint64_t second = std::next(disk_.contents().begin())->first;
        if (by_quota) {
            disk_.keeps = disk_.contents().begin()->first;
            append_records(4);
            ASSERT_EQ(disk_.contents().count(second), 0U);
        } else {
            ASSERT_TRUE(disk_.remove(second));
        }
        start();
        tick();
        const auto entries = read_all(kCloud);
        ASSERT_GE(entries.size(), 4U);
        ASSERT_TRUE(entries[3].gap);
        EXPECT_EQ(entries[3].gap->cause, by_quota ? GapCause::quota : GapCause::damaged);
        EXPECT_EQ(entries[3].gap->samples, by_quota ? 4U : 2U)
            << "the segment of the start pushes out another one";
        EXPECT_EQ(entries[3].gap->first_sequence, 4U);
    }
}

// The first segment ends with the rest of a failed write. The second has those records again, and the quota
// removes it.
TEST_F(JournalGapTest, BehindAFailedWriteTheQuotaIsTheCauseOfItsGap) {
    options_.quota_bytes = 4 * options_.segment_bytes;
    start();
    append_records(1);
    disk_.fail_from = disk_.operations();
    disk_.fail_count = 1;
    append_records(1);
    ASSERT_TRUE(journal_->status().failure);
    disk_.keeps = disk_.contents().begin()->first;
    const std::uint64_t second = disk_.contents().begin()->first + 1;
    disk_.fail_from = -1;
    tick(1s);
    ASSERT_EQ(disk_.contents().count(second), 1U);
    while (disk_.contents().count(second) != 0) append_records(1);
    start();
    const auto entries = read_all(kCloud);
    ASSERT_GE(entries.size(), 3U);
    ASSERT_TRUE(entries[2].gap);
    EXPECT_EQ(entries[2].gap->cause, GapCause::quota);
    EXPECT_EQ(entries[2].gap->first_sequence, 3U);
}

// The samples of the first record were taken before the journal was opened.
TEST_F(JournalGapTest, AGapDoesNotEndBeforeItBegins) {
    start();
    for (const std::int64_t before : {500, 400}) {
        const std::vector<std::uint8_t> payload(100);
        ASSERT_TRUE(journal_->append(now_, {1, wall() - before, 0, payload}));
    }
    tick();
    disk_.flip(disk_.contents().begin()->first, kGapRecordBytes + 9);
    start();
    const auto entries = read_all(kCloud);
    ASSERT_GE(entries.size(), 2U);
    ASSERT_TRUE(entries[1].gap);
    EXPECT_EQ(entries[1].gap->cause, GapCause::damaged);
    EXPECT_EQ(entries[1].gap->first_wall_ns, kSecond - 400);
    EXPECT_EQ(entries[1].gap->last_wall_ns, kSecond - 400);
}

TEST_F(JournalGapTest, DamageThatWaitsIsCountedAfterTheStart) {
    start();
    append_records(6);
    disk_.flip(1, 40'000);
    disk_.flip(3, 9);
    start();
    const auto before = journal_->counters(kCloud);
    EXPECT_EQ(before.waiting, 4U);
    EXPECT_EQ(before.dropped, 2U);
    EXPECT_EQ(before.gaps, 2U);
    tick();
    acknowledge_all(kCloud);
    const auto after = journal_->counters(kCloud);
    EXPECT_EQ(after.delivered, before.waiting);
    EXPECT_EQ(after.dropped, before.dropped);
    EXPECT_EQ(after.gaps, before.gaps);
    tick(2s);
    start();
    EXPECT_EQ(journal_->counters(kCloud).gaps, before.gaps);
    EXPECT_EQ(journal_->counters(kSite).dropped, before.dropped);
}

TEST_F(JournalGapTest, DamageThatIsFoundWhileReadingIsCounted) {
    start();
    append_records(6);
    disk_.flip(1, 40'000);
    EXPECT_EQ(journal_->counters(kCloud).dropped, 0U) << "not known yet";
    EXPECT_EQ(read_all(kCloud).size(), 7U);
    journal_->rewind(kCloud);
    EXPECT_EQ(journal_->counters(kCloud).dropped, 1U);
    EXPECT_EQ(journal_->counters(kCloud).waiting, 5U);
}

TEST_F(JournalGapTest, GapsOfAnEarlierRunAreCountedWhileTheyWait) {
    options_.quota_bytes = 4 << 20;
    start();
    for (int i = 0; i < 5; ++i) static_cast<void>(append(60'000, 3));  // two fit the buffer
    tick();
    tick();
    append_records(60);  // more than a step of the survey
    ASSERT_TRUE(journal_->close(now_));
    start();
    EXPECT_EQ(journal_->counters(kCloud).dropped, 9U);
    disk_.flip(std::prev(disk_.contents().end(), 3)->first, 9);
    start();
    EXPECT_EQ(journal_->counters(kCloud).dropped, 9U) << "not reached yet";
    for (int i = 0; i < 10; ++i) tick();
    EXPECT_EQ(journal_->counters(kCloud).dropped, 10U);
    EXPECT_EQ(journal_->counters(kCloud).gaps, 2U);
}

TEST_F(JournalGapTest, WhatIsInFlightWaitsAlsoIfTheQuotaRemovesIt) {
    options_.quota_bytes = 2 * options_.segment_bytes;
    start();
    append_records(3);
    EXPECT_EQ(read_all(kCloud).size(), 4U);
    append_records(6);
    EXPECT_EQ(journal_->counters(kCloud).waiting, 6U) << "three in flight, three on the disk";
    const auto other = journal_->counters(kSite);
    EXPECT_EQ(other.waiting, 3U);
    EXPECT_EQ(other.dropped, 6U);
    journal_->rewind(kCloud);
    EXPECT_EQ(journal_->counters(kCloud).dropped, other.dropped);
}

TEST_F(JournalGapTest, CutsATornTail) {
    start();
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(append(100));
    tick();
    disk_.flip(1, disk_.contents().at(1).size() - 1);
    start();
    EXPECT_EQ(journal_->status().torn_bytes, 100 + kRecordOverheadBytes);
    EXPECT_EQ(journal_->status().durable_sequence, 4U) << "it was synchronised: its sample is a gap";
    EXPECT_EQ(journal_->counters(kCloud).dropped, 1U);
}

TEST_F(JournalGapTest, DamageBeforeTheLastRecordIsNoTornTail) {
    start();
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(append(100));
    tick();
    disk_.flip(1, 200);
    start();
    EXPECT_EQ(journal_->status().torn_bytes, 0U);
    EXPECT_EQ(journal_->counters(kCloud).dropped, 1U);
}

// The last segment is damaged in each way while the program does not run.
TEST_F(JournalGapTest, TheEndOfTheStreamIsKnownWithoutTheLastSegment) {
    enum class Ending : std::uint8_t { orderly, killed };
    using Damage = std::function<void(SimulatedDisk&, std::uint64_t)>;
    const Damage damages[] = {
        [](SimulatedDisk& disk, std::uint64_t last) { disk.remove_segment(last); },
        [](SimulatedDisk& disk, std::uint64_t last) { disk.truncate(last, 0); },
        [](SimulatedDisk& disk, std::uint64_t last) { disk.truncate(last, 20'000); },
        [](SimulatedDisk& disk, std::uint64_t last) { disk.zero(last); },
        [](SimulatedDisk& disk, std::uint64_t) {
            for (const auto& [number, bytes] : disk.contents()) disk.remove_segment(number);
        },
    };
    for (const auto ending : {Ending::orderly, Ending::killed})
        for (std::size_t i = 0; i < std::size(damages); ++i) {
            disk_ = {};
            start();
            append_records(5);
            acknowledge_all(kSite);
            append_records(6);
            if (ending == Ending::orderly) {
                ASSERT_TRUE(journal_->close(now_));
            }
            const auto before = journal_->counters(kCloud);
            const auto acknowledged = journal_->durable_cursor(kSite);
            journal_.reset();
            damages[i](disk_, disk_.contents().rbegin()->first);
            start();
            tick(10s);
            for (const auto id : {kCloud, kSite}) {
                std::uint64_t sequence = id == kSite ? acknowledged : 0;
                std::uint64_t delivered = sequence > 0 ? sequence - 1 : 0;  // the first one is the start
                std::uint64_t missing = 0;
                for (const auto& entry : read_all(id)) {
                    EXPECT_EQ(entry.gap ? entry.gap->first_sequence : entry.header.sequence, sequence + 1);
                    sequence = entry.header.sequence;
                    if (!entry.gap)
                        delivered += entry.header.samples;
                    else if (entry.gap->cause == GapCause::damaged)
                        missing += entry.gap->samples;
                }
                EXPECT_EQ(delivered + missing, before.appended) << i;
                EXPECT_GT(missing, 0U) << i;
                EXPECT_EQ(journal_->counters(id).dropped, missing) << i;
                EXPECT_EQ(journal_->counters(id).appended, before.appended) << i;
            }
        }
}

TEST_F(JournalGapTest, WhatAFullDiskDidNotTakeIsAGapOfTheNextStart) {
    for (const bool killed : {false, true}) {
        disk_ = {};
        start();
        append_records(3);
        disk_.full = true;
        ASSERT_TRUE(append(30'000, 7));
        tick();
        for (int i = 0; i < 10; ++i) static_cast<void>(append(30'000, 10));  // the buffer overflows
        EXPECT_GT(journal_->status().samples_lost, 0U);
        EXPECT_EQ(journal_->status().buffer_samples, 107U);
        if (killed)
            tick(1s);
        else
            EXPECT_FALSE(journal_->close(now_));
        const auto before = journal_->counters(kCloud);
        EXPECT_EQ(before.appended, 110U);
        journal_.reset();
        disk_.full = false;
        start();
        tick(10s);
        std::vector<Gap> gaps;
        for (const auto& entry : read_all(kCloud))
            if (entry.gap) gaps.push_back(*entry.gap);
        ASSERT_EQ(gaps.size(), 3U) << "restart, what was in memory, restart";
        EXPECT_EQ(gaps[1].cause, GapCause::disk_full);
        EXPECT_EQ(gaps[1].samples, 107U);
        EXPECT_LE(gaps[1].first_wall_ns, gaps[1].last_wall_ns);
        EXPECT_EQ(journal_->counters(kCloud).appended, before.appended);
        EXPECT_EQ(journal_->counters(kCloud).dropped, 107U);
        start();
        tick(10s);
        EXPECT_EQ(journal_->counters(kCloud).dropped, 107U) << "it is reported once";
    }
}

TEST_F(JournalGapTest, SegmentsAreSmallWhileTheStorageWantsThat) {
    start();
    disk_.segment_limit = 31'000;
    append_records(6);
    EXPECT_GE(journal_->status().segments, 5U);
    disk_.segment_limit = 1U << 30;
    append_records(6);
    EXPECT_LE(journal_->status().segments, 10U);
    EXPECT_EQ(read_all(kCloud).size(), 13U);
}

TEST_F(JournalGapTest, GoesOnInMemoryWhileTheDiskIsFull) {
    start();
    tick();
    disk_.fail_from = disk_.operations();
    disk_.fail_count = 1'000'000;
    disk_.error_number = ENOSPC;
    std::uint64_t rejected = 0;
    for (int i = 0; i < 100; ++i) {
        if (!append(4'000)) ++rejected;
        tick();
    }
    EXPECT_GT(rejected, 50U);
    ASSERT_TRUE(journal_->status().failure);
    EXPECT_EQ(journal_->status().failure->numbers[0], ENOSPC);
    EXPECT_LE(journal_->status().buffer_bytes, options_.buffer_bytes);
    EXPECT_LE(journal_->status().segments, 6U);
    disk_.fail_from = -1;
    tick(5s);
    EXPECT_FALSE(journal_->status().failure);
    tick();
    const auto entries = read_all(kCloud);
    ASSERT_TRUE(entries.back().gap);
    EXPECT_EQ(entries.back().gap->cause, GapCause::disk_full);
    EXPECT_EQ(entries.back().gap->samples, rejected);
    EXPECT_EQ(entries.size(), 2 + (100 - rejected));
}

}  // namespace journal_gap_test
}  // namespace takt::store
