// Every crash point of a short run of the journal: what was durable is delivered, in order, and gaps are
// exact.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <string>

#include "simulated_disk.hpp"
#include "takt/store/journal.hpp"

namespace takt::store {
namespace journal_crash_test {

using namespace std::chrono_literals;
using test::SimulatedDisk;

constexpr std::array<std::string_view, 2> kNames{"fast", "slow"};
constexpr DestinationId kFast{0};
constexpr DestinationId kSlow{1};
constexpr std::size_t kPayload = 15'000;  // four records fill a segment

JournalOptions small() {
    JournalOptions options;
    options.segment_bytes = 64 << 10;
    options.buffer_bytes = 128 << 10;
    options.cursor_interval = 200ms;
    options.retention = 0ms;
    return options;
}

/// What a destination has received, over all runs.
struct Received {
    std::uint64_t next = 0;  // sequence number after the last entry; 0: any
    std::uint64_t acknowledged = 0;
    std::uint64_t durable_cursor = 0;  // the last one known
    std::vector<bool> ids;             // of samples
    std::uint64_t gap_samples = 0;
};

/// Checks the rules. It outlives each crash of the journal, and sees everything that the program has seen.
class Judge {
public:
    Received& of(DestinationId id) { return received_[id.index]; }

    void accepted(std::uint64_t sequence, std::uint32_t id) {
        open_.resize(std::max<std::size_t>(open_.size(), sequence + 1));
        open_[sequence] = id;
    }
    void rejected(std::uint64_t samples) { rejected_ += samples; }
    /// A cursor that cannot be written does not hold up the delivery: a mark may be missing after a crash.
    void disk_may_fail() { disk_failed_ = true; }

    void look(const Journal& journal) {
        const JournalStatus status = journal.status();
        EXPECT_GE(status.durable_sequence, durable_sequence_);
        durable_sequence_ = status.durable_sequence;
        for (; promised_ <= durable_sequence_ && promised_ < open_.size(); ++promised_)
            if (open_[promised_]) durable_.emplace_back(promised_, *open_[promised_]);
        for (const DestinationId id : {kFast, kSlow}) {
            const DestinationCounters c = journal.counters(id);
            EXPECT_EQ(c.appended, c.delivered + c.waiting + c.dropped);
            EXPECT_GE(journal.durable_cursor(id), of(id).durable_cursor);
            of(id).durable_cursor = journal.durable_cursor(id);
        }
    }
    /// A new run. A record that was not durable may be lost, also in front of later ones that survived.
    void restarted(const Journal& journal) {
        const std::uint64_t durable = journal.status().durable_sequence;
        EXPECT_GE(durable, durable_sequence_) << "a durable record is lost";
        open_.clear();
        promised_ = std::max(promised_, durable + 1);
        for (Received& received : received_) received.next = 0;
        look(journal);
    }

    void read(DestinationId id, const JournalEntry& entry) {
        Received& to = of(id);
        const std::uint64_t first = entry.gap ? entry.gap->first_sequence : entry.header.sequence;
        if (to.next != 0) {
            EXPECT_EQ(first, to.next) << "out of order";
        } else {
            EXPECT_LE(first, to.acknowledged + 1) << "skipped";
            EXPECT_GT(first, to.durable_cursor) << "delivered again after its acknowledgement was durable";
        }
        to.next = entry.header.sequence + 1;
        EXPECT_LE(entry.header.sequence, durable_sequence_) << "read before it was durable";
        if (entry.gap) return check_gap(to, entry);
        std::uint32_t sample = 0;
        std::memcpy(&sample, entry.payload.data(), sizeof sample);
        shown_.resize(std::max<std::size_t>(shown_.size(), first + 1));
        EXPECT_EQ(shown_[first].value_or(sample), sample) << "a sequence number was used again";
        if (!shown_[first]) durable_.emplace_back(first, sample);  // the other destination must get it too
        shown_[first] = sample;
        to.ids.resize(std::max<std::size_t>(to.ids.size(), sample + 1));
        EXPECT_TRUE(entry.repeated || !to.ids[sample] || disk_failed_) << "a repeat is not marked";
        to.ids[sample] = true;
    }

