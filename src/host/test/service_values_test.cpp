// Service variables of a running project, in virtual time: triggers, enables, the health of devices, `get`.
#include <gtest/gtest.h>

#include "projects.hpp"
#include "rig.hpp"

namespace takt::host::test {
namespace service_values_test {

ProjectEngine::Options options() {
    ProjectEngine::Options options;
    options.started = Instant{1s};
    options.utc_seconds = [] { return std::uint64_t{1'700'000'000}; };
    return options;
}

/// A device whose register 4 is read once a day, and at each pulse.
const std::string kPulsed = project_with(
    line_of("main", boiler(variable_of("Extra", 4, ", period: 24h, read_trigger: system.pulse_1s"))));

/// The fan runs only as long as the boiler answers.
const std::string kDependent =
    project_with(line_of("main", boiler() + pump()) +
                 line_of("other", device_of("Fan", 5, variable_of("Fan speed", 1),
                                            ", poll_enable: system.device.Boiler.answering")));

template <class T>
T value_of(const Rig& rig, const std::string& name) {
    const auto& slot = rig.engine->master().store()[rig.slot(name)];
    EXPECT_EQ(slot.quality, value::Quality::good) << name;
    const auto* const value = std::get_if<T>(&slot.value);
    EXPECT_TRUE(value) << name;
    return value ? *value : T{};
}

value::Value asked(Rig& rig, Session& session, const std::string& name) {
    const auto service = model::ServiceNames(session.configuration()->project()).find(name);
    EXPECT_TRUE(service) << name;
    EXPECT_TRUE(session.submit({.kind = Command::Kind::get, .service = service}));
    rig.serve();
    const auto outcome = session.next_outcome();
    EXPECT_TRUE(outcome && !outcome->error);
    return outcome ? outcome->value : value::Value();
}

std::uint64_t extra_reads(const Rig& rig) {
    const auto& poller = rig.engine->master().line(0);
    const auto& requests = poller.plan().requests;
    for (std::size_t r = 0; r < requests.size(); ++r)
        if (requests[r].read_trigger) return poller.request(r).counters.answered;
    return 0;
}

TEST(ServiceVariablesOfARun, APulsePullsATriggerEachSecond) {
    Rig rig(kPulsed, options());
    rig.run(900ms);
    const auto before = extra_reads(rig);
    rig.run(200ms);
    EXPECT_EQ(extra_reads(rig), before + 1);
    rig.run(9s);
    EXPECT_EQ(extra_reads(rig), before + 10);
}

TEST(ServiceVariablesOfARun, TheFirstCycleWritesOnceAndEnds) {
    const std::string init =
        "          - {name: Init, type: int, register: 20, write: 0x06, write_trigger: system.first_cycle, "
        "default: 5}\n";
    Rig rig(project_with(line_of("main", boiler(init))), options());
    const auto writes = [&] {
        const auto& poller = rig.engine->master().line(0);
        std::uint64_t count = 0;
        for (std::size_t r = 0; r < poller.plan().requests.size(); ++r)
            if (poller.plan().requests[r].write_trigger) count += poller.request(r).counters.answered;
        return count;
    };
    rig.run(0s);
    EXPECT_TRUE(value_of<bool>(rig, "system.first_cycle"));
    rig.run(300ms);
    EXPECT_FALSE(value_of<bool>(rig, "system.first_cycle"));
    EXPECT_EQ(writes(), 1U);
    rig.run(30s);
    EXPECT_EQ(writes(), 1U);
}

TEST(ServiceVariablesOfARun, AnUnchangedValueIsAsOldAsItsComputation) {
    Rig rig(kDependent, options());
    rig.run(10s);
    const auto session = rig.open({.from_beginning = true});
    const auto slot = rig.slot("system.device.Boiler.answering");
    rig.run(20s);
    EXPECT_LE(rig.now - *rig.engine->master().store()[slot].good_at, value::ServiceValues::kEvery);
    std::size_t events = 0;
    for (const auto& changed : take_events_of<ValueChanged>(*session))
        events += changed.slot == slot ? 1U : 0U;
    EXPECT_LE(events, 2U) << "an event for a change only";
}

TEST(ServiceVariablesOfARun, AskedOnesNeedNoSlot) {
    Rig rig(kPulsed, options());
    rig.run(2500ms);
    const auto session = rig.open();
    EXPECT_EQ(asked(rig, *session, "system.time"), value::Value(std::uint64_t{1'700'000'000}));
    EXPECT_EQ(asked(rig, *session, "system.uptime"), value::Value(std::uint64_t{2}));
    EXPECT_EQ(asked(rig, *session, "system.first_cycle"), value::Value(false));
    EXPECT_EQ(asked(rig, *session, "system.device.Boiler.state"), value::Value(std::uint64_t{1}));
    EXPECT_EQ(asked(rig, *session, "system.line.main.up"), value::Value(true));
    EXPECT_GT(std::get<double>(asked(rig, *session, "system.device.Boiler.response_time")), 0);
}

TEST(ServiceVariablesOfARun, AreReadOnlyForEveryFace) {
    Rig rig(kPulsed, options());
    const auto session = rig.open();
    const auto service = model::ServiceNames(session->configuration()->project()).find("system.uptime");
    for (const auto kind : {Command::Kind::set, Command::Kind::write}) {
        const Command used{.kind = kind, .slot = rig.slot("system.pulse_1s"), .value = true};
        const Command unused{.kind = kind, .value = std::uint64_t{5}, .service = service};
        for (const auto& command : {used, unused}) {
            ASSERT_TRUE(session->submit(command));
            rig.serve();
            const auto outcome = session->next_outcome();
            ASSERT_TRUE(outcome && outcome->error);
            EXPECT_EQ(outcome->error->code, Code::read_only);
            EXPECT_EQ(outcome->error->subject.view(), command.service ? "system.uptime" : "system.pulse_1s");
        }
    }
}

TEST(ServiceVariablesOfARun, ADeviceIsPolledWhileAnotherAnswers) {
    Rig rig(kDependent, options());
    const auto fan = [&] { return rig.engine->master().line(1).device(0).state; };
    rig.run(2s);
    EXPECT_EQ(fan(), poll::DeviceState::answering);
    rig.devices(0).find(UnitId{1})->behaviour.dead = true;
    rig.run(10s);
    EXPECT_EQ(fan(), poll::DeviceState::switched_off);
    EXPECT_FALSE(value_of<bool>(rig, "system.device.Boiler.answering"));
    rig.devices(0).find(UnitId{1})->behaviour.dead = false;
    rig.run(70s);
    EXPECT_EQ(fan(), poll::DeviceState::answering);
}

TEST(ServiceVariablesOfARun, AnotherProjectGoesOnWithThem) {
    Rig rig(kPulsed, options());
    rig.run(3s);
    rig.apply(kDependent);
    rig.run(1s);
    EXPECT_TRUE(value_of<bool>(rig, "system.device.Boiler.answering"));
    rig.apply(kPulsed);
    rig.run(900ms);
    const auto before = extra_reads(rig);
    rig.run(3s);
    EXPECT_EQ(extra_reads(rig), before + 3);
}

TEST(ServiceVariablesOfARun, AllocateNothing) {
    Rig rig(kPulsed, options());
    rig.run(5s);
    const auto before = takt::test::allocations().count;
    for (int i = 0; i < 50; ++i) {
        rig.run(100ms);
        const CountingAllocations counting;
        rig.engine->on_tick(rig.now);
    }
    EXPECT_EQ(takt::test::allocations().count, before);
}

}  // namespace service_values_test
}  // namespace takt::host::test
