// The outputs of a running host, with a real journal and a destination in memory.
#include "takt/publish/outputs.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <condition_variable>
#include <map>
#include <mutex>
#include <set>

#include "folder.hpp"
#include "projects.hpp"
#include "running_host.hpp"
#include "takt/publish/sample_codec.hpp"

namespace takt::publish {
namespace outputs_test {

using namespace std::chrono_literals;
using host::test::boiler;
using host::test::line_of;
using host::test::project_with;
using host::test::pump;

const std::string kPlant = project_with(line_of("main", boiler() + pump(), "tcp"));

/// What a destination received, for the test's thread.
class Received {
public:
    struct Item {
        std::string variable;  ///< empty: a gap
        Sample sample;
        std::uint64_t sequence = 0;
        std::uint64_t epoch = 0;
        store::GapCause cause{};
    };
    void add(Item item) {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return !held_; });
        items_.push_back(std::move(item));
        changed_.notify_all();
    }
    std::vector<Item> wait_for(std::size_t count) {
        std::unique_lock lock(mutex_);
        changed_.wait_for(lock, 30s, [&] { return items_.size() >= count; });
        return items_;
    }
    std::vector<Item> all() { return wait_for(0); }
    /// While it is held, the thread of the output does not return.
    void hold(bool held) {
        const std::lock_guard lock(mutex_);
        held_ = held;
        changed_.notify_all();
    }

private:
    std::mutex mutex_;
    std::condition_variable changed_;
    std::vector<Item> items_;
    bool held_ = false;
};

class MemoryWork final : public OutputWork {
public:
    MemoryWork(std::shared_ptr<Received> received, std::shared_ptr<std::atomic<bool>> away)
        : received_(std::move(received)), away_(std::move(away)) {}

    void begin(Instant, store::Journal& journal, store::DestinationId destination) override {
        journal_ = &journal;
        destination_ = destination;
    }
    void work(Instant now) override {
        while (!*away_) {
            const auto entry = journal_->read(destination_);
            ASSERT_TRUE(entry);
            if (!*entry) return;
            take(**entry);
            ASSERT_TRUE(journal_->acknowledge(now, destination_, (*entry)->header.sequence));
        }
    }
    [[nodiscard]] Instant next_wakeup() const override { return kNever; }
    [[nodiscard]] std::span<const int> descriptors() const override { return {}; }
    void on_state_changed(Instant) override { ++states_; }
    [[nodiscard]] bool takes_records() const override { return !*away_; }
    void stop(Instant) override { stopped_ = true; }
    [[nodiscard]] bool stopped() const override { return stopped_; }
    void report(Instant, OutputStatus& status) const override { status.state = OutputState::delivering; }

private:
    void take(const store::JournalEntry& entry) {
        if (entry.gap) return received_->add({.sequence = entry.header.sequence, .cause = entry.gap->cause});
        const auto batch = decode_samples(entry.payload);
        ASSERT_TRUE(batch);
        for (std::size_t i = 0; i < batch->samples.size(); ++i)
            received_->add({.variable = batch->series[batch->samples[i].series].variable,
                            .sample = batch->samples[i],
                            .sequence = entry.header.samples_before + 1 + i,
                            .epoch = entry.header.epoch});
    }

    std::shared_ptr<Received> received_;
    std::shared_ptr<std::atomic<bool>> away_;
    store::Journal* journal_ = nullptr;
    store::DestinationId destination_;
    int states_ = 0;
    bool stopped_ = false;
};

class OutputsTest : public ::testing::Test {
protected:
    void start(const SamplePolicy& policy = {}) {
        host_ = host::test::started(kPlant);
        ASSERT_TRUE(host_);
        outputs_.emplace(*host_->open_session({.from_beginning = true}),
                         [this, policy](const host::ConfigurationPtr& configuration) {
                             ++configured_;
                             return removed_ ? std::vector<OutputSetup>() : setups(*configuration, policy);
                         });
    }
    std::vector<OutputSetup> setups(const host::Configuration& configuration, const SamplePolicy& policy) {
        std::vector<SelectedSlot> all;
        for (std::uint32_t i = 0; i < configuration.slot_count(); ++i) all.push_back({{i}, policy});
        std::vector<OutputSetup> setups;
        setups.push_back({.settings = std::to_string(settings_),
                          .thread = {.name = "cloud", .directory = folder_ / "journal/cloud", .journal = {}},
                          .selected = all,
                          .make_work = [this] { return std::make_unique<MemoryWork>(received_, away_); }});
        return setups;
    }
    void stop() {
        host_->stop();
        outputs_->stop();
    }
    /// Of the only output; the default before its thread has begun.
    [[nodiscard]] OutputStatus status() const {
        const auto all = outputs_->status();
        return all.empty() ? OutputStatus{} : all[0];
    }
    void expect_conserved() const {
        for (const auto& status : outputs_->status())
            EXPECT_EQ(status.samples.sampled,
                      status.samples.delivered + status.samples.waiting + status.samples.dropped);
    }