    void finish() {
        for (const Received& to : received_)
            for (const auto& [sequence, id] : durable_)
                EXPECT_TRUE(id < to.ids.size() && to.ids[id])
                    << "lost: sequence " << sequence << ", sample " << id;
    }
    [[nodiscard]] std::uint64_t rejected() const { return rejected_; }
    [[nodiscard]] std::size_t durable() const { return durable_.size(); }

private:
    void check_gap(Received& to, const JournalEntry& entry) {
        EXPECT_EQ(entry.gap->samples, entry.header.samples);
        EXPECT_LE(entry.gap->first_wall_ns, entry.gap->last_wall_ns);
        EXPECT_TRUE(entry.gap->cause != GapCause::restart || entry.gap->samples == 0);
        if (entry.gap->cause != GapCause::damaged) to.gap_samples += entry.gap->samples;
        for (const auto& [sequence, id] : durable_)
            EXPECT_FALSE(sequence >= entry.gap->first_sequence && sequence <= entry.gap->last_sequence)
                << "a durable record became a gap: " << sequence << ", sample " << id;
    }

    std::vector<std::optional<std::uint32_t>> open_;   // by sequence: accepted in this run
    std::vector<std::optional<std::uint32_t>> shown_;  // by sequence: seen by a destination
    std::vector<std::pair<std::uint64_t, std::uint32_t>> durable_;
    std::uint64_t promised_ = 1;
    std::uint64_t durable_sequence_ = 0;
    std::uint64_t rejected_ = 0;
    bool disk_failed_ = false;
    std::array<Received, 2> received_;
};

/// A program that appends, delivers and acknowledges, on a disk that may fail.
class Program {
public:
    explicit Program(Judge& judge) : judge_(judge) {}

    /// @returns whether the journal could be opened before the power went
    bool start(SimulatedDisk& disk) {
        disk_ = &disk;
        if (disk.fail_from >= 0) judge_.disk_may_fail();
        for (int attempt = 0; attempt < 40 && !disk.crashed(); ++attempt) {
            now_ += 100ms;
            auto opened = Journal::open(disk, small(), kNames, now_, wall());
            if (!opened) continue;
            journal_.emplace(*std::move(opened));
            judge_.restarted(*journal_);
            return true;
        }
        return false;
    }
    void stop() { journal_.reset(); }

    void work(int rounds) {
        for (int round = 0; round < rounds && !disk_->crashed(); ++round) {
            append();
            append();
            tick();
            deliver(kFast, 3, 1);
            if (round % 3 == 2) deliver(kSlow, 4, 2);
            if (round % 4 == 3) rewind(kFast);
        }
    }
    /// Delivers all. @returns the samples that were read, in records and in gaps
    /// The counters before are exact: they say what will be delivered and what is missing.
    std::uint64_t drain(DestinationId id) {
        for (int i = 0; i < 80; ++i) tick();
        rewind(id);
        std::uint64_t samples = 0;
        const DestinationCounters before = journal_->counters(id);
        while (auto entry = next(id)) {
            samples += entry->header.samples;
            acknowledge(id, entry->header.sequence);
        }
        const DestinationCounters after = journal_->counters(id);
        EXPECT_EQ(after.delivered, before.delivered + before.waiting);
        EXPECT_EQ(after.dropped, before.dropped);
        EXPECT_EQ(after.gaps, before.gaps);
        tick();
        return samples;
    }
    Journal& journal() { return *journal_; }
    void append() {
        std::vector<std::uint8_t> payload(kPayload, static_cast<std::uint8_t>(next_id_));
        std::memcpy(payload.data(), &next_id_, sizeof next_id_);
        const std::uint64_t samples = next_id_ % 3 + 1;
        if (journal_->append(now_, {samples, wall(), now_.time_since_epoch().count(), payload}))
            judge_.accepted(journal_->status().last_sequence, next_id_);
        else
            judge_.rejected(samples);
        ++next_id_;
        judge_.look(*journal_);
    }
    void tick() {
        now_ += 100ms;
        journal_->on_tick(now_, wall());
        judge_.look(*journal_);
    }

private:
    [[nodiscard]] std::int64_t wall() const { return 1'000'000 + now_.time_since_epoch().count(); }
    std::optional<JournalEntry> next(DestinationId id) {
        auto entry = journal_->read(id);
        if (!entry || !*entry || disk_->crashed()) return std::nullopt;
        judge_.read(id, **entry);
        return **entry;
    }
    void acknowledge(DestinationId id, std::uint64_t sequence) {
        EXPECT_TRUE(journal_->acknowledge(now_, id, sequence));
        judge_.of(id).acknowledged = std::max(judge_.of(id).acknowledged, sequence);
        judge_.look(*journal_);
    }
    /// Reads up to `count` entries and acknowledges all but the last `kept`.
    void deliver(DestinationId id, int count, std::size_t kept) {
        std::vector<std::uint64_t> sequences;
        for (int i = 0; i < count; ++i)
            if (const auto entry = next(id)) sequences.push_back(entry->header.sequence);
        if (sequences.size() > kept) acknowledge(id, sequences[sequences.size() - 1 - kept]);
    }
    void rewind(DestinationId id) {
        journal_->rewind(id);
        judge_.of(id).next = 0;
    }

