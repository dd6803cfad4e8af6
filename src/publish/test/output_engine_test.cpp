// The engine of an output by hand: a journal on a simulated disk, a destination in memory.
#include "takt/publish/output_engine.hpp"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "simulated_disk.hpp"

namespace takt::publish {
namespace output_engine_test {

using namespace std::chrono_literals;

/// A destination that takes records while it is there.
class Destination final : public OutputWork {
public:
    Destination(const bool& there, const bool& silent) : there_(there), silent_(silent) {}

    void begin(Instant, store::Journal& journal, store::DestinationId destination) override {
        journal_ = &journal;
        destination_ = destination;
    }
    void work(Instant now) override {
        while (there_ && !silent_) {
            const auto entry = journal_->read(destination_);
            ASSERT_TRUE(entry);
            if (!*entry) return;
            ASSERT_TRUE(journal_->acknowledge(now, destination_, (*entry)->header.sequence));
        }
    }
    [[nodiscard]] Instant next_wakeup() const override { return kNever; }
    [[nodiscard]] std::span<const int> descriptors() const override { return {}; }
    void on_state_changed(Instant) override {}
    [[nodiscard]] bool takes_records() const override { return there_; }
    void stop(Instant) override { stopped_ = true; }
    [[nodiscard]] bool stopped() const override { return stopped_; }
    void report(Instant, OutputStatus& status) const override { status.state = OutputState::delivering; }

private:
    const bool& there_;
    const bool& silent_;
    store::Journal* journal_ = nullptr;
    store::DestinationId destination_;
    bool stopped_ = false;
};

class OutputEngineTest : public ::testing::Test {
protected:
    /// The disk as a storage that the engine may own.
    class Storage final : public store::JournalStorage {
    public:
        explicit Storage(store::test::SimulatedDisk& disk) : disk_(disk) {}
        Result<std::vector<store::SegmentFile>> list_segments() override { return disk_.list_segments(); }
        Result<std::size_t> read(std::uint64_t s, std::uint64_t at, std::span<std::uint8_t> into) override {
            return disk_.read(s, at, into);
        }
        Result<std::uint64_t> create(std::uint64_t s) override { return disk_.create(s); }
        Result<void> append(std::uint64_t s, Bytes bytes) override { return disk_.append(s, bytes); }
        Result<void> sync(std::uint64_t s) override { return disk_.sync(s); }
        Result<void> remove(std::uint64_t s) override { return disk_.remove(s); }
        Result<std::size_t> read_cursor(std::string_view d, unsigned s,
                                        std::span<std::uint8_t> into) override {
            return disk_.read_cursor(d, s, into);
        }
        Result<void> write_cursor(std::string_view d, unsigned s, Bytes bytes) override {
            return disk_.write_cursor(d, s, bytes);
        }
        Result<void> sync_cursor(std::string_view d) override { return disk_.sync_cursor(d); }
        Result<std::size_t> read_end(unsigned s, std::span<std::uint8_t> into) override {
            return disk_.read_end(s, into);
        }
        Result<void> write_end(unsigned s, Bytes bytes) override { return disk_.write_end(s, bytes); }
        Result<void> sync_end() override { return disk_.sync_end(); }

    private:
        store::test::SimulatedDisk& disk_;
    };

    void SetUp() override {
        OutputEngine::Options options;
        options.name = "cloud";
        options.queue_bytes = 1000;
        options.open_storage = [this]() -> Result<std::unique_ptr<store::JournalStorage>> {
            ++opens_;
            if (no_disk_) return fail(Code::cannot_open, "cloud", ENOENT);
            return std::make_unique<Storage>(disk_);
        };
        options.wall_ns = [](Instant t) { return t.time_since_epoch().count(); };
        engine_.emplace(std::move(options), std::make_unique<Destination>(there_, silent_));
    }

