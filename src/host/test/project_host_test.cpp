// The host with its I/O thread, on simulated lines: every wait ends with an event, none with a clock.
#include "takt/host/project_host.hpp"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

#include "projects.hpp"
#include "rig.hpp"
#include "takt/plan/plan.hpp"

namespace takt::host::test {
namespace {

const std::string kPlant = project_with(line_of("main", boiler(), "tcp"));

std::unique_ptr<ProjectHost> started(const std::string& yaml, const HostOptions& options = {}) {
    auto project = project_of(yaml);
    auto plan = plan::make_plan(project);
    auto host = ProjectHost::start(std::move(project), std::move(plan), options);
    EXPECT_TRUE(host);
    return host ? *std::move(host) : nullptr;
}

template <class Body, class Matches>
std::optional<Body> wait_for(Session& session, Matches matches) {
    for (int waits = 0; waits < 1000; ++waits) {
        while (const auto event = session.next_event())
            if (const auto* body = std::get_if<Body>(&event->body); body && matches(*body)) return *body;
        (void)session.wait(10s);
    }
    return std::nullopt;
}

std::optional<Outcome> wait_for_outcome(Session& session) {
    for (int waits = 0; waits < 1000; ++waits) {
        if (auto outcome = session.next_outcome()) return outcome;
        while (session.next_event()) {
        }
        (void)session.wait(10s);
    }
    return std::nullopt;
}

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

TEST(ProjectHost, ASessionMayOutliveTheHost) {
    auto host = started(kPlant);
    const auto session = *host->open_session({.from_beginning = true});
    host.reset();
    while (session->next_event()) {
    }
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
    ASSERT_TRUE(wait_for<ConfigurationChanged>(*session, [](const auto& changed) { return changed.generation == 21; }));
    ASSERT_TRUE(session->submit({Command::Kind::write, *session->configuration()->find("Setpoint"), std::int64_t{3}}));
    const auto outcome = wait_for_outcome(*session);
    ASSERT_TRUE(outcome);
    EXPECT_EQ(outcome->result, value::CommandResult::done);
    const auto after = session->snapshot({.statistics = true});
    ASSERT_TRUE(after);
    EXPECT_GE(after->lines[0].devices[0].counters.answered, before->lines[0].devices[0].counters.answered);
    EXPECT_EQ(after->lines[0].devices[0].counters.timeouts, 0U);
}

}  // namespace
}  // namespace takt::host::test