    Judge& judge_;
    SimulatedDisk* disk_ = nullptr;
    std::optional<Journal> journal_;
    Instant now_{};
    std::uint32_t next_id_ = 0;
};

constexpr int kRounds = 9;

std::vector<std::pair<std::string, SimulatedDisk::Survival>> survivals() {
    return {
        {"nothing", {.piece = [](auto, auto, auto) { return 0; }, .last_create = false}},
        {"nothing, removed segments return",
         {.piece = [](auto, auto, auto) { return 0; }, .removed_return = true}},
        {"all", {.piece = [](auto, auto, auto size) { return size; }}},
        {"the first half, torn",
         {.piece = [](auto i, auto count,
                      auto size) { return i < count / 2    ? size
                                          : i == count / 2 ? size / 2
                                                           : 0; }}},
        {"the second half",
         {.piece = [](auto i, auto count, auto size) { return i >= count / 2 ? size : 0; }}},
        {"all but one sector",
         {.piece = [](auto i, auto count, auto size) { return i == count / 3 ? 0 : size; }}},
        {"every other sector", {.piece = [](auto i, auto, auto size) { return i % 2 == 0 ? 0 : size; }}},
        {"all sectors, torn",
         {.piece = [](auto, auto, auto size) { return size / 2; }, .removed_return = true}},
    };
}

/// Starts again on what the crash left, works on, and delivers everything.
void recover_and_check(Program& program, Judge& judge, SimulatedDisk& disk) {
    ASSERT_TRUE(program.start(disk));
    program.work(2);
    for (const DestinationId id : {kFast, kSlow}) {
        program.drain(id);
        EXPECT_EQ(program.journal().counters(id).waiting, 0U);
    }
    judge.finish();
}

int operations_of_a_run() {
    Judge judge;
    Program program(judge);
    SimulatedDisk disk;
    EXPECT_TRUE(program.start(disk));
    program.work(kRounds);
    EXPECT_GE(disk.contents().rbegin()->first, 4U) << "the run is too short for a change of segments";
    EXPECT_GE(disk.contents().begin()->first, 2U) << "no segment was removed";
    return disk.operations();
}

/// The program works until the disk stops it, and starts again with what survived.
void work_and_recover(SimulatedDisk& disk, const SimulatedDisk::Survival& survival) {
    Judge judge;
    Program program(judge);
    if (program.start(disk)) program.work(kRounds);
    program.stop();
    SimulatedDisk left = disk.after_crash(survival);
    recover_and_check(program, judge, left);
}

TEST(JournalCrash, LosesNothingDurableAtAnyOperation) {
    const int operations = operations_of_a_run();
    ASSERT_GT(operations, 30);
    for (const auto& [what, survival] : survivals())
        for (int crash = 0; crash < operations && !HasFailure(); ++crash) {
            SCOPED_TRACE(what + ", crash at operation " + std::to_string(crash));
            SimulatedDisk disk;
            disk.crash_at = crash;
            work_and_recover(disk, survival);
        }
}

TEST(JournalCrash, LosesNothingDurableInASecondCrashWhileItRecovers) {
    const int operations = operations_of_a_run();
    for (int variant = 0; const auto& [what, survival] : survivals())
        for (int crash = variant++; crash < operations && !HasFailure(); crash += 8)
            for (int second = 0; second < 12 && !HasFailure(); ++second) {
                SCOPED_TRACE(what + ", crash at " + std::to_string(crash) + " and " + std::to_string(second));
                Judge judge;
                Program program(judge);
                SimulatedDisk disk;
                disk.crash_at = crash;
                if (program.start(disk)) program.work(kRounds);
                program.stop();
                // The process is killed, the system goes on: it still has all pages, and may lose them now.
                SimulatedDisk killed = disk.after_kill();
                killed.crash_at = second;
                if (program.start(killed)) program.work(2);
                program.stop();
                SimulatedDisk left = killed.after_crash(survival);
                recover_and_check(program, judge, left);
            }
}

TEST(JournalCrash, LosesNothingAcceptedWhenAnyOperationFails) {
    const int operations = operations_of_a_run();
    for (const int count : {1, 2, 7})
        for (int failing = 0; failing < operations && !HasFailure(); ++failing) {
            SCOPED_TRACE(std::to_string(count) + " failures from operation " + std::to_string(failing));
            Judge judge;
            Program program(judge);
            SimulatedDisk disk;
            disk.fail_from = failing;
            disk.fail_count = count;
            disk.error_number = failing % 2 == 0 ? EIO : ENOSPC;
            ASSERT_TRUE(program.start(disk));
            program.work(kRounds);
            for (int i = 0; i < 80; ++i) program.tick();
            EXPECT_FALSE(program.journal().status().failure);
            EXPECT_EQ(program.journal().status().buffer_bytes, 0U);
            program.stop();
            SimulatedDisk left = disk.after_crash(survivals()[0].second);
            recover_and_check(program, judge, left);
            for (const DestinationId id : {kFast, kSlow})
                EXPECT_GE(judge.of(id).gap_samples, judge.rejected()) << "a loss without a gap";
        }
}

TEST(JournalCrash, LosesNothingDurableInACrashAfterAFailure) {
    const int operations = operations_of_a_run();
    for (int failing = 0; failing < operations; failing += 2)
        for (int crash = failing + 1; crash < std::min(operations + 10, failing + 16) && !HasFailure();
             ++crash) {
            const auto [what, survival] = survivals()[static_cast<std::size_t>(crash) % survivals().size()];
            SCOPED_TRACE(what + ", failure " + std::to_string(failing) + ", crash " + std::to_string(crash));
            SimulatedDisk disk;
            disk.fail_from = failing;
            disk.fail_count = 1;
            disk.crash_at = crash;
            work_and_recover(disk, survival);
        }
}

TEST(JournalCrash, CountsWhatIsWaitingExactly) {
    Judge judge;
    Program program(judge);
    SimulatedDisk disk;
    ASSERT_TRUE(program.start(disk));
    disk.fail_from = disk.operations();
    disk.fail_count = 12;
    disk.error_number = ENOSPC;
    program.work(kRounds);
    EXPECT_GT(judge.rejected(), 0U);
    for (const DestinationId id : {kFast, kSlow}) {
        const DestinationCounters before = program.journal().counters(id);
        EXPECT_EQ(before.dropped, judge.rejected());
        EXPECT_GE(program.drain(id), before.waiting);
        const DestinationCounters after = program.journal().counters(id);
        EXPECT_EQ(after.appended, before.appended);
        EXPECT_EQ(after.dropped, judge.rejected());
        EXPECT_EQ(after.waiting, 0U);
    }
}

}  // namespace journal_crash_test
}  // namespace takt::store
