#include "takt/value/store.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <array>

namespace takt::value {
namespace store_test {

using namespace std::chrono_literals;

constexpr Instant at(Duration since_start) {
    return Instant{} + since_start;
}

Store small_store(std::size_t events = 8) {
    return Store({{.name = "pressure", .type = DataType::float32, .dead_band = 0.5},
                  {.name = "alarm", .type = DataType::boolean, .initial = false},
                  {.name = "go", .type = DataType::boolean, .local = true, .initial = false}},
                 events);
}

TEST(Store, BeginsWithDefaultsThatWereNeverRead) {
    const auto store = small_store();
    EXPECT_EQ(store.find("alarm"), SlotId{1});
    EXPECT_FALSE(store.find("alar"));
    EXPECT_TRUE(is_empty(store[SlotId{0}].value));
    EXPECT_EQ(store[SlotId{1}].value, Value(false));
    EXPECT_EQ(store[SlotId{1}].quality, Quality::never_read);
    EXPECT_EQ(store[SlotId{2}].quality, Quality::good);
    EventCursor cursor;
    EXPECT_EQ(store.next_event(cursor), nullptr);
}

TEST(Store, MembersOfARequestChangeTogether) {
    auto store = small_store();
    const std::array<Update, 2> read{Update{SlotId{0}, 1.0}, Update{SlotId{1}, true}};
    store.apply(at(5ms), read);
    EXPECT_EQ(store[SlotId{0}].batch, store[SlotId{1}].batch);
    EXPECT_EQ(store[SlotId{0}].good_at, at(5ms));
    EventCursor cursor;
    const auto* first = store.next_event(cursor);
    ASSERT_NE(first, nullptr);
    EXPECT_EQ(first->value, Value(1.0));
    const auto* second = store.next_event(cursor);
    ASSERT_NE(second, nullptr);
    EXPECT_EQ(second->batch, 1U);
    EXPECT_EQ(second->sequence, 2U);
    EXPECT_EQ(store.next_event(cursor), nullptr);
}

TEST(Store, AnEventHasTheReadBeforeTheChange) {
    auto store = small_store();
    const std::array<Update, 1> first{Update{SlotId{0}, 1.0}};
    const std::array<Update, 1> other{Update{SlotId{0}, 2.0}};
    store.apply(at(5ms), first);
    store.apply(at(10ms), first);  // the same value: no event
    store.apply(at(15ms), other);
    EventCursor cursor;
    const auto* event = store.next_event(cursor);
    ASSERT_NE(event, nullptr);
    EXPECT_EQ(event->good_at, at(5ms));
    EXPECT_EQ(event->good_before, std::nullopt);
    event = store.next_event(cursor);
    ASSERT_NE(event, nullptr);
    EXPECT_EQ(event->good_at, at(15ms));
    EXPECT_EQ(event->good_before, at(10ms));
}

TEST(Store, ReportsOnlyChanges) {
    auto store = small_store();
    EventCursor cursor;
    struct Step {
        double value;
        Quality quality;
        bool reported;
    };
    constexpr Step kSteps[] = {
        {1.0, Quality::good, true},  {1.0, Quality::good, false},
        {1.4, Quality::good, false},  // within the dead band
        {1.6, Quality::good, true},   // 0.6 from the last reported value, though only 0.2 from the last
        {1.6, Quality::bad, true},   {1.6, Quality::bad, false},
    };
    for (const auto& step : kSteps) {
        const Update update{SlotId{0}, step.value, step.quality};
        store.apply(at(1ms), {&update, 1});
        EXPECT_EQ(store.next_event(cursor) != nullptr, step.reported) << step.value;
        EXPECT_EQ(store[SlotId{0}].value, Value(step.value));
    }
}

TEST(Store, ABadReadKeepsTheTimeOfTheGoodOne) {
    auto store = small_store();
    const Update good{SlotId{1}, true};
    const Update bad{SlotId{1}, std::nullopt, Quality::uncertain, Reason::timeout};
    store.apply(at(1ms), {&good, 1});
    store.apply(at(9ms), {&bad, 1});
    EXPECT_EQ(store[SlotId{1}].good_at, at(1ms));
    EXPECT_EQ(store[SlotId{1}].value, Value(true));
    EXPECT_EQ(store[SlotId{1}].reason, Reason::timeout);
}

TEST(Store, TheEventsOfASlotNeverGoBackInTime) {
    auto store = small_store();
    const std::array<Update, 1> stale{Update{SlotId{0}, std::nullopt, Quality::uncertain, Reason::stale}};
    const std::array<Update, 1> read{Update{SlotId{0}, 2.0}};
    store.apply(at(20ms), stale);
    store.apply(at(15ms), read);  // it was confirmed after the mark
    EventCursor cursor;
    EXPECT_EQ(store.next_event(cursor)->t, at(20ms));
    const auto* event = store.next_event(cursor);
    ASSERT_NE(event, nullptr);
    EXPECT_EQ(event->t, at(20ms));
    EXPECT_EQ(event->good_at, at(15ms)) << "its age stays true";
}

TEST(Store, WantedDoesNotChangeTheActualValue) {
    auto store = small_store();
    store.want(SlotId{0}, 7.0);
    EXPECT_TRUE(is_empty(store[SlotId{0}].value));
    EXPECT_EQ(store.snapshot()[0].wanted, Value(7.0));
}

RC_GTEST_PROP(Store, ASlowReaderLearnsExactlyWhatItMissed, (std::vector<bool> reads)) {
    auto store = small_store(4);
    EventCursor cursor;
    std::uint64_t reported = 0;
    std::uint64_t seen = 0;
    for (const bool read : reads) {
        if (!read) {
            const Update update{SlotId{0}, static_cast<double>(++reported) * 10};
            store.apply(at(1ms), {&update, 1});
            continue;
        }
        while (const auto* event = store.next_event(cursor)) {
            ++seen;
            RC_ASSERT(event->sequence == seen + cursor.missed);
            RC_ASSERT(event->value == Value(static_cast<double>(event->sequence) * 10));
        }
        RC_ASSERT(seen + cursor.missed == reported);
    }
}

}  // namespace store_test
}  // namespace takt::value
