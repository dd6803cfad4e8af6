// The host with its I/O thread, on simulated lines: every wait ends with an event, none with a clock. Servers
// without a port are in endpoints_test.cpp, those with one in tests/host.
#include "takt/host/project_host.hpp"

#include <gtest/gtest.h>

#include <fmt/format.h>

#include <atomic>
#include <fstream>
#include <latch>
#include <set>
#include <thread>
#include <vector>

#include "folder.hpp"
#include "projects.hpp"
#include "running_host.hpp"
#include "takt/store/retained.hpp"

namespace takt::host::test {
namespace project_host_test {

const std::string kPlant = project_with(line_of("main", boiler(), "tcp"));

TEST(ProjectHost, PollsAndCarriesOutCommandsOfSeveralThreads) {
    const auto host = started(kPlant);
    const auto session = *host->open_session({.from_beginning = true});
    ASSERT_TRUE(wait_for<DeviceStateChanged>(
        *session, [](const auto& changed) { return changed.state == poll::DeviceState::answering; }));
    constexpr int kCommands = 50;
    const auto work = [&host](std::int64_t from) {
        const auto own = *host->open_session();
        const auto slot = *own->configuration()->find("Setpoint");
        for (std::int64_t i = from; i < from + kCommands; ++i) {
            ASSERT_TRUE(own->submit({Command::Kind::write, slot, i}));
            const auto outcome = wait_for_outcome(*own);
            ASSERT_TRUE(outcome);
            EXPECT_TRUE(outcome->result == value::CommandResult::done ||
                        outcome->reason == value::Reason::superseded);
            EXPECT_TRUE(value::same(outcome->value, i));
        }
    };
    std::thread one(work, 0);
    std::thread other(work, 1000);
    one.join();
    other.join();
    EXPECT_EQ(session->missed_events(), 0U);
}

TEST(ProjectHost, GivesSnapshotsWhileItRunsAndAfterItHasStopped) {
    const auto host = started(kPlant);
    const auto session = *host->open_session({.from_beginning = true});
    ASSERT_TRUE(wait_for<ValueChanged>(*session, [](const auto&) { return true; }));
    const auto running = session->snapshot({.statistics = true, .plan = true});
    ASSERT_TRUE(running);
    EXPECT_TRUE(running->lines[0].up);
    EXPECT_EQ(running->values.size(), 2U);
    host->stop();
    const auto stopped = session->snapshot({.statistics = true});
    ASSERT_TRUE(stopped);
    EXPECT_GE(stopped->lines[0].devices[0].counters.answered, running->lines[0].devices[0].counters.answered);
    EXPECT_FALSE(session->submit({Command::Kind::get, {0}, {}}));
    EXPECT_FALSE(host->open_session());
}

TEST(ProjectHost, AFailedStartDeliversItsNotices) {
    const ::takt::test::Folder folder;
    const auto registers = folder / "unit.registers";
    std::ofstream(registers) << "a user's notes, longer than a mark";
    std::vector<std::string> notices;
    HostOptions options;
    options.project_file = folder / "plant.yaml";
    options.on_failed_start = [&](const Notice& notice) { notices.push_back(notice.code); };
    auto project = project_of(R"(
takt: 1
servers:
  - name: gate
    listen: 127.0.0.1
    tcp_port: 1
    units:
      - address: 1
        state: unit.registers
        banks: [{area: holding_register, items: [0..9], retain: true}]
)");
    auto plan = plan::make_plan(project);
    const auto host = ProjectHost::start(std::move(project), std::move(plan), options);
    ASSERT_FALSE(host);
    EXPECT_EQ(host.error().code, Code::unsupported);
    EXPECT_EQ(notices, std::vector<std::string>{"endpoint.registers.foreign"});
}

TEST(ProjectHost, ASessionMayOutliveTheHost) {
    auto host = started(kPlant);
    const auto session = *host->open_session({.from_beginning = true});
    host.reset();
    while (session->next_event()) {}
    EXPECT_FALSE(session->snapshot({}));
    EXPECT_FALSE(session->submit({Command::Kind::get, {0}, {}}));
}

TEST(ProjectHost, AppliesAnotherProjectWhileSessionsReadAndCommand) {
    const auto host = started(kPlant);
    const auto session = *host->open_session({.from_beginning = true});
    ASSERT_TRUE(wait_for<ValueChanged>(*session, [](const auto&) { return true; }));
    const auto before = session->snapshot({.statistics = true});
    ASSERT_TRUE(before);
    for (int i = 0; i < 20; ++i) {
        auto project = project_of(kPlant);
        auto plan = plan::make_plan(project);
        ASSERT_TRUE(host->apply(std::move(project), std::move(plan)));
    }
    EXPECT_EQ(host->configuration()->generation(), 21U);
    ASSERT_TRUE(wait_for<ConfigurationChanged>(*session,
                                               [](const auto& changed) { return changed.generation == 21; }));
    ASSERT_TRUE(session->submit(
        {Command::Kind::write, *session->configuration()->find("Setpoint"), std::int64_t{3}}));
    const auto outcome = wait_for_outcome(*session);
    ASSERT_TRUE(outcome);
    EXPECT_EQ(outcome->result, value::CommandResult::done);
    const auto after = session->snapshot({.statistics = true});
    ASSERT_TRUE(after);
    EXPECT_GE(after->lines[0].devices[0].counters.answered, before->lines[0].devices[0].counters.answered);
    EXPECT_EQ(after->lines[0].devices[0].counters.timeouts, 0U);
}

// The state file is read by the thread that applies; the ring of events has one writer, the I/O thread.
TEST(ProjectHost, NoticesOfTheThreadThatAppliesArriveBesideEventsOfTheLines) {
    constexpr int kNames = 2000;
    const takt::test::Folder folder;
    const auto state = folder / "plant.state";
    std::string locals;
    {
        const auto opened = store::RetainedFile::open(state, {});
        ASSERT_TRUE(opened);
        for (int i = 0; i < kNames; ++i) {
            const auto name = fmt::format("local{}", i);
            opened->file->put({.name = name, .type = DataType::int16, .value = std::int64_t{-7}});
            locals += fmt::format("  - {{name: {}, type: bool, retain: true}}\n", name);
        }
        opened->file->close();
    }
    const auto host = started(kPlant, {.state_file = state});
    const auto session = *host->open_session({.from_beginning = true});
    std::atomic<bool> applied = false;
    std::size_t writes = 0;
    std::thread commanding([&] {
        const auto own = *host->open_session();
        for (std::int64_t i = 0; !applied; ++i) {
            ASSERT_TRUE(
                own->submit({Command::Kind::write, *own->configuration()->find("Setpoint"), i % 100}));
            const auto outcome = wait_for_outcome(*own);
            ASSERT_TRUE(outcome);
            writes +=
                outcome->error ? 0U : 1U;  // an error: it came too late for the project that it was meant for
        }
    });
    auto project = project_of(project_with(line_of("main", boiler(), "tcp"), locals));
    auto plan = plan::make_plan(project);
    EXPECT_TRUE(host->apply(std::move(project), std::move(plan)));
    applied = true;
    commanding.join();
    host->stop();
    std::set<std::string> names;
    std::set<CommandId> finished;
    std::uint64_t events = 0;
    while (const auto event = session->next_event()) {
        EXPECT_EQ(event->number, events++);
        if (const auto* const notice = std::get_if<Notice>(&event->body)) {
            EXPECT_EQ(notice->code, "host.retain.other_type");
            for (const auto& [key, value] : notice->arguments)
                EXPECT_TRUE(key != "name" || names.insert(value).second) << value;
        }
        const auto* const write = std::get_if<WriteFinished>(&event->body);
        EXPECT_TRUE(!write || finished.insert(write->outcome.id).second);
    }
    EXPECT_EQ(session->missed_events(), 0U);
    EXPECT_EQ(names.size(), static_cast<std::size_t>(kNames));
    EXPECT_EQ(finished.size(), writes);
}

// With 1000 devices a snapshot takes many slices: the host stops while most of the sessions wait for one.
TEST(ProjectHost, SnapshotsInProgressEndWhenTheHostStops) {
    std::string lines;
    for (int l = 0; l < 10; ++l) {
        std::string devices;
        for (int d = 0; d < 100; ++d)
            devices += device_of(fmt::format("d{}_{}", l, d), d + 1,
                                 variable_of(fmt::format("v{}_{}", l, d), 0, ", period: 1h"));
        lines += line_of(fmt::format("line{}", l), devices, "tcp");
    }
    const auto yaml = project_with(lines);
    for (const bool and_destroy : {false, true}) {
        SCOPED_TRACE(and_destroy);
        auto host = started(yaml);
        std::latch running(4);
        std::vector<std::thread> faces;
        for (int i = 0; i < 4; ++i)
            faces.emplace_back([&running, session = std::shared_ptr<Session>(*host->open_session())] {
                running.count_down();
                const Command get{.kind = Command::Kind::get, .slot = {0}};
                do {
                    const auto state = session->snapshot({.statistics = true}, 30s);
                    EXPECT_TRUE(state ? state->values.size() == 1000U
                                      : state.error().code == Code::connection_lost);
                    while (session->next_outcome()) {}
                } while (session->submit(get));  // until the host has stopped
                const auto last = session->snapshot({}, 30s);
                EXPECT_TRUE(last || last.error().code == Code::connection_lost);
            });
        running.wait();
        host->stop();
        if (and_destroy) host.reset();
        for (auto& face : faces) face.join();
    }
}

}  // namespace project_host_test
}  // namespace takt::host::test