    /// Advances the time in steps of the engine's wake-ups.
    void run(Duration length) {
        const Instant end = now_ + length;
        step();
        while (engine_->next_wakeup() <= end) {
            now_ = std::max(now_, engine_->next_wakeup());
            step();
            if (engine_->finished(now_)) return;
        }
        now_ = end;
    }
    void step() {
        engine_->step(now_);
        expect_conserved();
    }
    void push(std::size_t bytes = 20) {
        engine_->queue().push({.payload = std::vector<std::uint8_t>(bytes, 1),
                               .samples = 2,
                               .first_wall_ns = 1,
                               .last_wall_ns = 2,
                               .last_monotonic_ns = 0});
        expect_conserved();
    }
    void expect_conserved() const {
        const auto samples = engine_->status().samples;
        EXPECT_EQ(samples.sampled, samples.delivered + samples.waiting + samples.dropped);
    }
    [[nodiscard]] OutputSamples samples() const { return engine_->status().samples; }

    store::test::SimulatedDisk disk_;
    bool no_disk_ = false;
    bool there_ = true;    // the destination takes records
    bool silent_ = false;  // it acknowledges none
    int opens_ = 0;
    Instant now_{1000s};
    std::optional<OutputEngine> engine_;
};

TEST_F(OutputEngineTest, DeliversWhatIsDurable) {
    push();
    step();
    EXPECT_EQ(samples().delivered, 0U);
    run(1s);
    EXPECT_EQ(samples().sampled, 2U);
    EXPECT_EQ(samples().delivered, 2U);
}

TEST_F(OutputEngineTest, CountsQueuedSamplesWhileTheStorageCannotBeOpened) {
    no_disk_ = true;
    push();
    run(11s);
    EXPECT_EQ(opens_, 3);
    EXPECT_EQ(samples().waiting, 2U);
    ASSERT_TRUE(engine_->status().journal_failure);
    EXPECT_EQ(engine_->status().journal_failure->code, Code::cannot_open);
    push(2000);  // more than the queue holds
    EXPECT_EQ(samples().waiting, 2U);
    EXPECT_EQ(samples().dropped, 2U) << "known before the journal is open";
    EXPECT_EQ(engine_->status().gaps, 1U);
    no_disk_ = false;
    run(10s);
    EXPECT_EQ(samples().sampled, 4U);
    EXPECT_EQ(samples().delivered, 2U);
    EXPECT_EQ(samples().dropped, 2U);
    EXPECT_EQ(engine_->status().gaps, 1U);
    EXPECT_FALSE(engine_->status().journal_failure);
}

TEST_F(OutputEngineTest, ReportsTheOldestSampleThatWaits) {
    there_ = false;
    run(1s);
    EXPECT_FALSE(engine_->status().oldest_waiting_ns);
    push();
    run(2s);
    EXPECT_EQ(engine_->status().oldest_waiting_ns, 2);
}

TEST_F(OutputEngineTest, StopsWithTheQueueOnTheDiskAndDelivered) {
    run(1s);
    push();
    engine_->stop();
    run(10s);
    EXPECT_TRUE(engine_->finished(now_));
    engine_->close(now_);
    expect_conserved();
    EXPECT_EQ(samples().delivered, 2U);
    EXPECT_EQ(engine_->status().state, OutputState::ended);
}

TEST_F(OutputEngineTest, DeliversAtTheEndHoweverLongTheDiskTook) {
    run(1s);
    push();
    silent_ = true;  // the acknowledgement is under way while the disk works
    engine_->stop();
    step();
    now_ += 3s;  // the last synchronisation of the journal
    step();
    EXPECT_FALSE(engine_->finished(now_));
    silent_ = false;
    run(10s);
    EXPECT_TRUE(engine_->finished(now_));
    EXPECT_EQ(samples().delivered, 2U);
}

TEST_F(OutputEngineTest, StopsInTimeWithoutItsDestination) {
    there_ = false;
    run(1s);
    push();
    engine_->stop();
    const Instant begin = now_;
    run(10s);
    EXPECT_TRUE(engine_->finished(now_));
    EXPECT_LE(now_ - begin, 2s);
    engine_->close(now_);
    EXPECT_EQ(samples().waiting, 2U);
    EXPECT_EQ(engine_->status().journal.durable_sequence, engine_->status().journal.last_sequence);
}

TEST_F(OutputEngineTest, StopsAtOnceWithoutAStorage) {
    no_disk_ = true;
    push();
    engine_->stop();
    step();
    EXPECT_TRUE(engine_->finished(now_));
    engine_->close(now_);
    EXPECT_EQ(samples().waiting, 2U);
}

}  // namespace output_engine_test
}  // namespace takt::publish
