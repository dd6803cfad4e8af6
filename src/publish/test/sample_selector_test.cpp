#include "takt/publish/sample_selector.hpp"

#include <gtest/gtest.h>

#include <chrono>

namespace takt::publish {
namespace sample_selector_test {

using namespace std::chrono_literals;
using value::Quality;
using value::Value;

constexpr Instant at(Duration since) {
    return Instant(since);
}

class Selector : public ::testing::Test {
protected:
    void begin(const SamplePolicy& policy) {
        selector_.emplace(std::vector<SelectedSlot>{{{1}, policy}}, at(0s));
    }

    void change(Duration t, Value value, Quality quality = Quality::good,
                value::Reason reason = value::Reason::ok) {
        auto& slot = snapshot_.values[1];
        const auto before = slot.good_at;
        slot.value = std::move(value);
        slot.quality = quality;
        slot.reason = reason;
        if (quality == Quality::good) slot.good_at = at(t);
        selector_->on_change({.number = snapshot_.first_newer_event++, .t = at(t)},
                             {.slot = {1},
                              .value = slot.value,
                              .quality = quality,
                              .reason = reason,
                              .good_at = slot.good_at,
                              .good_before = before},
                             sink());
    }
    void read_again(Duration t) { snapshot_.values[1].good_at = at(t); }
    void snapshot(Duration t) { selector_->on_snapshot(copy(t), sink()); }
    const host::Snapshot& copy(Duration t) {
        snapshot_.t = at(t);
        return snapshot_;
    }

    [[nodiscard]] SampleSelector::Sink sink() {
        return [this](const SelectedSample& sample) { samples_.push_back(sample); };
    }
    std::vector<SelectedSample> take() { return std::exchange(samples_, {}); }