    takt::test::Folder folder_;
    std::shared_ptr<Received> received_ = std::make_shared<Received>();
    std::shared_ptr<std::atomic<bool>> away_ = std::make_shared<std::atomic<bool>>(false);
    std::atomic<int> configured_ = 0;
    std::atomic<bool> removed_ = false;  // the output, with the next configuration
    std::atomic<int> settings_ = 1;      // of the output, with the next configuration
    std::unique_ptr<host::ProjectHost> host_;
    std::optional<Outputs> outputs_;
};

TEST_F(OutputsTest, EveryChangeIsDeliveredInOrder) {
    start();
    const auto items = received_->wait_for(30);
    for (int i = 0; i < 100; ++i) expect_conserved();
    stop();
    expect_conserved();
    ASSERT_GE(items.size(), 30U);
    EXPECT_EQ(items[0].cause, store::GapCause::restart);
    std::set<std::string> variables;
    for (std::size_t i = 1; i < items.size(); ++i) {
        EXPECT_EQ(items[i].sequence, i);
        EXPECT_EQ(items[i].epoch, items[1].epoch);
        variables.insert(items[i].variable);
        if (items[i].sample.previous_wall_ns) {
            EXPECT_LT(*items[i].sample.previous_wall_ns, items[i].sample.wall_ns);
        }
    }
    EXPECT_TRUE(variables.contains("Level"));
    EXPECT_TRUE(variables.contains("Speed"));
    const auto status = outputs_->status();
    ASSERT_EQ(status.size(), 1U);
    EXPECT_EQ(status[0].state, OutputState::ended);
    EXPECT_EQ(status[0].name, "cloud");
}

TEST_F(OutputsTest, WhatWaitsAtTheEndIsDeliveredAfterARestart) {
    *away_ = true;
    start();
    for (int i = 0; i < 3000 && status().samples.waiting < 10; ++i) std::this_thread::sleep_for(10ms);
    stop();
    const auto before = outputs_->status().at(0);
    EXPECT_GE(before.samples.waiting, 10U);
    EXPECT_EQ(before.samples.delivered, 0U);
    EXPECT_TRUE(before.oldest_waiting_ns);
    outputs_.reset();

    *away_ = false;
    start();
    const auto items = received_->wait_for(before.samples.waiting + 10);
    stop();
    std::uint64_t next = 1;
    std::size_t restarts = 0;
    for (const auto& item : items) {
        if (item.variable.empty()) {
            ++restarts;
            EXPECT_EQ(item.cause, store::GapCause::restart);
            continue;
        }
        EXPECT_EQ(item.sequence, next++);
        const auto first = before.journal.epoch;
        EXPECT_EQ(item.epoch, item.sequence <= before.samples.sampled ? first : first + 1);
    }
    EXPECT_EQ(restarts, 2U);
    expect_conserved();
}

TEST_F(OutputsTest, APeriodGivesSamplesOfUnchangedValues) {
    start({.on_change = false, .period = 100ms});
    const auto items = received_->wait_for(20);
    stop();
    std::map<std::string, std::size_t> periods;
    for (const auto& item : items)
        if (!item.variable.empty() && item.sample.cause == SampleCause::period) ++periods[item.variable];
    EXPECT_EQ(periods.size(), 3U);
    for (const auto& [variable, count] : periods) EXPECT_GE(count, 3U) << variable;
}

