// Reads and writes of bound variables, with values and outcomes moved by hand.
#include "takt/endpoint/bindings.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "hook_chain.hpp"
#include "loop_turn.hpp"
#include "takt/endpoint/pending_answers.hpp"
#include "takt/line/loop.hpp"

namespace takt::endpoint {
namespace bindings_test {

using namespace std::chrono_literals;
using wire::Area;

/// The slots P (a polled int16), L (a local float), Q (never read).
std::vector<value::SlotInfo> slots() {
    return {{.name = "P", .type = DataType::int16},
            {.name = "L", .type = DataType::float32, .local = true, .initial = 1.5},
            {.name = "Q", .type = DataType::int16}};
}

class Values final : public endpoint::ProjectValues {
public:
    explicit Values(std::vector<value::SlotInfo> made = slots()) : store_(std::move(made)) {}

    [[nodiscard]] const value::Store& store() const override { return store_; }
    [[nodiscard]] Result<bool> set(value::SlotId local, const value::Value& value) override {
        read(local.value, value, Instant{});
        return false;
    }
    [[nodiscard]] Result<bool> write(value::SlotId variable, const value::Value& value,
                                     std::function<void(const value::CommandOutcome&)> done) override {
        if (full) return fail(Code::queue_full, 1);
        commands.push_back({variable, value, std::move(done)});
        return false;
    }

    void read(std::uint32_t slot, value::Value value, Instant t,
              value::Quality quality = value::Quality::good) {
        const value::Update update{value::SlotId{slot}, std::move(value), quality, value::Reason::ok};
        store_.apply(t, {&update, 1});
    }

    struct Command {
        value::SlotId slot;
        value::Value value;
        std::function<void(const value::CommandOutcome&)> done;
    };
    std::vector<Command> commands;
    bool full = false;

private:
    value::Store store_;
};

model::Variable variable(std::uint16_t address, DataType type, Area area = Area::holding_register) {
    model::Variable made;
    made.type = type;
    made.area = area;
    made.register_number = address;
    made.registers = static_cast<std::uint16_t>(register_count(type));
    made.order = {true, true};
    return made;
}

std::string hex(Bytes bytes) {
    std::string text;
    for (const auto byte : bytes) {
        constexpr const char* kDigits = "0123456789ABCDEF";
        text += {kDigits[byte >> 4], kDigits[byte & 15]};
    }
    return text;
}

struct Answers final : serve::AnswerSink {
    bool complete(serve::Token token, Bytes pdu) override {
        completed.emplace_back(token, hex(pdu));
        return true;
    }
    std::vector<std::pair<serve::Token, std::string>> completed;
};

/// A store of registers. While it is slow, the answer waits for it.
struct Keeping final : serve::UnitHooks {
    explicit Keeping(PendingAnswers& of) : pending(of) {}
    std::optional<wire::ExceptionCode> before(const serve::Context&, const serve::Access&) override {
        return std::nullopt;
    }
    void written(const serve::Context&, const serve::Access&) override {
        if (slow) (void)pending.put_off();
    }
    PendingAnswers& pending;
    bool slow = false;
};

/// Holding registers 0..9 (coils: their bits): 0 P, passed on to P; 2..3 P as a float, read only; 4..5 L; 6
/// Q; 7 only written, to P; bit 3 of 8 P as a bool.
struct Bench {
    explicit Bench(bool high_byte_first = true) : loop(*line::Loop::create()) {
        auto& unit = settings.units.emplace_back();
        unit.variables = {variable(0, DataType::int16), variable(2, DataType::float32),
                          variable(4, DataType::float32), variable(6, DataType::int16),
                          variable(7, DataType::int16)};
        auto& bit = unit.variables.emplace_back(variable(8, DataType::boolean));
        bit.bit = std::uint8_t{3};
        bit.order.high_byte_first = high_byte_first;
        const model::VariableSource p{"P"};
        const model::LocalSource l{"L"};
        unit.bindings = {{.variable = 0, .source = p, .sink = p, .max_age = 1s},
                         {.variable = 1, .source = p, .max_age = 1s},
                         {.variable = 2, .source = l, .sink = l},
                         {.variable = 3, .source = model::VariableSource{"Q"}, .max_age = 1s},
                         {.variable = 4, .sink = p, .answer_at_once = false},
                         {.variable = 5, .source = p, .sink = p, .max_age = 1s}};
        units[0].id = UnitId{1};
        units[0].banks.holding_registers.values = registers;
        units[0].banks.coils = {.count = 160, .overlay = serve::BitOverlay{Area::holding_register, 0}};
        inner = serve::Server(units);
        pending.add(answers);
        bound.emplace(settings.units, units, [this] { return pending.put_off_until_called(); });
        hooks.add(bound->hooks(0));
        hooks.add(keeping);
        units[0].hooks = &hooks;
        feeds.emplace(*loop, project, "", values.store());
    }