    std::optional<SampleSelector> selector_;
    host::Snapshot snapshot_{.values = std::vector<value::Slot>(3)};
    std::vector<SelectedSample> samples_;
};

TEST_F(Selector, AChangeHasItsInterval) {
    begin({});
    change(1s, 1.0);
    read_again(2s);
    change(3s, 2.0);
    const auto samples = take();
    ASSERT_EQ(samples.size(), 2U);
    EXPECT_EQ(samples[0].previous, std::nullopt);
    EXPECT_EQ(samples[1].at, at(3s));
    EXPECT_EQ(samples[1].previous, at(2s));
    EXPECT_EQ(samples[1].cause, SampleCause::change);
    EXPECT_EQ(selector_->next_due(), kNever);
}

TEST_F(Selector, ABadValueHasItsLastGoodRead) {
    begin({.heartbeat = 10s});
    change(1s, 1.0);
    read_again(2s);
    change(3s, 1.0, Quality::bad, value::Reason::timeout);
    snapshot(13s);
    const auto samples = take();
    ASSERT_EQ(samples.size(), 3U);
    EXPECT_EQ(samples[1].at, at(3s));
    EXPECT_EQ(samples[1].previous, at(2s));
    EXPECT_EQ(samples[2].cause, SampleCause::heartbeat);
    EXPECT_EQ(samples[2].previous, at(2s));
}

TEST_F(Selector, OtherSlotsAreNotDelivered) {
    begin({});
    for (const std::uint32_t slot : {0U, 2U, 99U})
        selector_->on_change({.t = at(1s)}, {.slot = {slot}, .value = 1.0}, sink());
    EXPECT_TRUE(take().empty());
}

TEST_F(Selector, ADeadBandComparesWithTheLastSample) {
    begin({.dead_band = 1});
    const struct {
        double value;
        bool delivered;
    } steps[] = {{5, true}, {5.9, false}, {6, false}, {6.1, true}, {5.2, false}, {5.0, true}};
    for (const auto& [value, delivered] : steps) {
        change(1s, value);
        EXPECT_EQ(take().size(), delivered ? 1U : 0U) << value;
    }
    change(2s, 5.0, Quality::uncertain, value::Reason::timeout);
    EXPECT_EQ(take().size(), 1U);
}

TEST_F(Selector, ABadValueHasTheTimeOfItsQuality) {
    begin({});
    change(1s, 5.0);
    change(4s, 5.0, Quality::uncertain, value::Reason::timeout);
    const auto samples = take();
    ASSERT_EQ(samples.size(), 2U);
    EXPECT_EQ(samples[1].at, at(4s));
    EXPECT_EQ(samples[1].previous, at(1s));
    EXPECT_EQ(samples[1].reason, value::Reason::timeout);
}

TEST_F(Selector, BadValuesCanBeSkipped) {
    begin({.heartbeat = 10s, .skip_bad = true});
    change(1s, 5.0);
    EXPECT_EQ(take().size(), 1U);
    change(2s, 5.0, Quality::bad, value::Reason::not_answering);
    snapshot(11s);  // the heartbeat, of a bad value
    EXPECT_TRUE(take().empty());
    change(12s, 5.0);  // the same value again: no change for the output
    EXPECT_TRUE(take().empty());
    change(13s, 6.0);
    EXPECT_EQ(take().size(), 1U);
}

TEST_F(Selector, APeriodDoesNotDriftAndHasTheTimeOfTheRead) {
    begin({.on_change = false, .period = 10s});
    change(1s, 1.0);
    EXPECT_TRUE(take().empty());
    EXPECT_EQ(selector_->next_due(), at(10s));
    read_again(9s);
    snapshot(10s + 300ms);
    auto samples = take();
    ASSERT_EQ(samples.size(), 1U);
    EXPECT_EQ(samples[0].at, at(9s));
    EXPECT_EQ(samples[0].cause, SampleCause::period);
    EXPECT_EQ(selector_->next_due(), at(20s));
    snapshot(45s);  // two were missed
    EXPECT_EQ(take().size(), 1U);
    EXPECT_EQ(selector_->next_due(), at(50s));
}

TEST_F(Selector, AHeartbeatFollowsTheLastSample) {
    begin({.heartbeat = 10s});
    change(1s, 1.0);
    change(8s, 2.0);
    take();
    EXPECT_EQ(selector_->next_due(), at(10s));
    snapshot(10s);  // of the first sample: it moved
    EXPECT_TRUE(take().empty());
    EXPECT_EQ(selector_->next_due(), at(18s));
    read_again(17s);
    snapshot(18s);
    const auto samples = take();
    ASSERT_EQ(samples.size(), 1U);
    EXPECT_EQ(samples[0].cause, SampleCause::heartbeat);
    EXPECT_EQ(samples[0].at, at(17s));
    EXPECT_EQ(selector_->next_due(), at(28s));
}

TEST_F(Selector, NothingIsDeliveredOfAValueThatWasNeverRead) {
    begin({.period = 1s, .heartbeat = 2s});
    for (const auto t : {1s, 2s, 3s, 4s}) snapshot(t);
    selector_->deliver_current(copy(5s), sink());
    EXPECT_TRUE(take().empty());
}

// The event has the time at which the bytes arrived, which may be before the copy began.
TEST_F(Selector, ASnapshotThatIsOlderThanAnEventDoesNotTurnBack) {
    for (const auto changed : {9500ms, 11000ms}) {
        begin({.period = 10s});
        change(9s, 1.0);
        auto older = copy(10s);
        change(changed, 2.0);
        take();
        selector_->on_snapshot(older, sink());
        selector_->deliver_current(older, sink());
        const auto samples = take();
        ASSERT_EQ(samples.size(), 2U);
        for (const auto& sample : samples) {
            EXPECT_EQ(sample.value, Value(2.0));
            EXPECT_EQ(sample.at, at(changed));
        }
    }
}

TEST_F(Selector, TheCurrentStateIsDeliveredOnRequest) {
    begin({.dead_band = 5});
    change(1s, 1.0);
    take();
    snapshot_.values[1].value = 2.0;  // an event of this change was lost
    selector_->deliver_current(copy(2s), sink());
    const auto samples = take();
    ASSERT_EQ(samples.size(), 1U);
    EXPECT_EQ(samples[0].value, Value(2.0));
    EXPECT_EQ(samples[0].cause, SampleCause::current);
}

TEST_F(Selector, OnlyRetainedValuesAreDeliveredToADestinationThatHasLostThem) {
    for (const bool retained : {false, true}) {
        begin({.retained = retained});
        change(1s, 1.0);
        take();
        selector_->deliver_current(copy(2s), sink(), true);
        EXPECT_EQ(take().size(), retained ? 1U : 0U);
    }
}

}  // namespace sample_selector_test
}  // namespace takt::publish