TEST_F(OutputsTest, AnOutputContinuesOverAChangeOfTheProject) {
    start();
    ASSERT_GE(received_->wait_for(10).size(), 10U);
    auto project = host::test::project_of(project_with(line_of("main", boiler(), "tcp")));
    auto plan = plan::make_plan(project);
    ASSERT_TRUE(host_->apply(std::move(project), std::move(plan)));
    for (int i = 0; i < 3000 && configured_ < 2; ++i) std::this_thread::sleep_for(10ms);
    const auto so_far = received_->all().size();
    const auto items = received_->wait_for(so_far + 20);
    stop();
    expect_conserved();
    // One gap only: the journal was not opened again.
    EXPECT_EQ(std::ranges::count(items, std::string(), &Received::Item::variable), 1);
    EXPECT_EQ(items.back().variable.find("Speed"), std::string::npos);
}

// "The program was not running" would be wrong.
TEST_F(OutputsTest, AnOutputWithOtherSettingsReplacesTheRunningOne) {
    start();
    ASSERT_GE(received_->wait_for(10).size(), 10U);
    settings_ = 2;
    auto project = host::test::project_of(kPlant);
    auto plan = plan::make_plan(project);
    ASSERT_TRUE(host_->apply(std::move(project), std::move(plan)));
    for (int i = 0; i < 3000 && configured_ < 2; ++i) std::this_thread::sleep_for(10ms);
    const auto items = received_->wait_for(received_->all().size() + 20);
    stop();
    std::vector<store::GapCause> causes;
    for (const auto& item : items)
        if (item.variable.empty()) causes.push_back(item.cause);
    EXPECT_EQ(causes, (std::vector{store::GapCause::restart, store::GapCause::replaced}));
}

TEST_F(OutputsTest, ARemovedOutputWithSamplesThatWaitIsReported) {
    *away_ = true;
    start();
    for (int i = 0; i < 3000 && status().samples.waiting < 5; ++i) std::this_thread::sleep_for(10ms);
    const auto apply = [&](bool removed) {
        removed_ = removed;
        auto project = host::test::project_of(kPlant);
        auto plan = plan::make_plan(project);
        ASSERT_TRUE(host_->apply(std::move(project), std::move(plan)));
    };
    apply(true);
    for (int i = 0; i < 3000 && status().state != OutputState::removed; ++i)
        std::this_thread::sleep_for(10ms);
    EXPECT_EQ(status().state, OutputState::removed);
    EXPECT_EQ(status().name, "cloud");
    EXPECT_GE(status().samples.waiting, 5U);
    EXPECT_EQ(status().destination, folder_ / "journal/cloud");
    *away_ = false;
    apply(false);
    for (int i = 0; i < 3000 && status().state != OutputState::delivering; ++i)
        std::this_thread::sleep_for(10ms);
    EXPECT_EQ(outputs_->status().size(), 1U);
    EXPECT_EQ(status().state, OutputState::delivering);
    stop();
}

// A work that does not return stands for a disk that does not answer.
TEST_F(OutputsTest, ADiskThatHangsIsReportedWhileItHangs) {
    start();
    ASSERT_GE(received_->wait_for(1).size(), 1U);
    EXPECT_EQ(status().disk_waits, Duration{});
    received_->hold(true);
    for (int i = 0; i < 3000 && status().disk_waits == Duration{}; ++i) std::this_thread::sleep_for(10ms);
    EXPECT_GE(status().disk_waits, 2s);
    received_->hold(false);
    for (int i = 0; i < 3000 && status().disk_waits > Duration{}; ++i) std::this_thread::sleep_for(10ms);
    EXPECT_EQ(status().disk_waits, Duration{});
    stop();
}

TEST_F(OutputsTest, ADirectoryThatCannotBeUsedIsReportedAndSamplesWait) {
    folder_.write("journal", "a file, no directory");
    start();
    OutputStatus seen = status();
    for (int i = 0; i < 3000 && (seen.samples.waiting < 5 || !seen.journal_failure); ++i) {
        std::this_thread::sleep_for(10ms);
        seen = status();
    }
    EXPECT_GE(seen.samples.waiting, 5U);
    ASSERT_TRUE(seen.journal_failure);
    EXPECT_EQ(seen.journal_failure->code, Code::cannot_open);
    expect_conserved();
    stop();
}

}  // namespace outputs_test
}  // namespace takt::publish
