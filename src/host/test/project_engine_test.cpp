// The host's engine in virtual time: events, commands and snapshots as a face sees them.
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <map>
#include <set>

#include "projects.hpp"
#include "rig.hpp"

namespace takt::host::test {
namespace project_engine_test {

using value::CommandResult;

const std::string kPlant =
    project_with(line_of("main", boiler(variable_of("Limit", 20, ", write: 0x06")) + pump(kOnChange)),
                 "  - {name: go, type: bool}\n");

Outcome only_outcome(Session& session) {
    auto outcome = session.next_outcome();
    EXPECT_TRUE(outcome);
    EXPECT_FALSE(session.next_outcome()) << "one command has one outcome";
    return outcome.value_or(Outcome{});
}

TEST(ProjectEngine, PublishesLinksDevicesAndValues) {
    Rig rig(kPlant);
    const auto session = rig.open({.from_beginning = true});
    rig.run(300ms);
    std::set<std::string> named;
    bool link = false;
    std::size_t answering = 0;
    for (const auto& event : take_events(*session)) {
        if (const auto* changed = std::get_if<ValueChanged>(&event.body)) {
            named.insert(session->configuration()->info(changed->slot).name);
            EXPECT_EQ(changed->quality, value::Quality::good);
            EXPECT_TRUE(changed->good_at);
        }
        if (const auto* up = std::get_if<LinkChanged>(&event.body)) link = up->up;
        if (const auto* state = std::get_if<DeviceStateChanged>(&event.body))
            answering += state->state == poll::DeviceState::answering ? 1U : 0U;
    }
    EXPECT_TRUE(link);
    EXPECT_EQ(answering, 2U);
    EXPECT_EQ(named, (std::set<std::string>{"Level", "Limit", "Setpoint", "Speed"}));
}

// The first changes are shown, then one event that there are many, and one when they end. None is lost: each
// is published, for those that follow the state.
TEST(ProjectEngine, AFlappingDeviceDoesNotFillTheEvents) {
    Rig rig(kPlant);
    const auto session = rig.open({.from_beginning = true});
    using Shown = DeviceStateChanged::Shown;
    std::map<Shown, std::vector<DeviceStateChanged>> seen;
    const auto run = [&](Duration length) {
        rig.run(length);
        for (const auto& event : take_events(*session))
            if (const auto* changed = std::get_if<DeviceStateChanged>(&event.body);
                changed && changed->device == 0)
                seen[changed->shown].push_back(*changed);
    };
    run(1s);
    for (int i = 0; i < 20; ++i) {
        rig.devices(0).find(UnitId{1})->behaviour.dead = true;
        run(3s);
        rig.devices(0).find(UnitId{1})->behaviour.dead = false;
        run(3s);
    }
    EXPECT_EQ(seen[Shown::each].size(), 5U);
    ASSERT_EQ(seen[Shown::often].size(), 1U);
    EXPECT_EQ(seen[Shown::often][0].changes, 6U);
    EXPECT_EQ(seen[Shown::counted].size(), 41U - 6U);
    EXPECT_TRUE(seen[Shown::steady].empty());
    run(40s);
    ASSERT_EQ(seen[Shown::steady].size(), 1U);
    EXPECT_EQ(seen[Shown::steady][0].changes, 41U);
    EXPECT_EQ(seen[Shown::steady][0].state, poll::DeviceState::answering);
    rig.devices(0).find(UnitId{1})->behaviour.dead = true;
    run(3s);
    EXPECT_EQ(seen[Shown::each].size(), 6U) << "it is shown again";
}

TEST(ProjectEngine, ATriggerActsEachTimeItIsPulled) {
    Rig rig(kPlant);
    const auto session = rig.open();
    rig.run(300ms);
    const auto pull = [&](const char* name) {
        EXPECT_TRUE(session->submit({.kind = Command::Kind::pull, .slot = rig.slot(name), .value = {}}));
        rig.serve();
        return only_outcome(*session);
    };
    const auto rises = [&] {
        std::size_t count = 0;
        while (const auto event = session->next_event())
            if (const auto* const changed = std::get_if<ValueChanged>(&event->body))
                count += changed->slot == rig.slot("go") && value::same(changed->value, true) ? 1U : 0U;
        return count;
    };
    for (int i = 0; i < 2; ++i) {
        (void)rises();
        EXPECT_EQ(pull("go").result, CommandResult::done);
        EXPECT_EQ(rises(), 1U) << i;
    }
    EXPECT_EQ(pull("Speed").error->code, Code::unsupported);
}

TEST(ProjectEngine, ProbesADeviceOnRequest) {
    Rig rig(kPlant);
    const auto session = rig.open();
    rig.run(300ms);
    const auto probe = [&](const char* name) {
        EXPECT_TRUE(session->submit({.kind = Command::Kind::probe, .slot = rig.slot(name), .value = {}}));
        rig.serve();
        return only_outcome(*session);
    };
    EXPECT_EQ(probe("Speed").result, CommandResult::refused) << "it answers";
    EXPECT_EQ(probe("go").error->code, Code::unsupported);
    rig.devices(0).find(UnitId{2})->behaviour.dead = true;
    rig.run(30s);
    rig.devices(0).find(UnitId{2})->behaviour.dead = false;
    const auto outcome = probe("Speed");
    EXPECT_EQ(outcome.result, CommandResult::done);
    EXPECT_EQ(outcome.kind, Command::Kind::probe);
    rig.run(500ms);
    const auto snapshot = rig.snapshot({.values = false, .statistics = true, .times = true});
    const auto& line = snapshot->snapshot.lines[0];
    EXPECT_EQ(line.devices[1].state, poll::DeviceState::answering);
    ASSERT_EQ(line.request_times.size(), line.requests.size());
    EXPECT_FALSE(line.request_times[0].buckets.empty());
    EXPECT_GT(snapshot->snapshot.line_times.at(0).turnaround.count, 0U);
}

TEST(ProjectEngine, SendsRequestsOfGuestsBesidePolling) {
    Rig rig(kPlant);
    const auto session = rig.open();
    rig.run(300ms);
    const auto ask = [&](std::uint8_t unit, std::vector<std::uint8_t> pdu) {
        EXPECT_TRUE(
            session->submit({.kind = Command::Kind::exchange,
                             .exchange = Command::Exchange{.unit = UnitId{unit}, .pdu = std::move(pdu)},
                             .expires = rig.now + 5s}));
        rig.serve();
    };
    const std::vector<std::uint8_t> read{3, 0, 0, 0, 1};
    ask(2, read);
    ask(2, read);
    EXPECT_EQ(only_outcome(*session).error->code, Code::queue_full) << "one at a time";
    rig.run(500ms);
    const auto answered = only_outcome(*session);
    EXPECT_EQ(answered.result, CommandResult::done);
    ASSERT_EQ(answered.response.size(), 4u);
    EXPECT_EQ(answered.response[0], 3);
    ask(99, read);
    rig.run(1s);
    const auto silent = only_outcome(*session);
    EXPECT_EQ(silent.result, CommandResult::unknown);
    EXPECT_EQ(silent.reason, value::Reason::timeout);
    EXPECT_TRUE(silent.response.empty());
    ask(99, {});
    EXPECT_EQ(only_outcome(*session).error->code, Code::out_of_range);
}

TEST(ProjectEngine, LostEventsAreReportedBeforeThoseThatFollow) {
    Rig rig(kPlant);
    rig.run(300ms);
    const auto session = rig.open();
    const auto local = rig.slot("go");
    constexpr std::uint64_t kMore = 10;
    for (std::uint64_t i = 0; i < value::Store::kDefaultEvents + kMore; ++i)
        ASSERT_TRUE(rig.engine->set_local(rig.now, local, i % 2 == 0));
    rig.engine->publish(rig.now);
    const auto events = take_events(*session);
    EXPECT_EQ(session->missed_events(), 0U);
    ASSERT_EQ(events.size(), value::Store::kDefaultEvents + 1);
    const auto* lost = std::get_if<EventsLost>(&events.front().body);
    ASSERT_NE(lost, nullptr);
    EXPECT_EQ(lost->count, kMore);
}

TEST(ProjectEngine, EveryKindOfCommandHasOneOutcome) {
    Rig rig(kPlant);
    const auto session = rig.open();
    rig.run(300ms);
    struct Case {
        Command::Kind kind;
        const char* name;
        value::Value value;
    };
    const Case cases[] = {{Command::Kind::set, "Setpoint", std::int64_t{7}},
                          {Command::Kind::write, "Limit", std::int64_t{8}},
                          {Command::Kind::set, "go", true},
                          {Command::Kind::write, "go", false}};
    CommandId last = 0;
    for (const auto& [kind, name, value] : cases) {
        SCOPED_TRACE(name);
        const auto id = session->submit({kind, rig.slot(name), value});
        ASSERT_TRUE(id);
        EXPECT_EQ(*id, ++last);
        rig.run(300ms);
        const auto outcome = only_outcome(*session);
        EXPECT_EQ(outcome.id, *id);
        EXPECT_EQ(outcome.kind, kind);
        EXPECT_EQ(outcome.result, CommandResult::done);
        EXPECT_EQ(outcome.progress, Outcome::Progress::settled);
        EXPECT_FALSE(outcome.error);
        EXPECT_TRUE(value::same(outcome.value, value));
    }
    const auto got = session->submit({Command::Kind::get, rig.slot("Setpoint"), {}});
    ASSERT_TRUE(got);
    EXPECT_EQ(*got, 0U);
    rig.serve();
    EXPECT_TRUE(value::same(only_outcome(*session).value, std::int64_t{7}));
}

TEST(ProjectEngine, RefusesACommandWithAnErrorWhereNothingCanBeWritten) {
    Rig rig(kPlant);
    const auto session = rig.open();
    ASSERT_TRUE(session->submit({Command::Kind::write, rig.slot("Level"), std::int64_t{1}}));
    rig.serve();
    const auto outcome = only_outcome(*session);
    ASSERT_TRUE(outcome.error);
    EXPECT_EQ(outcome.error->code, Code::not_writable);
}

TEST(ProjectEngine, OnlyTheSessionThatAskedGetsTheOutcomeAndEverySessionTheEvent) {
    Rig rig(kPlant);
    const auto asking = rig.open();
    const auto other = rig.open();
    rig.run(300ms);
    ASSERT_TRUE(asking->submit({Command::Kind::write, rig.slot("Limit"), std::int64_t{3}}));
    rig.run(300ms);
    EXPECT_TRUE(asking->next_outcome());
    EXPECT_FALSE(other->next_outcome());
    for (auto* session : {asking.get(), other.get()}) {
        const auto finished = take_events_of<WriteFinished>(*session);
        ASSERT_EQ(finished.size(), 1U);
        EXPECT_EQ(finished[0].session, asking->id());
        EXPECT_EQ(finished[0].outcome.result, CommandResult::done);
    }
}

TEST(ProjectEngine, ASetOfADeviceThatDoesNotAnswerEndsAsWaiting) {
    Rig rig(kPlant);
    rig.devices(0).find(UnitId{2})->behaviour.dead = true;
    const auto session = rig.open();
    rig.run(3s);
    ASSERT_TRUE(session->submit({Command::Kind::set, rig.slot("Speed"), std::int64_t{9}}));
    rig.serve();
    EXPECT_EQ(only_outcome(*session).progress, Outcome::Progress::waiting);
}

TEST(ProjectEngine, ASetThatNothingSendsSaysSo) {
    Rig rig(kPlant);
    const auto session = rig.open();
    rig.run(300ms);
    for (const auto& [name, progress] :
         {std::pair("Limit", Outcome::Progress::not_written), std::pair("go", Outcome::Progress::settled)}) {
        ASSERT_TRUE(session->submit({Command::Kind::set, rig.slot(name), std::int64_t{1}}));
        rig.serve();
        EXPECT_EQ(only_outcome(*session).progress, progress) << name;
    }
}

TEST(ProjectEngine, ACommandExpiresAtItsInstantAndIsNotExecutedLater) {
    Rig rig(kPlant);
    const auto session = rig.open();
    rig.run(300ms);
    const auto finish = [&](Command::Kind kind, const char* name, const value::Value& value,
                            Instant expires) {
        EXPECT_TRUE(
            session->submit({.kind = kind, .slot = rig.slot(name), .value = value, .expires = expires}));
        rig.serve();
        return session->next_outcome();
    };
    for (const auto kind : {Command::Kind::set, Command::Kind::write})
        EXPECT_EQ(finish(kind, "Setpoint", std::int64_t{4}, rig.now)->result, CommandResult::expired);
    EXPECT_EQ(finish(Command::Kind::set, "go", true, rig.now)->result, CommandResult::expired);
    EXPECT_EQ(finish(Command::Kind::set, "go", true, rig.now + 1ms)->result, CommandResult::done);
}

TEST(ProjectEngine, AWriteToADeadDeviceIsNotLeftWithoutOutcomeBeyondItsExpiry) {
    Rig rig(kPlant);
    rig.devices(0).find(UnitId{2})->behaviour.dead = true;
    const auto session = rig.open();
    rig.run(3s);
    const auto sent = rig.now;
    ASSERT_TRUE(session->submit({.kind = Command::Kind::write,
                                 .slot = rig.slot("Speed"),
                                 .value = std::int64_t{9},
                                 .expires = sent + 400ms}));
    rig.run(500ms);
    const auto outcome = only_outcome(*session);
    EXPECT_EQ(outcome.result, CommandResult::refused) << "known not to answer: not sent";
    EXPECT_EQ(outcome.reason, value::Reason::not_answering);
    EXPECT_LE(outcome.t, sent + 450ms);
}

TEST(ProjectEngine, ALaterSetSupersedesAnEarlierOne) {
    Rig rig(kPlant);
    const auto session = rig.open();
    rig.run(300ms);
    const auto first = session->submit({Command::Kind::set, rig.slot("Setpoint"), std::int64_t{1}});
    const auto second = session->submit({Command::Kind::set, rig.slot("Setpoint"), std::int64_t{2}});
    rig.run(300ms);
    std::map<CommandId, Outcome> outcomes;
    while (const auto outcome = session->next_outcome()) outcomes[outcome->id] = *outcome;
    ASSERT_EQ(outcomes.size(), 2U);
    EXPECT_EQ(outcomes[*first].progress, Outcome::Progress::superseded);
    EXPECT_EQ(outcomes[*second].progress, Outcome::Progress::settled);
}

TEST(ProjectEngine, TheEndOfTheRunGivesEveryCommandItsOutcome) {
    Rig rig(kPlant);
    rig.devices(0).find(UnitId{2})->behaviour.dead = true;
    const auto session = rig.open();
    rig.run(20ms);
    ASSERT_TRUE(session->submit({Command::Kind::set, rig.slot("Speed"), std::int64_t{9}}));
    ASSERT_TRUE(session->submit({Command::Kind::write, rig.slot("Limit"), std::int64_t{9}}));
    rig.serve();
    rig.engine->finish(rig.now);
    std::size_t outcomes = 0;
    while (session->next_outcome()) ++outcomes;
    EXPECT_EQ(outcomes, 2U);
}

TEST(ProjectEngine, WritesThatWereNeverSentExpireAtTheEndAndAreReported) {
    Rig rig(kPlant);
    const auto session = rig.open();
    rig.run(300ms);
    constexpr std::size_t kWrites = 50;
    for (std::size_t i = 0; i < kWrites; ++i)
        ASSERT_TRUE(session->submit({Command::Kind::write, rig.slot("Limit"), std::int64_t{5}}));
    rig.serve();
    rig.engine->finish(rig.now);
    std::size_t expired = 0;
    std::size_t others = 0;
    while (const auto outcome = session->next_outcome())
        (outcome->result == CommandResult::expired ? expired : others)++;
    EXPECT_EQ(expired + others, kWrites);
    EXPECT_LE(others, 1U) << "the one in flight";
    EXPECT_EQ(take_events_of<WriteFinished>(*session).size(), kWrites);
}

TEST(ProjectEngine, ASnapshotHasWhatWasAskedFor) {
    Rig rig(kPlant);
    rig.run(500ms);
    const auto buffer = rig.snapshot({.statistics = true, .plan = true});
    const auto& snapshot = buffer->snapshot;
    ASSERT_EQ(snapshot.values.size(), 5U);
    EXPECT_EQ(snapshot.values[rig.slot("Level").value].quality, value::Quality::good);
    ASSERT_EQ(snapshot.lines.size(), 1U);
    const auto& line = snapshot.lines[0];
    EXPECT_TRUE(line.up);
    ASSERT_EQ(line.devices.size(), 2U);
    EXPECT_EQ(line.devices[0].state, poll::DeviceState::answering);
    EXPECT_EQ(line.variables.size(), 4U);
    ASSERT_TRUE(line.plan);
    ASSERT_EQ(line.requests.size(), line.plan->requests.size());
    EXPECT_GT(line.requests[0].counters.answered, 0U);
    EXPECT_GT(line.statistics.utilization, 0.0);
}

TEST(ProjectEngine, TakingASnapshotAllocatesNothingOnTheIoThread) {
    Rig rig(kPlant);
    rig.run(500ms);
    endpoint::Statistics names;
    names.listeners.push_back(
        {.where = "tcp://127.0.0.1:1502, longer than a short string", .counters = {}, .connections = {}});
    rig.link->set_endpoint_names(std::make_shared<const endpoint::Statistics>(names));
    rig.engine->set_endpoint_counters([](const EndpointNames&, endpoint::Statistics& into) {
        into.listeners.at(0).counters.unanswered = 5;
        return true;
    });
    const auto before = takt::test::allocations().count;
    const auto buffer = rig.snapshot({.statistics = true, .plan = true, .learnt = true, .endpoints = true});
    EXPECT_EQ(takt::test::allocations().count, before);
    EXPECT_FALSE(buffer->too_small);
    ASSERT_EQ(buffer->snapshot.endpoints.listeners.size(), 1U);
    EXPECT_EQ(buffer->snapshot.endpoints.listeners[0].where, names.listeners[0].where);
    EXPECT_EQ(buffer->snapshot.endpoints.listeners[0].counters.unanswered, 5U);
}

// As many lines and values as the project that runs, but not on as many devices.
TEST(ProjectEngine, ASnapshotMadeForAnotherProjectIsNotFilled) {
    Rig rig(project_with(line_of("main", boiler(variable_of("Limit", 20) + variable_of("Speed", 21))),
                         "  - {name: go, type: bool}\n"));
    const auto buffer = make_snapshot_buffer(rig.engine->configuration(), nullptr, {.statistics = true}, 0);
    ASSERT_TRUE(rig.link->post(std::make_unique<SnapshotFill>(buffer)));
    rig.apply(kPlant);
    rig.serve();
    ASSERT_TRUE(buffer->ready.try_acquire());
    EXPECT_TRUE(buffer->too_small);
}

// An event while it is copied may be newer than a value that was copied before.
TEST(ProjectEngine, ASnapshotNamesTheFirstEventThatMayBeNewer) {
    Rig rig(kPlant);
    const auto session = rig.open({.from_beginning = true});
    rig.run(300ms);
    const auto before = take_events(*session).back().number;
    const auto buffer = make_snapshot_buffer(rig.engine->configuration(), nullptr, {.statistics = true}, 0);
    ASSERT_TRUE(rig.link->post(std::make_unique<SnapshotFill>(buffer)));
    ASSERT_TRUE(rig.engine->serve(rig.now)) << "it takes several slices";
    rig.engine->publish_event(rig.now, ConfigurationChanged{});
    rig.serve();
    ASSERT_TRUE(buffer->ready.try_acquire());
    EXPECT_EQ(buffer->snapshot.first_newer_event, before + 1);
}

TEST(ProjectEngine, ASnapshotThatIsBegunWhenAnotherProjectIsAppliedEnds) {
    Rig rig(kPlant);
    const auto buffer = make_snapshot_buffer(rig.engine->configuration(), nullptr, {.statistics = true}, 0);
    ASSERT_TRUE(rig.link->post(std::make_unique<SnapshotFill>(buffer)));
    ASSERT_TRUE(rig.engine->serve(rig.now)) << "it takes several slices";
    rig.apply(kPlant);
    rig.serve();
    ASSERT_TRUE(buffer->ready.try_acquire());
    EXPECT_TRUE(buffer->too_small) << "the session asks again";
}

std::string many_devices(int lines, int devices_a_line) {
    std::string all;
    for (int l = 0; l < lines; ++l) {
        std::string devices;
        for (int d = 0; d < devices_a_line; ++d) {
            std::string variables;
            for (int v = 0; v < 4; ++v)
                variables += variable_of(fmt::format("v{}_{}_{}", l, d, v), v, ", period: 1s");
            devices += device_of(fmt::format("d{}_{}", l, d), d + 1, variables);
        }
        all += line_of(fmt::format("line{}", l), devices, "tcp");
    }
    return project_with(all);
}

// Two subscribers, one of which never reads. The ring is smaller than what 500 devices report in this time.
TEST(ProjectEngine, FiveHundredDevicesArePolledWithoutAllocatingForAnySubscriber) {
    Rig rig(many_devices(20, 25));
    const auto reading = rig.open({.from_beginning = true});
    const auto silent = rig.open({.from_beginning = true});
    rig.run(3s);  // learns the sizes of its buffers
    (void)take_events(*reading);
    const auto missed_before = reading->missed_events();
    const auto before = takt::test::allocations().count;
    std::size_t read = 0;
    for (int second = 0; second < 40; ++second) {
        rig.run(1s);
        read += take_events_of<ValueChanged>(*reading).size();
    }
    EXPECT_EQ(takt::test::allocations().count, before) << "allocations in the engines and in publish()";
    EXPECT_EQ(reading->missed_events(), missed_before);
    EXPECT_GT(read, 10'000U);
    std::size_t left = 0;
    while (silent->next_event()) ++left;
    EXPECT_GT(silent->missed_events(), 0U);
    EXPECT_GT(left, 0U);
    for (std::size_t l = 0; l < 20; ++l)
        for (std::size_t d = 0; d < 25; ++d) {
            const auto& device = rig.engine->master().line(l).device(d);
            EXPECT_GE(device.counters.answered, 40U);
            EXPECT_EQ(device.counters.sent, device.counters.answered);
        }
}

TEST(ProjectEngine, ATapGetsTheFramesAndCostsNothingWhenItIsClosed) {
    Rig rig(kPlant);
    rig.run(200ms);
    {
        const auto tap = rig.open({.traffic = true});
        rig.run(300ms);
        std::size_t sent = 0;
        std::size_t received = 0;
        while (const auto record = tap->next_traffic()) {
            EXPECT_FALSE(record->fault);
            EXPECT_GT(record->raw.size(), record->pdu.size());
            (record->direction == wire::Direction::sent ? sent : received)++;
        }
        EXPECT_GT(sent, 5U);
        EXPECT_EQ(received, sent);
    }
    const auto end = rig.link->traffic.end().position;
    rig.run(300ms);
    EXPECT_EQ(rig.link->traffic.end().position, end);
}

}  // namespace project_engine_test
}  // namespace takt::host::test
