#include "takt/plan/timeline.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <map>

#include "builder.hpp"

namespace takt::plan {
namespace timeline_test {

using namespace test;

struct Round {
    model::Project project;
    LinePlan plan;

    explicit Round(model::Project made) : project(std::move(made)), plan(make_plan(project).lines.at(0)) {}
    [[nodiscard]] Timeline over(Duration window, std::size_t most = 1000) const {
        return timeline(project.lines[0], plan, window, most);
    }
    /// Start addresses in the order they are sent.
    [[nodiscard]] std::vector<int> sent(Duration window) const {
        std::vector<int> starts;
        for (const Bar& bar : over(window).bars) starts.push_back(plan.requests[bar.request].start);
        return starts;
    }
};

model::Project singles(const std::vector<Item>& items) {
    Settings settings;
    settings.strategy = model::Strategy::single;
    return project(settings, items);
}

// One float at 115200 8N1 and 5 ms: 1.75 ms of silence, 8 characters there, 9 back.
TEST(Timeline, HasThePartsOfATransaction) {
    const Round round(singles({real(0).read(3)}));
    const auto bars = round.over(100ms).bars;
    ASSERT_EQ(bars.size(), 1U);
    EXPECT_EQ(bars[0].start, 0ns);
    EXPECT_EQ(bars[0].end_of(Part::silence), 1750us);
    EXPECT_EQ(bars[0].end_of(Part::request), 1750us + 694'445ns);
    EXPECT_EQ(bars[0].end_of(Part::turnaround), 6750us + 694'445ns);
    EXPECT_EQ(bars[0].end_of(Part::response), 6750us + 1'475'695ns);
    EXPECT_EQ(bars[0].begin_of(Part::response), bars[0].end_of(Part::turnaround));
    EXPECT_EQ(bars[0].end(), round.plan.requests[0].bus_time);
}

TEST(Timeline, StretchesWithAPauseToTheRequestGap) {
    auto made = singles({real(0).read(3)});
    made.lines[0].request_gap = 12ms;
    const auto bars = Round(made).over(100ms).bars;
    EXPECT_LT(bars.at(0).end_of(Part::response), 12ms);
    EXPECT_EQ(bars.at(0).end_of(Part::pause), 12ms);
}

TEST(Timeline, HasNoSilencesOnTcp) {
    Settings settings;
    settings.framing = wire::Framing::tcp;
    const auto bars = Round(project(settings, {int16(0).read(3)})).over(10ms).bars;
    EXPECT_EQ(bars.at(0).end_of(Part::silence), 0ns);
    EXPECT_EQ(bars.at(0).end_of(Part::request), 120ns);
    EXPECT_EQ(bars.at(0).end_of(Part::turnaround), 1ms + 120ns);
    EXPECT_EQ(bars.at(0).end(), 1ms + 230ns);
}

TEST(Timeline, SendsTheLeastDeadlineFirst) {
    const Round round(singles({int16(0).read(3).every(200ms), int16(7).read(3).every(100ms)}));
    EXPECT_EQ(round.sent(200ms), (std::vector{7, 0, 7}));
    const auto bars = round.over(200ms).bars;
    EXPECT_EQ(bars[1].due, 0ns);
    EXPECT_EQ(bars[1].start, bars[0].end());
    EXPECT_EQ(bars[2].start, 100ms);
}

TEST(Timeline, GoesRoundByAddressWhereTheLineDoes) {
    auto made = singles({int16(0).read(3).every(200ms), int16(7).read(3).every(100ms)});
    made.lines[0].order = model::PollOrder::address;
    EXPECT_EQ(Round(made).sent(200ms), (std::vector{0, 7, 7}));
}

TEST(Timeline, BeginsANewRoundAfterIdleTime) {
    auto made = singles(
        {int16(0).read(3).every(100ms), int16(4).read(3).every(200ms), int16(7).read(3).every(200ms)});
    made.lines[0].order = model::PollOrder::address;
    EXPECT_EQ(Round(made).sent(300ms), (std::vector{0, 4, 7, 0, 0, 4, 7}));
}

TEST(Timeline, WaitsForThePhase) {
    Round round(singles({int16(0).read(3)}));
    round.plan.requests[0].phase = 30ms;
    const auto bars = round.over(300ms).bars;
    ASSERT_EQ(bars.size(), 3U);
    EXPECT_EQ(bars[0].start, 30ms);
    EXPECT_EQ(bars[2].start, 230ms);
}

TEST(Timeline, FillsIdleTimeWithWhatHasNoPeriod) {
    const Round round(
        singles({int16(0).read(3).every(0ms), int16(4).read(3).every(0ms), int16(7).read(3).every(30ms)}));
    const auto sent = round.sent(60ms);
    EXPECT_EQ(sent.at(0), 7);
    EXPECT_EQ(std::count(sent.begin(), sent.end(), 7), 2);
    EXPECT_LE(std::abs(std::count(sent.begin(), sent.end(), 0) - std::count(sent.begin(), sent.end(), 4)), 1);
    EXPECT_GE(round.over(60ms).bars.back().end(), 60ms);
}

TEST(Timeline, KeepsWhatIsNotPolledOut) {
    const Round round(project({16}, {int16(0).read(3), int16(1).write(0x10).on_change()}));
    ASSERT_EQ(round.plan.requests.size(), 2U);
    EXPECT_EQ(round.over(100ms).bars.size(), 1U);
}

TEST(Timeline, SaysThatItWasCut) {
    const Round round(singles({int16(0).read(3)}));
    EXPECT_FALSE(round.over(1000ms, 10).cut);
    const auto cut = round.over(1001ms, 10);
    EXPECT_TRUE(cut.cut);
    EXPECT_EQ(cut.bars.size(), 10U);
    EXPECT_TRUE(Round(singles({})).over(1s).bars.empty());
}

TEST(RoundWindow, IsAHyperperiodWithinLimits) {
    const auto window = [](std::initializer_list<Duration> periods) {
        std::vector<Item> items;
        for (const auto period : periods)
            items.push_back(int16(10 * static_cast<int>(items.size())).read(3).every(period));
        return round_window(Round(singles(items)).plan);
    };
    EXPECT_EQ(window({200ms, 500ms}).length, 1s);
    EXPECT_TRUE(window({200ms, 500ms}).whole);
    EXPECT_EQ(window({100ms, 3600s}).length, 10s);
    EXPECT_EQ(window({100ms, 3600s}).repeats, 3600s);
    EXPECT_FALSE(window({100ms, 3600s}).whole);
    EXPECT_EQ(window({86399s, 86397s, 86391s, 86389s}).repeats, Duration::max());
    EXPECT_EQ(window({0ms}).length, Round(singles({int16(0).read(3)})).plan.cycle);
    EXPECT_EQ(window({}).length, 0ns);
    EXPECT_GE(window({1ms}).length, 7ms) << "an overrun line shows a whole round";
}

// With any periods, phases and loads: nothing overlaps, nothing is early, each bar is its bus time, no
// due is served twice, and the line never idles while something is due.
RC_GTEST_PROP(Timeline, IsAScheduleWithoutPreemption, ()) {
    std::vector<Item> items;
    const int count = *rc::gen::inRange(1, 12);
    for (int i = 0; i < count; ++i)
        items.push_back(
            int16(3 * i).read(3).every(*rc::gen::element<Duration>(0ms, 20ms, 50ms, 70ms, 300ms)));
    auto made = singles(items);
    made.lines[0].order = *rc::gen::element(model::PollOrder::deadline, model::PollOrder::address);
    Round round(std::move(made));
    for (auto& request : round.plan.requests)
        if (*request.period > 0ms) request.phase = *request.period * *rc::gen::inRange(0, 10) / 10;
    const auto bars = round.over(1s).bars;
    std::map<std::size_t, Duration> last_due;
    Duration free{};
    for (const Bar& bar : bars) {
        const Request& request = round.plan.requests[bar.request];
        RC_ASSERT(bar.start >= free && bar.start >= bar.due && bar.start < 1s);
        RC_ASSERT(bar.end() - bar.start == request.bus_time);
        RC_ASSERT(std::is_sorted(bar.ends.begin(), bar.ends.end()));
        if (bar.start > free)
            RC_ASSERT(std::all_of(bars.begin(), bars.end(), [&](const Bar& other) {
                return other.start < bar.start || other.due >= bar.start;
            }));
        if (*request.period > 0ms) {
            RC_ASSERT((bar.due - request.phase) % *request.period == 0ns);
            const auto [before, first] = last_due.try_emplace(bar.request, bar.due);
            RC_ASSERT(first || before->second < bar.due);
            before->second = bar.due;
        }
        free = bar.end();
    }
}

}  // namespace timeline_test
}  // namespace takt::plan
