// Strategy optimal on examples worked out by hand, with its reasons.
#include <gtest/gtest.h>

#include "builder.hpp"
#include "takt/text/catalogue.hpp"

namespace takt::plan {
namespace optimal_test {

using namespace test;
using wire::Framing;
using Arguments = std::vector<std::pair<std::string, std::string>>;

struct Read {
    int function, start, quantity;
    std::vector<std::string> names;
    friend bool operator==(const Read&, const Read&) = default;
};

void PrintTo(const Read& read, std::ostream* out) {
    *out << read.function << ' ' << read.start << '+' << read.quantity;
    for (const auto& name : read.names) *out << ' ' << name;
}

constexpr Settings kOptimal{16, Framing::rtu, model::Profile::generic, model::Strategy::optimal};

model::Project optimal(const std::vector<Item>& items, model::Gaps gaps = model::Gaps::always) {
    auto made = project(kOptimal, items);
    made.lines[0].devices[0].gaps = gaps;
    return made;
}

std::vector<Read> reads(const model::Project& project) {
    std::vector<Read> reads;
    const auto plan = make_plan(project).lines.at(0);
    for (const Request& request : plan.requests) {
        std::vector<std::string> names;
        for (const std::size_t i : request.variables)
            names.push_back(project.lines[0].devices[0].variables[i].name);
        reads.push_back({static_cast<int>(*request.read), request.start, request.quantity, names});
    }
    return reads;
}

Item at(int register_number, const char* name) {
    return int16(register_number).read(3).named(name);
}

// At 115200 8N1 a register takes 20 bits = 0.173611 ms, a request 1.75 + 5 ms and 13 characters = 7.878472
// ms: a gap is worth reading up to 45 registers.
TEST(Optimal, ReadsAGapWhereARequestCostsMore) {
    EXPECT_EQ(reads(optimal({at(0, "a"), at(46, "b")})), (std::vector<Read>{{3, 0, 47, {"a", "b"}}}));
    EXPECT_EQ(reads(optimal({at(0, "a"), at(47, "b")})),
              (std::vector<Read>{{3, 0, 1, {"a"}}, {3, 47, 1, {"b"}}}));
    EXPECT_EQ(reads(optimal({at(0, "a"), at(46, "b")}, model::Gaps::learn)).size(), 1U) << "may be tried";
    EXPECT_EQ(reads(optimal({at(0, "a"), at(2, "b")}, model::Gaps::never)).size(), 2U);
}

TEST(Optimal, ReadsOverWhatAnotherPeriodReads) {
    EXPECT_EQ(reads(optimal({at(0, "a"), at(2, "b"), at(1, "slow").every(1s)}, model::Gaps::never)),
              (std::vector<Read>{{3, 0, 3, {"a", "slow", "b"}}}));
    EXPECT_EQ(reads(optimal({at(0, "a"), at(2, "b"), at(1, "off").unused()}, model::Gaps::never)).size(), 2U);
    EXPECT_EQ(
        reads(optimal({at(0, "a"), at(2, "b"), int16(1).read(4).named("other")}, model::Gaps::never)).size(),
        3U);
}

TEST(Optimal, MixesTypesStatusesAndTriggers) {
    EXPECT_EQ(reads(optimal(
                  {boolean(0, 3).read(3).named("b3"), boolean(0, 1).read(3).named("b1"),
                   real(1).read(3).named("f").reports_to(0), item(DataType::string, 3, 10).read(3).named("s"),
                   item(DataType::float64, 5).read(3).named("inside")},
                  model::Gaps::never)),
              (std::vector<Read>{{3, 0, 13, {"b1", "b3", "f", "s", "inside"}}}));
}

TEST(Optimal, LimitsToRegistersPerRequestWhereTheUserSetThem) {
    auto made = optimal(row(130, int16(0).read(3)));
    const auto quantities = [&] {
        std::vector<int> all;
        for (const auto& read : reads(made)) all.push_back(read.quantity);
        return all;
    };
    EXPECT_EQ(quantities(), (std::vector<int>{125, 5}));
    made.lines[0].devices[0].registers_per_request = 60;
    made.lines[0].devices[0].registers_per_request_set = true;
    EXPECT_EQ(quantities(), (std::vector<int>{60, 60, 10}));
}

TEST(Optimal, CutsOnlyValuesThatAreLongerThanARequest) {
    auto made = optimal({item(DataType::string, 0, 10).read(3).named("s"), at(10, "a"), at(4, "inside")});
    made.lines[0].devices[0].registers_per_request = 4;
    made.lines[0].devices[0].registers_per_request_set = true;
    EXPECT_EQ(reads(made),
              (std::vector<Read>{{3, 0, 4, {"s"}}, {3, 4, 4, {"inside", "s"}}, {3, 8, 3, {"s", "a"}}}));
}

TEST(Optimal, ReadsByATriggerExactlyWhatItNames) {
    const auto made = optimal({at(0, "a").read_on(7), at(1, "b").read_on(7), at(2, "c"),
                               at(90, "d").read_on(7), at(91, "e").read_on(8)});
    const auto plan = make_plan(made).lines[0];
    EXPECT_EQ(reads(made), (std::vector<Read>{{3, 0, 2, {"a", "b"}},
                                              {3, 0, 3, {"a", "b", "c"}},
                                              {3, 90, 1, {"d"}},
                                              {3, 90, 2, {"d", "e"}},
                                              {3, 91, 1, {"e"}}}));
    EXPECT_EQ(plan.requests[0].read_trigger, 7U);
    EXPECT_EQ(plan.requests[0].period, std::nullopt);
    EXPECT_EQ(plan.requests[0].deadline, std::nullopt);
    EXPECT_EQ(plan.requests[1].read_trigger, std::nullopt);
    EXPECT_EQ(plan.requests[1].period, 100ms);
    EXPECT_EQ(plan.request_count, 5U);
}

TEST(Optimal, MakesOneEntryOfAPollAndATriggerThatReadTheSame) {
    const auto made = optimal({at(0, "a").read_on(7), at(1, "b").read_on(7), at(90, "c")});
    const auto plan = make_plan(made).lines[0];
    ASSERT_EQ(plan.requests.size(), 2U);
    EXPECT_EQ(plan.requests[0].read_trigger, 7U);
    EXPECT_EQ(plan.requests[0].period, 100ms);
    EXPECT_EQ(plan.requests[0].count(), 2U);
    const auto slower = optimal({at(0, "a").read_on(7), at(0, "b").read_on(7).every(1s)});
    EXPECT_EQ(reads(slower), (std::vector<Read>{{3, 0, 1, {"a", "b"}}}));
}

TEST(Optimal, WritesLikeClassicAndLeavesBitsOfRegistersOut) {
    const auto made = optimal(
        {int16(0).read(3).write(0x10).on_change().named("a"), int16(1).write(0x10).on_change().named("b"),
         boolean(5, 1).read(3).write(0x10).on_change().named("bit")},
        model::Gaps::never);
    const auto plan = make_plan(made).lines[0];
    ASSERT_EQ(plan.requests.size(), 3U);
    EXPECT_EQ(plan.requests[2].read, std::nullopt);
    EXPECT_EQ(plan.requests[2].write, wire::Function::write_multiple_registers);
    EXPECT_EQ(plan.requests[2].variables, (std::vector<std::size_t>{0, 1}));
    EXPECT_EQ(plan.requests[2].stream, 2U);
}

// 1 ms and 0.24 us against 20 ns a register: everything within the limit; four in flight share the round
// trip.
TEST(Optimal, CountsTheRequestsInFlightOnTcp) {
    Settings settings = kOptimal;
    settings.framing = Framing::tcp;
    auto made = project(settings, {at(0, "a"), at(120, "b")});
    made.lines[0].devices[0].gaps = model::Gaps::always;
    EXPECT_EQ(reads(made).size(), 1U);
    made.lines[0].devices[0].round_trip = 4us;
    EXPECT_EQ(reads(made).size(), 1U) << "4.2 us against 2.4 us";
    made.lines[0].devices[0].in_flight = 4;
    EXPECT_EQ(reads(made).size(), 2U) << "1.2 us against 2.4 us";
}

struct Case {
    std::string code;
    std::vector<Item> items;  // the first request is the one asked about
    Arguments arguments;
    void (*change)(model::Device&) = [](model::Device&) {};
};

Arguments both(Arguments more = {}) {
    Arguments arguments{{"previous", "a"}, {"next", "b"}};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
}

void forbid_gaps(model::Device& device) {
    device.gaps = model::Gaps::never;
}

void limit_to_four(model::Device& device) {
    device.registers_per_request = 4;
    device.registers_per_request_set = true;
}

const Case kCases[] = {
    {"plan.last", {at(0, "a"), at(1, "b")}, {{"variable", "b"}}},
    {"plan.gap_costs",
     {at(0, "a"), at(50, "b")},
     both({{"size", "49"}, {"gap_ms", "8.51"}, {"request_ms", "7.88"}})},
    {"plan.gap_costs",
     {at(0, "a"), at(999, "b")},
     both({{"size", "998"}, {"gap_ms", "173"}, {"request_ms", "7.88"}})},
    {"plan.gap_forbidden",
     {at(0, "a"), at(2, "b")},
     both({{"size", "1"}, {"setting", "gaps: never"}}),
     forbid_gaps},
    {"plan.gap_forbidden",
     {at(0, "a"), at(9, "b")},
     both({{"size", "8"}, {"setting", "no_read: 4..6"}}),
     [](model::Device& device) { device.no_read[3] = {{4, 6}}; }},
    {"plan.gap_forbidden",
     {at(0, "a"), at(9, "b")},
     both({{"size", "8"}, {"setting", "readable"}}),
     [](model::Device& device) { device.readable[3] = {{0, 5}}; }},
    {"plan.limit_setting",
     {at(0, "a"), item(DataType::float64, 1).read(3).named("b")},
     {{"next", "b"}, {"size", "5"}, {"limit", "4"}},
     limit_to_four},
    {"plan.limit_protocol",
     {item(DataType::string, 0, 120).read(3).named("a"), item(DataType::string, 120, 10).read(3).named("b")},
     {{"next", "b"}, {"size", "130"}, {"limit", "125"}}},
    {"plan.cheapest_cut",
     {at(0, "a"), at(2, "b"), at(3, "c"), at(4, "d")},
     both({{"size", "5"}, {"limit", "4"}}),
     limit_to_four},
};

Request first_request(const Case& tested) {
    auto made = optimal(tested.items);
    tested.change(made.lines[0].devices[0]);
    return make_plan(made).lines[0].requests.at(0);
}

std::string reason_text(text::Language language, const Reason& reason) {
    std::vector<text::Argument> arguments;
    for (const auto& [name, value] : reason.arguments) arguments.push_back({name, value});
    EXPECT_TRUE(text::has(language, reason.code)) << reason.code;
    return text::message(language, reason.code, arguments);
}

TEST(OptimalReasons, NameTheCauseAndItsFigures) {
    for (const Case& tested : kCases) {
        const Reason why = first_request(tested).why;
        EXPECT_EQ(why.code, tested.code);
        EXPECT_EQ(why.arguments, tested.arguments) << tested.code;
        for (const auto language : text::kLanguages)
            EXPECT_EQ(reason_text(language, why).find('{'), std::string::npos) << reason_text(language, why);
    }
}

TEST(OptimalReasons, SayWhatReadingGapsSaves) {
    const auto bridged =
        make_plan(optimal({at(0, "a"), at(5, "b"), at(16, "c")})).lines[0].requests.at(0).bridged;
    ASSERT_TRUE(bridged);
    EXPECT_EQ(bridged->code, "plan.bridged");
    EXPECT_EQ(bridged->arguments,
              (Arguments{{"gaps", "2"}, {"size", "14"}, {"gap_ms", "2.43"}, {"request_ms", "15.8"}}));
    for (const auto language : text::kLanguages)
        EXPECT_EQ(reason_text(language, *bridged).find('{'), std::string::npos);
    EXPECT_FALSE(make_plan(optimal({at(0, "a"), at(1, "b")})).lines[0].requests.at(0).bridged);
}

TEST(OptimalReasons, ShowEnoughDigitsToDistinguishTheTimes) {
    // A gap of 46 registers takes 7.986 ms, a request 7.878 ms with 13 characters, 7.966 ms with 14 at 1
    // Mbit/s
    auto made = optimal({at(0, "a"), at(47, "b")});
    made.lines[0].devices[0].turnaround = 5ms + 107us;
    const auto why = make_plan(made).lines[0].requests.at(0).why;
    ASSERT_EQ(why.code, "plan.gap_costs");
    EXPECT_EQ(why.arguments[3].second, "7.986");
    EXPECT_EQ(why.arguments[4].second, "7.985");
}

}  // namespace optimal_test
}  // namespace takt::plan