    void connect() { ASSERT_TRUE(bound->connect(*feeds, values)); }

    /// The answer; of a pending one its token in front.
    std::string ask(std::vector<std::uint8_t> pdu) {
        pending.begin(pdu);
        const auto answer =
            pending.end(inner.handle({.time = now, .unit = UnitId{1}}, wire::RequestView(pdu)));
        if (answer.kind == serve::Answer::Kind::pending) {
            token = answer.token;
            return "pending";
        }
        return hex(answer.pdu);
    }
    std::string read(std::uint8_t start, std::uint8_t count) { return ask({3, 0, start, 0, count}); }
    std::string write(std::uint8_t start, std::uint8_t value) { return ask({6, 0, start, 0, value}); }
    void outcome(value::CommandResult result, value::Reason reason = value::Reason::ok) {
        auto command = std::move(values.commands.front());
        values.commands.erase(values.commands.begin());
        command.done({.result = result, .reason = reason});
    }

    std::unique_ptr<line::Loop> loop;
    model::Project project;
    model::Server settings;
    std::array<std::uint16_t, 10> registers{};
    std::array<serve::Unit, 1> units;
    serve::Server inner{{}};
    Values values;
    Answers answers;
    PendingAnswers pending;
    UnitHookChain hooks;
    Keeping keeping{pending};
    std::optional<endpoint::Feeds> feeds;
    std::optional<endpoint::Bindings> bound;
    Instant now = line::now();
    serve::Token token = 0;
};

TEST(Bindings, ReadsAreOfOneMomentAndNotTooOld) {
    Bench bench;
    EXPECT_EQ(bench.read(0, 1), "830B") << "not connected";
    bench.connect();
    EXPECT_EQ(bench.read(0, 1), "830B") << "never read";
    bench.values.read(0, std::int64_t{-2}, bench.now);
    EXPECT_EQ(bench.read(0, 6), "030CFFFE0000C00000003FC00000");
    EXPECT_EQ(bench.read(1, 1), "03020000") << "bound to nothing";
    EXPECT_EQ(bench.read(5, 2), "830B") << "one of them was never read";
    bench.now = after(bench.now, 1s);
    EXPECT_EQ(bench.read(0, 1), "0302FFFE");
    bench.now = after(bench.now, 1ns);
    EXPECT_EQ(bench.read(0, 1), "830B") << "too old";
    bench.values.read(0, std::int64_t{7}, bench.now, value::Quality::bad);
    EXPECT_EQ(bench.read(0, 1), "830B");
    EXPECT_EQ(bench.read(4, 2), "03043FC00000") << "a local has no age";
}

TEST(Feeds, InstrumentsThatContinueAreNotOpenedAnew) {
    const auto loop = *line::Loop::create();
    const auto project = [](std::initializer_list<const char*> names, Duration timeout) {
        model::Project made;
        for (const char* const name : names) {
            model::Instrument instrument{.name = name, .serial = true, .port = "/nowhere/port"};
            instrument.timeout = timeout;
            instrument.exchanges.push_back(
                {.request = "P", .answer = {.until = ";", .pattern = *model::parse_template("{weight}")}});
            made.instruments.push_back(instrument);
        }
        return made;
    };
    auto first = std::make_unique<model::Project>(project({"scale", "meter"}, 1s));
    Values values;
    endpoint::Feeds feeds(*loop, *first, "", values.store());
    ASSERT_TRUE(feeds.open());
    const auto* const scale = &feeds.counters(0);
    const auto second = project({"new", "scale"}, 1s);
    ASSERT_TRUE(feeds.change(second, values.store()));
    first.reset();
    EXPECT_EQ(&feeds.counters(1), scale);
    takt::test::turn(*loop, 2);
    const auto third = project({"new", "scale"}, 2s);
    ASSERT_TRUE(feeds.change(third, values.store()));
    EXPECT_EQ(feeds.counters(1).requests, 0u);
}

TEST(Bindings, WhatDoesNotFitIsAFailure) {
    Bench bench;
    bench.connect();
    bench.values.read(0, std::int64_t{2}, bench.now);
    EXPECT_EQ(bench.read(8, 1), "8304") << "2 is no bool";
    bench.values.read(0, std::int64_t{1}, bench.now);
    bench.registers[8] = 0x8000;
    EXPECT_EQ(bench.read(8, 1), "03028008") << "its neighbours stay";
}

TEST(Bindings, ABitOfARegisterWithTheLowByteFirst) {
    Bench bench(false);
    bench.connect();
    bench.registers[8] = 0x80;
    bench.values.read(0, std::int64_t{1}, bench.now);
    EXPECT_EQ(bench.read(8, 1), "03020880");
    bench.values.read(0, std::int64_t{0}, bench.now);
    EXPECT_EQ(bench.read(8, 1), "03020080");
}

TEST(Bindings, AWriteIsAnsweredWhenItIsDone) {
    Bench bench;
    bench.connect();
    bench.values.read(0, std::int64_t{5}, bench.now);
    EXPECT_EQ(bench.write(0, 9), "pending");
    ASSERT_EQ(bench.values.commands.size(), 1u);
    EXPECT_EQ(std::get<std::int64_t>(bench.values.commands[0].value), 9);
    EXPECT_EQ(bench.read(0, 1), "03020005") << "it is not done yet";
    const auto waited = bench.token;
    bench.outcome(value::CommandResult::done);
    ASSERT_EQ(bench.answers.completed.size(), 1u);
    EXPECT_EQ(bench.answers.completed[0].first, waited);
    EXPECT_EQ(bench.answers.completed[0].second, "0600000009");
    EXPECT_EQ(bench.read(0, 1), "03020009") << "until it is read again";
    bench.now = after(line::now(), 1ms);
    bench.values.read(0, std::int64_t{8}, bench.now);
    EXPECT_EQ(bench.read(0, 1), "03020008");
}

// In another project a variable and a local have other slots, or none.
TEST(Bindings, WritesFollowTheProjectThatIsConnected) {
    Bench bench;
    bench.connect();
    bench.values.read(0, std::int64_t{5}, bench.now);
    EXPECT_EQ(bench.write(0, 9), "pending");
    ASSERT_EQ(bench.values.commands.size(), 1u);
    EXPECT_EQ(bench.values.commands[0].slot, value::SlotId{0});
    bench.outcome(value::CommandResult::done);

    Values turned({slots()[2], slots()[1], slots()[0]});
    ASSERT_TRUE(bench.feeds->change(bench.project, turned.store()));
    ASSERT_TRUE(bench.bound->reconnect(*bench.feeds, turned));
    turned.read(2, std::int64_t{5}, bench.now);
    EXPECT_EQ(bench.write(0, 7), "pending");
    ASSERT_EQ(turned.commands.size(), 1u);
    EXPECT_EQ(turned.commands[0].slot, value::SlotId{2});
    EXPECT_EQ(std::get<std::int64_t>(turned.commands[0].value), 7);
    EXPECT_TRUE(bench.values.commands.empty());
    EXPECT_EQ(bench.ask({0x10, 0, 4, 0, 2, 4, 0x40, 0x20, 0, 0}), "1000040002");
    EXPECT_EQ(turned.store()[value::SlotId{1}].value, value::Value(2.5));

    Values without({{.name = "other", .type = DataType::int16}});
    ASSERT_TRUE(bench.feeds->change(bench.project, without.store()));
    (void)bench.bound->reconnect(*bench.feeds, without);
    EXPECT_EQ(bench.write(7, 1), "860B");
    EXPECT_TRUE(without.commands.empty());
}

TEST(Bindings, WhatTheDeviceSaysIsTheAnswer) {
    struct Row {
        value::CommandResult result;
        value::Reason reason;
        const char* answer;
    };
    using Result = value::CommandResult;
    using value::Reason;
    const Row rows[] = {
        {Result::refused, value::exception_reason(2), "8602"},
        {Result::refused, value::exception_reason(200), "860B"},
        {Result::refused, Reason::not_answering, "860B"},
        {Result::refused, Reason::differs, "8604"},
        {Result::refused, Reason::superseded, "8606"},
        {Result::unknown, Reason::timeout, "860B"},
        {Result::expired, Reason::ok, "860B"},
        {Result::queue_full, Reason::ok, "8606"},
    };
    Bench bench;
    bench.connect();
    bench.values.read(0, std::int64_t{5}, bench.now);
    for (const auto& [result, reason, answer] : rows) {
        EXPECT_EQ(bench.write(0, 9), "pending");
        bench.outcome(result, reason);
        EXPECT_EQ(bench.answers.completed.back().second, answer);
        EXPECT_EQ(bench.read(0, 1), "03020005") << "the old value";
    }
    bench.values.full = true;
    EXPECT_EQ(bench.write(0, 9), "8606");
}

TEST(Bindings, OnlyWhereAWriteGoesSomewhere) {
    Bench bench;
    EXPECT_EQ(bench.write(4, 1), "860B") << "a part of what is not connected";
    bench.connect();
    bench.values.read(0, std::int64_t{5}, bench.now);
    EXPECT_EQ(bench.write(2, 1), "8602") << "it only has a source";
    EXPECT_EQ(bench.write(1, 1), "0600010001") << "bound to nothing";
    EXPECT_EQ(bench.ask({16, 0, 4, 0, 2, 4, 0x40, 0, 0, 0}), "1000040002");
    EXPECT_EQ(std::get<double>(bench.values.store()[value::SlotId{1}].value), 2);
    EXPECT_EQ(bench.ask({6, 0, 4, 0x40, 0x40}), "0600044040") << "a part: the rest is known";
    EXPECT_EQ(std::get<double>(bench.values.store()[value::SlotId{1}].value), 3);
    EXPECT_TRUE(bench.values.commands.empty());
}

TEST(Bindings, AValueThatIsOnlyWrittenGoesBackWhenItIsRefused) {
    Bench bench;
    bench.connect();
    EXPECT_EQ(bench.write(7, 4), "pending");
    bench.outcome(value::CommandResult::done);
    EXPECT_EQ(bench.read(7, 1), "03020004");
    EXPECT_EQ(bench.write(7, 5), "pending");
    bench.outcome(value::CommandResult::unknown);
    EXPECT_EQ(bench.read(7, 1), "03020004");
}

TEST(Bindings, BitsOfARegisterByTheirCoils) {
    Bench bench;
    bench.connect();
    bench.values.read(0, std::int64_t{1}, bench.now);
    EXPECT_EQ(bench.ask({1, 0, 128, 0, 8}), "010108");
    EXPECT_EQ(bench.ask({5, 0, 128, 0xFF, 0}), "050080FF00") << "a neighbour: nothing to pass on";
    EXPECT_TRUE(bench.values.commands.empty());
    EXPECT_EQ(bench.ask({5, 0, 131, 0, 0}), "pending");
    EXPECT_EQ(std::get<std::int64_t>(bench.values.commands.at(0).value), 0);
    EXPECT_EQ(bench.ask({22, 0, 0, 0xFF, 0xF0, 0, 2}), "pending") << "the masked register";
    EXPECT_EQ(std::get<std::int64_t>(bench.values.commands.at(1).value), 2);
}

TEST(Bindings, AllOfARequestMustBeDone) {
    Bench bench;
    bench.connect();
    bench.values.read(0, std::int64_t{0}, bench.now);
    EXPECT_EQ(bench.ask({16, 0, 7, 0, 2, 4, 0, 1, 0, 8}), "pending");
    ASSERT_EQ(bench.values.commands.size(), 2u);
    bench.outcome(value::CommandResult::done);
    EXPECT_TRUE(bench.answers.completed.empty());
    bench.outcome(value::CommandResult::refused, value::exception_reason(4));
    EXPECT_EQ(bench.answers.completed.at(0).second, "9004");
}

TEST(Bindings, WhatIsKeptAndPassedOnIsAnsweredWhenBothAreDone) {
    using Result = value::CommandResult;
    constexpr PendingAnswers::Refusal kKept;
    constexpr PendingAnswers::Refusal kFailed = wire::ExceptionCode::server_device_failure;
    struct Row {
        bool kept_first;
        Result result;
        PendingAnswers::Refusal kept;
        const char* answer;
    };
    const Row rows[] = {
        {true, Result::done, kKept, "0600000009"}, {false, Result::done, kKept, "0600000009"},
        {true, Result::unknown, kKept, "860B"},    {false, Result::unknown, kKept, "860B"},
        {true, Result::done, kFailed, "8604"},     {false, Result::done, kFailed, "8604"},
    };
    for (const auto& [kept_first, result, kept, answer] : rows) {
        Bench bench;
        bench.connect();
        bench.values.read(0, std::int64_t{5}, bench.now);
        bench.keeping.slow = true;
        EXPECT_EQ(bench.write(0, 9), "pending");
        for (const bool keeps : {kept_first, !kept_first}) {
            EXPECT_TRUE(bench.answers.completed.empty());
            if (keeps)
                bench.pending.done(bench.token, kept);
            else
                bench.outcome(result);
        }
        ASSERT_EQ(bench.answers.completed.size(), 1u);
        EXPECT_EQ(bench.answers.completed[0], std::pair(bench.token, std::string(answer)));
    }
}

TEST(Bindings, WhatIsOnlyKeptIsAnsweredByWhoKeepsIt) {
    Bench bench;
    bench.connect();
    bench.keeping.slow = true;
    EXPECT_EQ(bench.write(1, 1), "pending");
    bench.pending.done(bench.token);
    EXPECT_EQ(bench.answers.completed.at(0).second, "0600010001");
}

}  // namespace bindings_test
}  // namespace takt::endpoint
