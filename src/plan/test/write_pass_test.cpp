// Writes of strategy optimal: the variables that share a request, its function and its cost.
#include "requests/write_pass.hpp"

#include <gtest/gtest.h>

#include <functional>

#include "builder.hpp"
#include "cost/exact_time.hpp"
#include "cost/transaction_cost.hpp"
#include "takt/text/catalogue.hpp"
#include "timing/admission.hpp"

namespace takt::plan {
namespace write_pass_test {

using namespace test;
using model::WriteSingle;
using Change = std::function<void(model::Device&)>;

constexpr Settings kOptimal{16, wire::Framing::rtu, model::Profile::generic, model::Strategy::optimal};

model::Project made(const std::vector<Item>& items, const Change& change = {},
                    const Settings& settings = kOptimal) {
    auto project = test::project(settings, items);
    project.locals.resize(4);
    if (change) change(project.lines[0].devices[0]);
    return project;
}

std::vector<Request> writes(const model::Project& project) {
    return write_requests(project, project.lines[0], project.lines[0].devices[0]);
}

std::vector<Request> joined_of(const model::Project& project, std::vector<Request> reads) {
    return joined(project, project.lines[0], project.lines[0].devices[0], std::move(reads), writes(project));
}

/// "10:0+4 06:9+1": function, start, quantity.
std::string requests_text(const std::vector<Request>& requests) {
    std::string text;
    for (const Request& r : requests) {
        char one[64];
        std::snprintf(one, sizeof one, "%s%s%02X:%d+%d", text.empty() ? "" : " ",
                      r.read_modify_write ? "rmw" : "", static_cast<unsigned>(*r.write), r.start, r.quantity);
        text += one;
    }
    return text;
}

Item word(int at, int function = 0x10) {
    return int16(at).read(3).write(function).on_change();
}
Item coil(int number, int function = 0x0F) {
    return boolean(number / 16, number % 16).read(1).write(function).on_change();
}
Item bit(int number, int at, int function = 0x10) {
    return boolean(number, at).read(3).write(function).on_change();
}

void fc22(model::Device& device) {
    device.fc22 = true;
}
void rmw(model::Device& device) {
    device.read_modify_write = true;
}
Change single(WriteSingle mode, Change more = {}) {
    return [=](model::Device& device) {
        device.write_single = mode;
        if (more) more(device);
    };
}
void five_per_request(model::Device& device) {
    device.registers_per_request = 5;
    device.registers_per_request_set = true;
}

struct Case {
    const char* what;
    std::vector<Item> items;
    Change change;
    const char* expected;
};

const Case kCases[] = {
    {"adjacent, of any type, period and status",
     {word(0), real(1).read(3).write(0x10).on_change().every(1s),
      int32(3).write(0x10).on_change().reports_to(1)},
     {},
     "10:0+5"},
    {"the setting that was only a default is no limit", row(40, word(0)), {}, "10:0+40"},
    {"the protocol's limit", row(130, word(0)), {}, "10:0+123 10:123+7"},
    {"the user's limit", row(12, word(0)), five_per_request, "10:0+5 10:5+5 10:10+2"},
    {"a value longer than the user's limit is not torn",
     {word(0), item(DataType::string, 1, 9).write(0x10).on_change(), word(10)},
     five_per_request,
     "10:0+1 10:1+9 10:10+1"},
    {"a gap is not written", {word(0), word(2)}, {}, "10:0+1 10:2+1"},
    {"what is not asked for is not written",
     {word(0), int16(1).read(3).write(0x10), word(2)},
     {},
     "10:0+1 10:2+1"},
    {"nor what is unused", {word(0), word(1).unused(), word(2)}, {}, "10:0+1 10:2+1"},
    {"other trigger", {word(0).write_on(0), word(1).write_on(1)}, {}, "10:0+1 10:1+1"},
    {"same trigger", {word(0).write_on(0), word(1).write_on(0)}, {}, "10:0+2"},
    {"write on change differs", {int16(0).write(0x10).write_on(0), word(1).write_on(0)}, {}, "10:0+1 10:1+1"},
    {"overlapping", {real(0).write(0x10).on_change(), word(1), word(2)}, {}, "10:0+3 10:1+1"},
    {"the same registers twice", {word(0), word(0), word(1)}, {}, "10:0+1 10:0+2"},
    {"coils, across registers", {coil(14), coil(15), coil(16)}, {}, "0F:14+3"},
    {"coils with a gap", {coil(3), coil(5)}, {}, "0F:3+1 0F:5+1"},
    {"coils and registers apart", {coil(0), word(1)}, {}, "0F:0+1 10:1+1"},

    {"as declared: 0x06 alone", {word(0, 6), word(1), word(2), word(3, 6)}, {}, "06:0+1 06:3+1 10:1+2"},
    {"as declared: 0x10 also for one", {word(0)}, {}, "10:0+1"},
    {"allowed: groups of several, the cheaper for one",
     {word(0, 6), word(1), word(5), coil(0), coil(1, 5), coil(9)},
     single(WriteSingle::allowed),
     "05:9+1 06:5+1 0F:0+2 10:0+2"},
    {"allowed: a value of two registers",
     {real(0).write(0x10).on_change()},
     single(WriteSingle::allowed),
     "10:0+2"},
    {"never",
     {word(0, 6), word(1, 6), word(7, 6), coil(3, 5)},
     single(WriteSingle::never),
     "0F:3+1 10:0+2 10:7+1"},
    {"only", {word(0), word(1), coil(3), coil(4)}, single(WriteSingle::only), "05:3+1 05:4+1 06:0+1 06:1+1"},

    {"bits by mask: one request a register", {bit(0, 3), bit(0, 9), bit(1, 0)}, fc22, "16:0+1 16:1+1"},
    {"bits due at other times", {bit(0, 3), bit(0, 9).write_on(1)}, fc22, "16:0+1 16:0+1"},
    {"the same bit twice", {bit(0, 3), bit(0, 3), bit(0, 4)}, fc22, "16:0+1 16:0+1"},
    {"a bit is no register", {bit(0, 3), word(1)}, fc22, "10:1+1 16:0+1"},
    {"mask before read-modify-write", {bit(0, 3)}, [](auto& d) { fc22(d), rmw(d); }, "16:0+1"},
    {"read-modify-write, as declared", {bit(0, 3, 6), bit(0, 4), bit(5, 4)}, rmw, "rmw06:0+1 rmw10:5+1"},
    {"read-modify-write, never single", {bit(0, 3, 6)}, single(WriteSingle::never, rmw), "rmw10:0+1"},
    {"read-modify-write, allowed", {bit(0, 3)}, single(WriteSingle::allowed, rmw), "rmw06:0+1"},
    {"neither: not written", {bit(0, 3)}, {}, ""},
};

TEST(WritePass, Table) {
    for (const auto& [what, items, change, expected] : kCases)
        EXPECT_EQ(requests_text(writes(made(items, change))), expected) << what;
}

TEST(WritePass, AdmissionIsTheTriggersElseTheVariables) {
    const model::RateLimit slow{1s, 1};
    const model::RateLimit fast{100ms, 3};
    auto project = made({word(0), word(1), word(2).write_on(0), word(3).write_on(1), word(4).write_on(1)});
    auto& variables = project.lines[0].devices[0].variables;
    for (auto& v : variables) v.admission = slow;
    variables[1].admission = fast;
    project.locals[0].admission = fast;
    const auto requests = writes(project);
    EXPECT_EQ(requests_text(requests), "10:0+1 10:1+1 10:2+1 10:3+2");
    const std::optional<model::RateLimit> kExpected[] = {slow, fast, fast, slow};
    for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(requests[i].admission, kExpected[i]) << i;
    EXPECT_EQ(requests[0].why.code, "plan.other_admission");
    EXPECT_EQ(requests[1].why.code, "plan.other_trigger");
}

TEST(WritePass, StatusIsSaidWhereAllMembersShareIt) {
    const auto shared = writes(made({word(0).reports_to(1), word(1).reports_to(1)}));
    EXPECT_EQ(shared[0].status, 1U);
    const auto mixed = writes(made({word(0).reports_to(1), word(1).reports_to(2)}));
    EXPECT_EQ(mixed[0].status, std::nullopt);
}

struct WhyCase {
    const char* code;
    std::vector<Item> items;
    Change change;
};

const WhyCase kReasons[] = {
    {"plan.last", {word(0)}, {}},
    {"plan.gap", {word(0), word(3)}, {}},
    {"plan.gap_bits", {coil(0), coil(3)}, {}},
    {"plan.overlap", {real(0).write(0x10).on_change(), real(1).write(0x10).on_change()}, {}},
    {"plan.other_trigger", {word(0), word(1).write_on(1)}, {}},
    {"plan.other_write", {int16(0).write(0x10).write_on(1), word(1).write_on(1)}, {}},
    {"plan.single_function", {word(0, 6), word(1)}, {}},
    {"plan.limit_setting", row(6, word(0)), five_per_request},
    {"plan.limit_protocol", row(124, word(0)), {}},
    {"plan.other_register", {bit(0, 3), bit(1, 3)}, fc22},
};

TEST(WritePass, ReasonsNameWhatComesNext) {
    for (const auto& [code, items, change] : kReasons)
        EXPECT_EQ(writes(made(items, change))[0].why.code, code);
    for (const auto language : text::kLanguages)
        for (const char* code : {"plan.other_admission", "plan.bit_alone"})
            EXPECT_TRUE(text::has(language, code));
}

// ---- other strategies

TEST(WritePass, SingleAndClassicWriteEachBitByItself) {
    for (const auto strategy : {model::Strategy::single, model::Strategy::classic}) {
        Settings settings = kOptimal;
        settings.strategy = strategy;
        const auto plan = make_plan(made({bit(0, 3), bit(0, 4), word(8)}, fc22, settings)).lines[0];
        std::size_t masks = 0;
        for (const Request& r : plan.requests) {
            if (r.write != wire::Function::mask_write_register) continue;
            ++masks;
            EXPECT_EQ(r.variables.size(), 1U);
            EXPECT_EQ(r.start, 0);
            EXPECT_EQ(r.quantity, 1);
        }
        EXPECT_EQ(masks, 2U) << name(strategy);
    }
}

TEST(WritePass, ClassicLeavesBitsOutWhereTheDeviceCannotWriteThem) {
    Settings settings = kOptimal;
    settings.strategy = model::Strategy::classic;
    const auto plan = make_plan(made({bit(0, 3)}, {}, settings)).lines[0];
    for (const Request& r : plan.requests) EXPECT_FALSE(r.write);
}

// ---- joining

Request read_of(const model::Project& project, std::vector<std::size_t> variables, std::uint16_t quantity) {
    const auto& first = project.lines[0].devices[0].variables[variables.front()];
    Request read;
    read.read = first.read;
    read.start = first.start();
    read.quantity = quantity;
    read.period = first.period;
    read.read_trigger = first.read_trigger;
    read.variables = std::move(variables);
    return read;
}

TEST(Joining, AWriteOfExactlyTheVariablesOfAReadJoinsIt) {
    const auto project = made(row(3, word(0)));
    const auto same = joined_of(project, {read_of(project, {0, 1, 2}, 3)});
    ASSERT_EQ(same.size(), 1U);
    EXPECT_EQ(same[0].read, wire::Function::read_holding_registers);
    EXPECT_EQ(same[0].write, wire::Function::write_multiple_registers);
    EXPECT_TRUE(same[0].write_on_change);
    const auto wider = joined_of(project, {read_of(project, {0, 1, 2}, 4)});  // a gap behind them
    EXPECT_EQ(wider.size(), 2U);
    const auto fewer = joined_of(project, {read_of(project, {0, 1}, 2), read_of(project, {2}, 1)});
    EXPECT_EQ(fewer.size(), 3U);
}

TEST(Joining, OneTransactionReadsAndWritesWithTheSameTrigger) {
    const auto fc23 = [](model::Device& device) { device.fc23 = true; };
    auto items = row(4, int16(0).read(3).read_on(0));
    items.push_back(int16(20).read(3).write(0x10).write_on(0));
    items.push_back(int16(21).read(3).write(0x10).write_on(0));
    items.push_back(int16(30).read(3).write(0x10).write_on(1));
    auto project = made(items, fc23);
    project.locals[0].admission = model::RateLimit{50ms, 2};
    auto polled_too = read_of(project, {0, 1, 2, 3}, 4);
    auto only_triggered = polled_too;
    only_triggered.period.reset();

    for (const auto& read : {polled_too, only_triggered}) {
        const auto requests = joined_of(project, {read});
        ASSERT_EQ(requests.size(), read.period ? 3U : 2U);
        const Request& both = requests[read.period ? 1 : 0];
        EXPECT_EQ(both.read, wire::Function::read_write_multiple_registers);
        EXPECT_EQ(both.write, wire::Function::read_write_multiple_registers);
        EXPECT_EQ(both.variables, (std::vector<std::size_t>{0, 1, 2, 3, 4, 5}));
        EXPECT_EQ(both.start, 0);
        EXPECT_EQ(both.quantity, 4);
        EXPECT_EQ(both.write_start, 20);
        EXPECT_EQ(both.write_quantity, 2);
        EXPECT_EQ(both.read_trigger, 0U);
        EXPECT_EQ(both.write_trigger, 0U);
        EXPECT_EQ(both.period, std::nullopt);
        EXPECT_EQ(both.admission, (model::RateLimit{50ms, 2}));
        EXPECT_EQ(requests_text({requests.back()}), "10:30+1");
        if (!read.period) continue;
        EXPECT_EQ(requests[0].period, 100ms);
        EXPECT_EQ(requests[0].read, wire::Function::read_holding_registers);
        EXPECT_EQ(requests[0].read_trigger, std::nullopt) << "the polling must not write";
    }
    project.lines[0].devices[0].fc23 = false;
    EXPECT_EQ(joined_of(project, {polled_too}).size(), 3U);
    for (const Request& r : joined_of(project, {polled_too}))
        EXPECT_NE(r.read, wire::Function::read_write_multiple_registers);
}

TEST(Joining, WhatIsOnlyReadWithAWriteDoesNotLimitIt) {
    auto items = row(3, word(0).read_on(0));
    items.push_back(int16(20).read(3).write(0x10).write_on(0));
    auto project = made(items, [](model::Device& device) { device.fc23 = true; });
    auto& device = project.lines[0].devices[0];
    for (std::size_t i = 0; i < 3; ++i) device.variables[i].admission = model::RateLimit{1s, 1};
    auto read = read_of(project, {0, 1, 2}, 3);
    read.period.reset();
    const auto requests = joined_of(project, {read});
    const auto both = std::find_if(requests.begin(), requests.end(), [](const Request& request) {
        return request.write == wire::Function::read_write_multiple_registers;
    });
    ASSERT_NE(both, requests.end());
    EXPECT_EQ(both->variables.size(), 4U);
    EXPECT_EQ(admission_of(project, device, *both), std::nullopt);
    device.variables[3].admission = model::RateLimit{2s, 2};
    project.locals[0].admission = model::RateLimit{3s, 2};
    EXPECT_EQ(admission_of(project, device, *both), (model::RateLimit{3s, 2}));
}

TEST(Joining, WhatDoesNotFitIntoOneTransactionStaysApart) {
    struct Limit {
        int written;
        bool together;
    };
    for (const auto& [written, together] : {Limit{121, true}, Limit{122, false}}) {
        auto items = row(written, int16(200).read(3).write(0x10).write_on(0));
        items.push_back(int16(0).read(3).read_on(0));
        const auto project = made(items, [](model::Device& device) { device.fc23 = true; });
        const auto last = static_cast<std::size_t>(written);
        EXPECT_EQ(joined_of(project, {read_of(project, {last}, 1)}).size(), 2U);
        EXPECT_EQ(joined_of(project, {read_of(project, {last}, 1)})[1].read.has_value(), together) << written;
    }
}

// ---- costs: characters by the specification (RTU)

TEST(Joining, CostsCountEveryTransaction) {
    Request both;
    both.read = both.write = wire::Function::read_write_multiple_registers;
    both.quantity = 4;
    both.write_quantity = 2;
    const auto asked = main_transactions(wire::Framing::rtu, both);
    ASSERT_EQ(asked.size(), 1U);
    EXPECT_EQ(asked[0].request, 13U + 2 * 2);
    EXPECT_EQ(asked[0].response, 5U + 2 * 4);

    Request modify;
    modify.write = wire::Function::write_single_register;
    modify.quantity = 1;
    modify.read_modify_write = true;
    const auto two = main_transactions(wire::Framing::rtu, modify);
    ASSERT_EQ(two.size(), 2U);
    EXPECT_EQ(two[0].request + two[0].response, 8U + 7U);
    EXPECT_EQ(two[1].request + two[1].response, 8U + 8U);

    modify.read_modify_write = false;
    modify.write = wire::Function::mask_write_register;
    const auto mask = main_transactions(wire::Framing::rtu, modify);
    ASSERT_EQ(mask.size(), 1U);
    EXPECT_EQ(mask[0].request + mask[0].response, 10U + 10U);
}

TEST(Joining, AReadModifyWriteIsOneFrameOfTheProof) {
    const auto project = made({bit(0, 3, 6)}, rmw);
    Request modify = writes(project).at(0);
    const TransactionCosts costs(project, project.lines[0]);
    const auto both = costs.of_write(modify);
    ASSERT_EQ(both.size(), 1U);
    modify.read_modify_write = false;
    const auto write = costs.of_write(modify)[0];
    modify.read = wire::Function::read_holding_registers;
    const auto read = costs.of_read(modify)[0];
    EXPECT_EQ(both[0].transaction, read.transaction + write.transaction);
    EXPECT_EQ(both[0].failure, read.transaction + write.failure);
}

TEST(Joining, TheBusTimeOfAReadModifyWriteIsThatOfBoth) {
    Settings settings = kOptimal;
    settings.strategy = model::Strategy::classic;
    const auto project = made({boolean(0, 3).write(0x06).on_change()}, rmw, settings);
    const auto plan = make_plan(project).lines[0];
    ASSERT_EQ(plan.requests.size(), 1U);
    const auto& device = project.lines[0].devices[0];
    EXPECT_EQ(plan.requests[0].request_bytes, 16U);
    EXPECT_EQ(plan.requests[0].response_bytes, 15U);
    // 31 characters of 10 bits at 115200 bit/s, two silences of 1.75 ms, two turnarounds of 5 ms.
    const auto characters = std::chrono::nanoseconds(31 * 10 * 1'000'000'000LL / 115200 + 1);
    EXPECT_EQ(plan.requests[0].bus_time, characters + 2 * 1750us + 2 * estimated_turnaround(device));
}

}  // namespace write_pass_test
}  // namespace takt::plan
