// The sampler by hand: a host's engine in virtual time, and feeds with queues.
#include "takt/publish/sampler.hpp"

#include <gtest/gtest.h>

#include <map>

#include "projects.hpp"
#include "rig.hpp"

namespace takt::publish {
namespace sampler_test {

using namespace std::chrono_literals;
using host::test::boiler;
using host::test::line_of;
using host::test::project_with;

constexpr std::int64_t kWallOffset = 1'000'000'000'000;

class SamplerTest : public ::testing::Test, public SamplerOwner {
protected:
    std::vector<SampleFeed*> on_configuration(Instant now,
                                              const host::ConfigurationPtr& configuration) override {
        std::vector<SelectedSlot> all;
        for (std::uint32_t i = 0; i < configuration->slot_count(); ++i) all.push_back({{i}, policy_});
        feed_.emplace(series_of(*configuration), all, queue_, now);
        ++configured_;
        return {&*feed_};
    }
    void on_enqueued(std::size_t feed) override {
        EXPECT_EQ(feed, 0U);
        ++enqueued_;
    }
    void on_state_changed() override { ++states_; }

    void SetUp() override {
        rig_.link->on_posted = [this](const host::HostRequest&) { rig_.serve(); };
        session_ = rig_.open({.from_beginning = true});
        sampler_.emplace(
            *session_, *this, [](Instant t) { return t.time_since_epoch().count() + kWallOffset; }, rig_.now);
    }
    /// Runs the host; the sampler follows at each millisecond.
    void run(Duration length) {
        for (const Instant end = rig_.now + length; rig_.now < end;) {
            rig_.run(1ms);
            sampler_->step(rig_.now);
        }
    }
    std::vector<QueuedSamples> take() {
        std::vector<QueuedSamples> all;
        while (auto queued = queue_.take()) all.push_back(*std::move(queued));
        return all;
    }

    static std::size_t current_samples(const std::vector<QueuedSamples>& all) {
        std::size_t count = 0;
        for (const auto& queued : all) {
            const auto batch = decode_samples(queued.payload);
            EXPECT_TRUE(batch);
            for (const auto& sample : batch->samples) count += sample.cause == SampleCause::current ? 1 : 0;
        }
        return count;
    }

    host::test::Rig rig_{project_with(line_of("main", boiler()))};
    std::unique_ptr<host::Session> session_;
    SamplePolicy policy_;
    SampleQueue queue_{std::size_t{1} << 20};
    std::optional<SampleFeed> feed_;
    std::optional<Sampler> sampler_;
    int configured_ = 0;
    int enqueued_ = 0;
    int states_ = 0;
};

TEST_F(SamplerTest, CollectsTheChangesOfFiftyMilliseconds) {
    run(2s);
    EXPECT_EQ(configured_, 1);
    EXPECT_GE(states_, 1);
    EXPECT_EQ(enqueued_, 1) << "nothing was taken: the queue was empty once";
    std::int64_t last = 0;
    for (const auto& queued : take()) {
        const auto batch = decode_samples(queued.payload);
        ASSERT_TRUE(batch);
        EXPECT_EQ(batch->samples.size(), queued.samples);
        EXPECT_GE(queued.first_wall_ns, kWallOffset);
        EXPECT_GE(queued.last_wall_ns, last);
        last = queued.last_wall_ns;
    }
    EXPECT_GT(last, kWallOffset + 2'000'000'000);
}

TEST_F(SamplerTest, CountsLostEventsInTheirPlaceAndDeliversTheCurrentState) {
    run(1s);
    (void)take();
    const auto lost_before = session_->missed_events();
    const auto events = static_cast<std::uint64_t>(host::test::Rig::kRingWords);
    for (std::uint64_t i = 0; i < events; ++i) rig_.engine->publish_event(rig_.now, host::LinkChanged{});
    sampler_->step(rig_.now);
    const auto lost = session_->missed_events() - lost_before;
    ASSERT_GT(lost, 0U);
    run(60ms);
    const auto queued = take();
    ASSERT_GE(queued.size(), 2U);
    EXPECT_TRUE(queued[0].payload.empty());
    EXPECT_EQ(queued[0].samples, lost);
    EXPECT_EQ(current_samples({queued[1]}), 2U) << "Level and Setpoint";
}

TEST_F(SamplerTest, ALossIsBeforeTheEventsThatFollowIt) {
    run(1s);
    (void)take();
    const Instant last_read = rig_.now;
    rig_.run(1s);  // these are lost
    const auto events = static_cast<std::uint64_t>(host::test::Rig::kRingWords);
    for (std::uint64_t i = 0; i < events; ++i) rig_.engine->publish_event(rig_.now, host::LinkChanged{});
    const Instant lost_until = rig_.now;
    rig_.run(1s);
    sampler_->step(rig_.now);
    const auto queued = take();
    ASSERT_GE(queued.size(), 2U);
    EXPECT_TRUE(queued[0].payload.empty());
    const auto wall = [](Instant t) { return t.time_since_epoch().count() + kWallOffset; };
    EXPECT_GT(queued[0].first_wall_ns, wall(last_read) - 200'000'000);
    EXPECT_LE(queued[0].first_wall_ns, wall(last_read));
    EXPECT_EQ(queued[0].last_wall_ns, wall(lost_until));
    EXPECT_GT(queued[1].first_wall_ns, wall(lost_until) - 200'000'000);
    EXPECT_GT(queued[1].samples, 2U) << "the changes of a second";
}

TEST_F(SamplerTest, DeliversRetainedValuesAgainOnRequest) {
    policy_.retained = true;
    run(1s);
    (void)take();
    queue_.request_retained();
    EXPECT_LE(sampler_->next_wakeup(), rig_.now);
    run(1s);
    EXPECT_EQ(current_samples(take()), 2U) << "once: Level and Setpoint";
    EXPECT_FALSE(queue_.retained_requested());
}

TEST_F(SamplerTest, TriesAgainWhenThereIsNoSnapshot) {
    rig_.run(1s);
    rig_.link->stopped = true;
    sampler_->step(rig_.now);
    EXPECT_EQ(current_samples(take()), 0U);
    rig_.link->stopped = false;
    const Instant begin = rig_.now;
    for (std::size_t current = 0; current == 0; current = current_samples(take())) {
        ASSERT_LE(sampler_->next_wakeup(), begin + 1s);
        rig_.now = sampler_->next_wakeup();
        sampler_->step(rig_.now);
    }
    EXPECT_EQ(rig_.now, begin + 1s);
}

TEST_F(SamplerTest, FinishesWithoutWaiting) {
    rig_.run(1s);
    sampler_->step(rig_.now);
    (void)take();
    rig_.run(300ms);
    sampler_->finish(rig_.now);
    EXPECT_FALSE(take().empty());
    EXPECT_EQ(sampler_->next_wakeup(), kNever);
}

}  // namespace sampler_test
}  // namespace takt::publish
