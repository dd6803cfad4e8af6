#include "reads/age_watch.hpp"

#include <gtest/gtest.h>

#include <array>

#include "bench.hpp"

namespace takt::poll::test {
namespace age_watch_test {

using value::Quality;
using value::SlotId;
using value::Update;

constexpr SlotId kFirst{1};

/// Three variables in the slots 1 to 3.
struct Watch {
    Watch()
        : store({{.name = "other", .type = DataType::int16},
                 {.name = "a", .type = DataType::int16},
                 {.name = "b", .type = DataType::int16},
                 {.name = "c", .type = DataType::int16}}),
          watch(store, kFirst) {}

    static SlotId slot(std::size_t variable) { return {kFirst.value + static_cast<std::uint32_t>(variable)}; }
    [[nodiscard]] Quality quality(std::size_t variable) const { return store[slot(variable)].quality; }
    /// Something else publishes them.
    std::vector<Update> publish(const std::vector<std::size_t>& variables, Instant t) {
        std::vector<Update> updates;
        for (const auto v : variables) updates.push_back({slot(v), std::int64_t{1}});
        store.apply(t, updates);
        return updates;
    }
    /// A request reads these variables.
    void read(const std::vector<std::size_t>& variables, Instant sampled, Instant t) {
        publish(variables, t);
        watch.note_read(variables, sampled, t);
    }
    /// Something else reads them.
    void update(const std::vector<std::size_t>& variables, Instant sampled, Instant t) {
        watch.note_updates(publish(variables, t), sampled, t);
    }
    /// The variables that become stale.
    std::vector<std::size_t> stale(Instant t) {
        std::vector<std::size_t> all;
        while (const auto group = watch.take_stale(t))
            for (const auto v : group->variables)
                if (quality(v) == Quality::uncertain) all.push_back(v);
        return all;
    }

    value::Store store;
    AgeWatch watch;
};

using Variables = std::vector<std::size_t>;

TEST(AgeWatch, AValueIsGoodUpToItsBoundFromTheStartOfItsRead) {
    Watch line;
    line.watch.watch(3, {{0, 100ms, false, {5}}});
    EXPECT_EQ(line.watch.next(), kNever) << "nothing was read";
    line.read({0}, at(10ms), at(30ms));
    EXPECT_EQ(line.watch.next(), at(110ms) + Duration(1));
    EXPECT_EQ(line.stale(at(110ms)), Variables{});
    EXPECT_EQ(line.stale(at(110ms) + Duration(1)), Variables{0});
    EXPECT_EQ(line.store[Watch::slot(0)].reason, value::Reason::stale);
    EXPECT_EQ(line.watch.next(), kNever);
    line.read({0}, at(200ms), at(220ms));
    EXPECT_EQ(line.quality(0), Quality::good);
    EXPECT_EQ(line.watch.next(), at(300ms) + Duration(1));
}

TEST(AgeWatch, EachReadStartsTheAgeAnew) {
    Watch line;
    line.watch.watch(3, {{0, 100ms, false, {5}}});
    for (auto t = 0ms; t < 1s; t += 90ms) {
        line.read({0}, at(t), at(t + 5ms));
        EXPECT_EQ(line.stale(at(t + 89ms)), Variables{});
    }
}

TEST(AgeWatch, ValuesOfTheSameReadAndBoundGoTogether) {
    Watch line;
    line.watch.watch(3, {{0, 100ms, false, {5}}, {1, 100ms, false, {5}}, {2, 50ms, false, {5}}});
    line.read({0, 1, 2}, at(0ms), at(5ms));
    const auto first = line.watch.take_stale(at(60ms));
    ASSERT_TRUE(first);
    EXPECT_EQ(Variables(first->variables.begin(), first->variables.end()), Variables{2});
    EXPECT_EQ(Variables(first->readers.begin(), first->readers.end()), Variables{5});
    EXPECT_FALSE(line.watch.take_stale(at(60ms)));
    EXPECT_EQ(line.stale(at(101ms)), (Variables{0, 1}));
}

TEST(AgeWatch, AValueThatSomethingElseReadIsAsOldAsThat) {
    Watch line;
    line.watch.watch(3, {{0, 100ms, false, {5}}, {1, 100ms, false, {5}}});
    line.read({0, 1}, at(0ms), at(5ms));
    line.update({1}, at(60ms), at(70ms));
    EXPECT_EQ(line.stale(at(101ms)), Variables{0});
    EXPECT_EQ(line.quality(1), Quality::good);
    EXPECT_EQ(line.stale(at(160ms)), Variables{});
    line.stale(at(161ms));
    EXPECT_EQ(line.quality(1), Quality::uncertain);
}

TEST(AgeWatch, WhatIsNotGoodAnyMoreIsNotWatched) {
    Watch line;
    line.watch.watch(3, {{0, 100ms, false, {5}}});
    line.read({0}, at(0ms), at(5ms));
    line.watch.forget(0);
    line.watch.forget(1);  // not watched at all
    EXPECT_EQ(line.watch.next(), kNever);
}

TEST(AgeWatch, WhatWasGoodBeforeIsAsOldAsTheBegin) {
    Watch line;
    line.publish({0}, at(5ms));
    line.watch.watch(3, {{0, 100ms, false, {5}}, {1, 100ms, false, {6}}});
    line.watch.begin(at(50ms));
    EXPECT_EQ(line.watch.next(), at(150ms) + Duration(1)) << "1 was never read";
    EXPECT_EQ(line.stale(at(151ms)), Variables{0});
}

TEST(AgeWatch, SlotsOfOtherLinesAreNotItsOwn) {
    Watch line;
    line.watch.watch(3, {{0, 100ms, false, {5}}});
    const std::array other{Update{SlotId{0}, std::int64_t{1}}};
    line.store.apply(at(1ms), other);
    line.watch.note_updates(other, at(0ms), at(1ms));
    EXPECT_EQ(line.watch.next(), kNever);
}

}  // namespace age_watch_test
}  // namespace takt::poll::test
