#include <gtest/gtest.h>

#include "builder.hpp"
#include "requests/boundary.hpp"
#include "takt/text/catalogue.hpp"

namespace takt::plan {
namespace reasons_test {

using namespace test;
using model::Profile;
using wire::Framing;
using Arguments = std::vector<std::pair<std::string, std::string>>;

struct Case {
    std::string code;
    Settings settings;
    std::vector<Item> items;  // the first request is the one asked about
    Arguments arguments;
};

const Item kA = int16(0).read(3).named("a");
const Item kB = int16(1).read(3).named("b");
const Item kWrittenA = int16(0).write(0x10).on_change().named("a");
const Item kWrittenB = int16(1).write(0x10).on_change().named("b");
const Item kBitA = boolean(0, 1).read(1).named("a");

Arguments both(Arguments more = {}) {
    Arguments arguments{{"previous", "a"}, {"next", "b"}};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
}

std::vector<Item> written_row(int count) {
    return row(count, int16(0).write(0x10).on_change());
}

const Settings kSingle{16, Framing::rtu, Profile::generic, model::Strategy::single};

const Case kCases[] = {
    {"plan.last", {16}, {kA, kB}, {{"variable", "b"}}},
    {"plan.last", {16}, {kWrittenA, kWrittenB}, {{"variable", "b"}}},
    {"plan.grouping_off", kSingle, {kA, kB}, {}},
    {"plan.gap", {16}, {kA, int16(6).read(3).named("b")}, both({{"size", "5"}})},
    {"plan.gap_bits", {16}, {kBitA, boolean(0, 4).read(1).named("b")}, both({{"size", "2"}})},
    {"plan.overlap", {16}, {real(0).read(3).named("a"), real(1).read(3).named("b")}, both()},
    {"plan.other_register", {16}, {kBitA, boolean(1, 2).read(1).named("b")}, both()},
    {"plan.other_function",
     {16},
     {kA, kB.read(4)},
     both({{"previous_function", "0x03"}, {"next_function", "0x04"}})},
    {"plan.single_function", {16}, {kWrittenA.write(0x06), kWrittenB.write(0x06)}, {{"function", "0x06"}}},
    {"plan.single_function",
     {16},
     {boolean(0, 1).write(0x05).on_change(), boolean(0, 2).write(0x05).on_change()},
     {{"function", "0x05"}}},
    {"plan.other_type",
     {16},
     {kA, real(1).read(3).named("b")},
     both({{"previous_type", "int16"}, {"next_type", "float"}})},
    {"plan.other_type",
     {16},
     {boolean(0, 1).read(3).named("a"), kB},
     both({{"previous_type", "bool"}, {"next_type", "int16"}})},
    {"plan.other_length",
     {16},
     {item(DataType::string, 0, 4).read(3).named("a"), item(DataType::string, 4, 6).read(3).named("b")},
     both({{"previous_registers", "4"}, {"next_registers", "6"}})},
    {"plan.other_period", {16}, {kA, kB.every(2500us)}, both({{"previous_ms", "100"}, {"next_ms", "2.5"}})},
    {"plan.other_status", {16}, {kA, kB.reports_to(0)}, both()},
    {"plan.other_trigger", {16}, {kA, kB.read_on(0)}, both()},
    {"plan.other_trigger", {16}, {kWrittenA, kWrittenB.write_on(0)}, both()},
    {"plan.other_write", {16}, {kWrittenA.write_on(0), int16(1).write(0x10).write_on(0).named("b")}, both()},
    {"plan.limit_setting", {3}, row(5, int16(0).read(3)), {{"next", "v4"}, {"size", "4"}, {"limit", "3"}}},
    {"plan.limit_setting",
     {61, Framing::ascii, Profile::owen_kc1},
     row(62, int16(0).read(4)),
     {{"next", "v62"}, {"size", "62"}, {"limit", "61"}}},
    {"plan.limit_frame",
     {61, Framing::ascii, Profile::owen_kc1},
     written_row(60),
     {{"next", "v60"}, {"size", "60"}, {"limit", "59"}}},
    {"plan.limit_protocol", {125}, written_row(124), {{"next", "v124"}, {"size", "124"}, {"limit", "123"}}},
};

TEST(Reasons, NameTheCauseAndItsFigures) {
    for (const auto& [code, settings, items, arguments] : kCases) {
        const auto plan = plan_of(settings, items);
        ASSERT_FALSE(plan.requests.empty()) << code;
        EXPECT_EQ(plan.requests[0].why.code, code);
        EXPECT_EQ(plan.requests[0].why.arguments, arguments) << code;
    }
}

TEST(Reasons, HaveATextForEachOfTheirArguments) {
    for (const auto& tested : kCases) {
        const Reason why = plan_of(tested.settings, tested.items).requests.at(0).why;
        std::vector<text::Argument> arguments;
        for (const auto& [name, value] : why.arguments) arguments.push_back({name, value});
        for (const auto language : text::kLanguages) {
            EXPECT_TRUE(text::has(language, why.code)) << why.code;
            const auto message = text::message(language, why.code, arguments);
            EXPECT_EQ(message.find('{'), std::string::npos) << message;
        }
    }
}

TEST(Reasons, NameTheProfileWhereItIsTheTightest) {
    auto made = project({200, Framing::rtu, Profile::owen_kc1}, {});
    const ItemLimit coils(made, made.lines[0], made.lines[0].devices[0], wire::Function::read_coils);
    EXPECT_EQ(coils.reason(126, kA).code, "plan.limit_profile");
}

TEST(Reasons, OfAMergedEntryAreThoseOfItsRead) {
    const auto plan = plan_of({16}, {kA.write(0x10).on_change(), int16(5).read(3).named("b")});
    EXPECT_EQ(plan.requests[0].why.code, "plan.gap") << "the write pass has no further variable";
}

TEST(Reasons, OfTheLimitComeLast) {
    const auto plan = plan_of({2}, {kA, kB, int16(9).read(3).named("c")});
    EXPECT_EQ(plan.requests[0].why.code, "plan.gap") << "full as well, but the gap would remain";
}

}  // namespace reasons_test
}  // namespace takt::plan
