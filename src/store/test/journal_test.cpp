// The journal on a disk that works, is full, is damaged or fails.
#include "takt/store/journal.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <optional>
#include <string>

#include "simulated_disk.hpp"

namespace takt::store {
namespace {

using namespace std::chrono_literals;
using test::SimulatedDisk;

constexpr std::array<std::string_view, 2> kNames{"cloud", "site"};
constexpr DestinationId kCloud{0};
constexpr DestinationId kSite{1};
constexpr std::int64_t kSecond = 1'000'000'000;

JournalOptions small() {
    JournalOptions options;
    options.segment_bytes = 64 << 10;
    options.buffer_bytes = 128 << 10;
    options.quota_bytes = 1 << 20;
    return options;
}

class JournalTest : public testing::Test {
protected:
    void start() {
        journal_.reset();
        auto opened = Journal::open(disk_, options_, kNames, now_, wall());
        ASSERT_TRUE(opened) << name(opened.error().code);
        journal_.emplace(*std::move(opened));
    }
    Result<void> append(std::size_t bytes, std::uint64_t samples = 1) {
        return journal_->append(now_, {samples, wall(), 0, std::vector<std::uint8_t>(bytes, 0x5A)});
    }
    /// Records of one sample, two to a segment.
    void append_records(int records) {
        for (int i = 0; i < records; ++i) {
            ASSERT_TRUE(append(30'000));
            tick();
        }
    }
    void tick(Duration time = 100ms) {
        now_ += time;
        journal_->on_tick(now_, wall());
    }
    std::vector<JournalEntry> read_all(DestinationId id) {
        std::vector<JournalEntry> entries;
        for (;;) {
            const auto entry = journal_->read(id);
            if (!entry || !*entry) return entries;
            entries.push_back(**entry);
        }
    }
    /// Reads all. @returns how many entries are marked as repeated; they are the first ones
    std::size_t repeated(DestinationId id) {
        const auto entries = read_all(id);
        const auto is_new = [](const JournalEntry& entry) { return !entry.repeated; };
        const auto first = std::ranges::find_if(entries, is_new);
        EXPECT_TRUE(std::all_of(first, entries.end(), is_new));
        return static_cast<std::size_t>(first - entries.begin());
    }
    /// Reads all. @returns the gap at this place; without samples: there is none
    Gap gap_at(DestinationId id, std::size_t index) {
        const auto entries = read_all(id);
        return index < entries.size() && entries[index].gap ? *entries[index].gap : Gap{};
    }
    void acknowledge_all(DestinationId id) {
        const auto entries = read_all(id);
        if (!entries.empty()) {
            ASSERT_TRUE(journal_->acknowledge(now_, id, entries.back().header.sequence));
        }
    }
    [[nodiscard]] std::int64_t wall() const { return kSecond + now_.time_since_epoch().count(); }

    SimulatedDisk disk_;
    JournalOptions options_ = small();
    std::optional<Journal> journal_;
    Instant now_{};
};

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

TEST_F(JournalTest, TurnsOverflowIntoAGapInItsPlace) {
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

TEST_F(JournalTest, WritesTheLossesOfTheSource) {
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

TEST_F(JournalTest, AGapBeginsWithTheOldestSampleThatIsMissing) {
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

TEST_F(JournalTest, ALossBeforeTheJournalHasTheCauseOfAFullBuffer) {
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

TEST_F(JournalTest, TheOldestSampleThatWaitsIsNotInAGap) {
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

TEST_F(JournalTest, DropsTheOldestSegmentAboveTheQuota) {
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

TEST_F(JournalTest, AGapBehindAGapBeginsWithTheLastRecordBeforeBoth) {
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

TEST_F(JournalTest, TurnsADamagedRecordIntoAnExactGap) {
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

TEST_F(JournalTest, DamageOfTheFirstRecordsIsNotTakenForTheQuota) {
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

TEST_F(JournalTest, ALaterStartKnowsWhatTheQuotaHasRemoved) {
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

TEST_F(JournalTest, ASegmentThatIsGoneBetweenOthersHasTheCauseOfItsRemoval) {
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
        EXPECT_EQ(entries[3].gap->samples, 2U);
        EXPECT_EQ(entries[3].gap->first_sequence, 4U);
    }
}

TEST_F(JournalTest, ADamagedBeginningOfASegmentIsNotTakenForTheQuota) {
    start();
    for (int i = 0; i < 6; ++i) {
        ASSERT_TRUE(append(30'000));
        tick();
    }
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(journal_->read(kCloud));
    ASSERT_TRUE(journal_->acknowledge(now_, kCloud, 3));
    tick(10s);
    const auto segments = disk_.contents();
    ASSERT_EQ(segments.size(), 3U);
    disk_.flip(std::next(segments.begin())->first, 10);
    start();
    // Behind a segment that is whole, and as the beginning of all that is there.
    EXPECT_EQ(gap_at(kSite, 3).cause, GapCause::damaged);
    EXPECT_EQ(gap_at(kCloud, 0).cause, GapCause::damaged);
    ASSERT_TRUE(disk_.remove(segments.begin()->first));
    start();
    const Gap gap = gap_at(kCloud, 0);
    EXPECT_EQ(gap.cause, GapCause::damaged);
    EXPECT_EQ(gap.samples, 1U);
    EXPECT_EQ(gap.first_sequence, 4U);
    EXPECT_EQ(gap.last_sequence, 4U);
}

TEST_F(JournalTest, DamageThatWaitsIsCountedAfterTheStart) {
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

TEST_F(JournalTest, DamageThatIsFoundWhileReadingIsCounted) {
    start();
    append_records(6);
    disk_.flip(1, 40'000);
    EXPECT_EQ(journal_->counters(kCloud).dropped, 0U) << "not known yet";
    EXPECT_EQ(read_all(kCloud).size(), 7U);
    journal_->rewind(kCloud);
    EXPECT_EQ(journal_->counters(kCloud).dropped, 1U);
    EXPECT_EQ(journal_->counters(kCloud).waiting, 5U);
}

TEST_F(JournalTest, GapsOfAnEarlierRunAreCountedWhileTheyWait) {
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

TEST_F(JournalTest, WhatIsInFlightWaitsAlsoIfTheQuotaRemovesIt) {
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

TEST_F(JournalTest, CutsATornTail) {
    start();
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(append(100));
    tick();
    disk_.flip(1, disk_.contents().at(1).size() - 1);
    start();
    EXPECT_EQ(journal_->status().torn_bytes, 100 + kRecordOverheadBytes);
    EXPECT_EQ(journal_->status().durable_sequence, 3U);
}

TEST_F(JournalTest, DamageBeforeTheLastRecordIsNoTornTail) {
    start();
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(append(100));
    tick();
    disk_.flip(1, 200);
    start();
    EXPECT_EQ(journal_->status().torn_bytes, 0U);
    EXPECT_EQ(journal_->counters(kCloud).dropped, 1U);
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

TEST_F(JournalTest, GoesOnInMemoryWhileTheDiskIsFull) {
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

}  // namespace
}  // namespace takt::store
