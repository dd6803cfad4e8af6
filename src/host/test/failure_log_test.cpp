// The lines of failed exchanges, as codes with their arguments, in time that the test moves.
#include "sessions/failure_log.hpp"

#include <gtest/gtest.h>

#include <cerrno>
#include <string>
#include <vector>

#include "projects.hpp"
#include "rig.hpp"

namespace takt::host::test {
namespace failure_log_test {

struct Lines {
    std::vector<std::string> all;

    Log log() { return {"host", {nullptr, this, write}}; }
    static void write(void* context, LogLevel, std::string_view, std::string_view code,
                      std::span<const LogArgument> arguments) {
        std::string line(code);
        for (const auto& argument : arguments) {
            line.append(" ").append(argument.name).append("=").append(argument.text);
            if (argument.error != nullptr) line.append(argument.error->subject.view());
        }
        static_cast<Lines*>(context)->all.push_back(line);
    }
    [[nodiscard]] std::size_t with(std::string_view part) const {
        return static_cast<std::size_t>(std::ranges::count_if(
            all, [&](const std::string& line) { return line.find(part) != std::string::npos; }));
    }
};

const std::string kPlant = project_with(line_of("main", pump()));

TEST(FailureLog, NamesLineDeviceRequestReasonTimeAndAttempt) {
    Lines lines;
    Rig rig(kPlant, {.log = lines.log()});
    rig.run(300ms);
    EXPECT_EQ(lines.with("exchange_failed"), 0U);
    rig.devices(0).find(UnitId{2})->behaviour.dead = true;
    rig.run(3s);
    ASSERT_GE(lines.with("log.exchange_failed"), 3U);
    EXPECT_EQ(lines.with("number=1 attempts=3"), 1U);
    EXPECT_EQ(lines.with("number=2 attempts=3"), 1U);
    EXPECT_EQ(lines.with("line=main"), lines.all.size());
    EXPECT_GE(lines.with("request=log.request.3 why=log.why.timeout device="), 3U);
    EXPECT_GE(lines.with("attempt=log.attempt.probe"), 1U);
    EXPECT_EQ(lines.with("state=app.state.not_answering"), 1U);
}

// The bytes begin with a transaction id.
TEST(FailureLog, AConnectionThatTheProgramClosedHasItsReason) {
    const auto project = project_of(kPlant);
    Lines lines;
    FailureLog log(lines.log(), project);
    const auto rejected = [](std::int64_t id, HeaderFault fault) {
        return Error{Code::not_modbus, "h:502", {id << 48, 8, static_cast<std::int64_t>(fault)}};
    };
    log.on_link_closed(Instant{}, 0, rejected(1, HeaderFault::protocol));
    log.on_link_closed(Instant{1s}, 0, rejected(2, HeaderFault::protocol));
    log.on_link_closed(Instant{2s}, 0, rejected(3, HeaderFault::off_by_one));
    log.on_link_closed(Instant{3s}, 0, Error{Code::connection_lost, "h:502", {}});
    EXPECT_EQ(lines.with("log.link_down"), 2U);
    EXPECT_EQ(lines.with("error=h:502"), 2U);
    EXPECT_EQ(lines.with("log.link_closed"), 1U);
    log.finish(Instant{4s});
    EXPECT_EQ(lines.with("log.link_repeated line=main count=1"), 1U);
}

TEST(FailureLog, RepeatedFailuresAreSummarised) {
    const auto project = project_of(kPlant);
    Lines lines;
    FailureLog log(lines.log(), project);
    poll::FailedExchange failed{.device = 0, .unit = UnitId{3}, .took = 100ms};
    Instant now{};
    for (int i = 0; i < 241; ++i, now += 250ms) {
        failed.took += 1us;
        log.on_failed(now, 0, failed);
        log.on_tick(now);
    }
    ASSERT_EQ(lines.all.size(), 2U);
    EXPECT_EQ(lines.with("log.exchange_failed line=main count=0"), 1U);
    EXPECT_EQ(lines.with("log.exchange_repeated line=main count=240 seconds=60"), 1U);
    failed.status = bus::Status::exception;
    failed.exception = 2;
    failed.device.reset();
    log.on_failed(now, 0, failed);
    failed.kind = poll::FailedExchange::Kind::relayed;
    log.on_failed(now, 0, failed);
    EXPECT_EQ(lines.with("where=log.unit attempt=log.attempt.relayed"), 1U) << "another message";
    EXPECT_EQ(lines.with("exception=exception.2"), 2U);
    failed.status = bus::Status::timeout;
    failed.instead = {Mismatch::Part::unit, 5, 1};
    log.on_failed(now, 0, failed);
    EXPECT_EQ(lines.with("other=5 why=log.why.other_unit"), 1U);
    failed.instead->part = Mismatch::Part::transaction;
    for (; failed.instead->came < 9; ++failed.instead->came) log.on_failed(now, 0, failed);
    EXPECT_EQ(lines.with("why=log.why.other_transaction"), 1U);
    failed.instead = {Mismatch::Part::length, 6, 9};
    log.on_failed(now, 0, failed);
    EXPECT_EQ(lines.with("whole=9 other=6 why=log.why.other_length"), 1U);
}

// Each outage has its reason once; equal attempts are counted over minutes that double, and at the end.
TEST(FailureLog, AttemptsToOpenALinkAreCounted) {
    Lines lines;
    Rig rig(kPlant, {.log = lines.log()});
    const auto session = rig.open({.from_beginning = true});
    rig.run(300ms);
    const auto refused = fail(Code::cannot_open, "plc:502", ECONNREFUSED).error();
    auto now = rig.now;
    for (int i = 0; i < 230; ++i, now += 1s) {
        rig.engine->on_link(now, 0, false, refused);
        rig.engine->on_tick(now);
    }
    EXPECT_EQ(lines.with("log.link_down line=main count=0"), 1U);
    EXPECT_EQ(lines.with("log.link_repeated line=main count=60 seconds=60 error=plc:502"), 1U);
    EXPECT_EQ(lines.with("log.link_repeated line=main count=120 seconds=120 error=plc:502"), 1U);
    rig.engine->on_link(now, 0, true, std::nullopt);
    EXPECT_EQ(lines.with("log.link_repeated line=main count=49 seconds=50 error=plc:502"), 1U);
    rig.engine->on_link(now += 1s, 0, false, refused);
    EXPECT_EQ(lines.with("log.link_down line=main count=0"), 2U);
    std::vector<std::uint64_t> repeated;
    for (const auto& event : take_events(*session))
        if (const auto* const link = std::get_if<LinkChanged>(&event.body))
            repeated.push_back(link->repeated);
    EXPECT_EQ(repeated, (std::vector<std::uint64_t>{0, 0, 60, 120, 49, 0, 0}));
}

TEST(FailureLog, EachLineHasItsReasonAtEachChange) {
    constexpr std::size_t kLines = 600;
    std::string all;
    for (std::size_t i = 0; i < kLines; ++i)
        all += line_of("L" + std::to_string(i), device_of("D" + std::to_string(i), 1, ""), "tcp");
    Lines lines;
    Rig rig(project_with(all), {.log = lines.log()});
    const auto refused = fail(Code::cannot_open, "plc:502", ECONNREFUSED).error();
    const auto lost = fail(Code::connection_lost).error();
    for (int round = 0; round < 2; ++round)
        for (std::size_t i = 0; i < kLines; ++i) rig.engine->on_link(rig.now, i, false, refused);
    EXPECT_EQ(lines.with("log.link_down"), kLines);
    const auto session = rig.open();
    for (const auto& why : {lost, refused}) rig.engine->on_link(rig.now, 7, false, why);
    EXPECT_EQ(lines.with("log.link_down line=L7 "), 3U);
    std::vector<std::pair<Code, std::uint64_t>> events;
    for (const auto& event : take_events(*session))
        if (const auto* const link = std::get_if<LinkChanged>(&event.body))
            events.emplace_back(link->why->code, link->repeated);
    EXPECT_EQ(events, (std::vector<std::pair<Code, std::uint64_t>>{
                          {Code::cannot_open, 1}, {Code::connection_lost, 0}, {Code::cannot_open, 0}}));
}

/// A variable that is written on change, and one that is written by a trigger.
const std::string kWriting =
    project_with(line_of("main", device_of("Boiler", 1,
                                           variable_of("Setpoint", 5, kOnChange) +
                                               variable_of("Pulled", 7, ", write: 0x06, write_trigger: go"))),
                 "- {name: go, type: bool}\n");

TEST(FailureLog, WhatFailsOnceAMinuteIsALineEachTime) {
    const auto project = project_of(kPlant);
    for (const Duration period : {31s, 59s, 60s, 61s}) {
        Lines lines;
        FailureLog log(lines.log(), project);
        Instant now{};
        for (int i = 0; i < 10; ++i)
            for (const Instant next = now + period; now < next; now += 250ms) {
                if (now == next - period) log.on_failed(now, 0, {.device = 0, .unit = UnitId{3}});
                log.on_tick(now);
            }
        EXPECT_EQ(lines.with("log.exchange_failed"), 10U) << period.count();
        EXPECT_EQ(lines.all.size(), 10U) << period.count();
    }
}

TEST(FailureLog, WritesHaveValueCauseAndReason) {
    Lines lines;
    Rig rig(kWriting, {.log = lines.log()});
    rig.run(300ms);
    const auto session = rig.open();
    rig.devices(0).find(UnitId{1})->behaviour.dead = true;
    ASSERT_TRUE(session->submit(
        {.kind = Command::Kind::write, .slot = rig.slot("Setpoint"), .value = std::int64_t{5}}));
    ASSERT_TRUE(
        session->submit({.kind = Command::Kind::set, .slot = rig.slot("Pulled"), .value = std::int64_t{8}}));
    ASSERT_TRUE(session->submit({.kind = Command::Kind::set, .slot = rig.slot("go"), .value = true}));
    rig.run(3s);
    EXPECT_EQ(lines.with("app.write.unknown line=main device=Boiler unit=1 name=Setpoint wanted=5 "
                         "cause=app.write.by_write why=app.reason.timeout where=log.device"),
              1U);
    EXPECT_EQ(lines.with("name=Pulled wanted=8 trigger=go cause=app.write.by_trigger why=app.reason."), 1U);
    EXPECT_EQ(lines.with("app.overrun"), 0U) << "a device that does not answer is only probed";
}

TEST(FailureLog, WithoutASinkNothingIsKept) {
    const auto project = project_of(kPlant);
    FailureLog log(Log(), project);
    log.on_failed(Instant{}, 0, {});
    log.finish(Instant{});
}

}  // namespace failure_log_test
}  // namespace takt::host::test
