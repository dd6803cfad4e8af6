#include "takt/host/session.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "projects.hpp"
#include "rig.hpp"

namespace takt::host::test {
namespace session_test {

const std::string kPlant = project_with(line_of("main", boiler()));

TEST(Session, CountsTheEventsThatItMissedFromItsFirstReadOn) {
    Rig rig(kPlant);
    const auto session = rig.open();
    const auto events = static_cast<std::uint64_t>(Rig::kRingWords);  // more than the ring can hold
    for (std::uint64_t i = 0; i < events; ++i) rig.engine->publish_event(rig.now, EventsLost{i});
    std::uint64_t read = 0;
    while (session->next_event()) ++read;
    EXPECT_GT(session->missed_events(), 0U);
    EXPECT_EQ(read + session->missed_events(), events);
}

TEST(Session, BeginsWithTheOldestEventOnlyIfAskedTo) {
    Rig rig(kPlant);
    rig.run(200ms);
    const auto early = rig.open({.from_beginning = true});
    const auto late = rig.open();
    const auto deaf = rig.open({.events = false, .from_beginning = true});
    EXPECT_TRUE(early->next_event());
    EXPECT_FALSE(late->next_event());
    EXPECT_FALSE(deaf->next_event());
    EXPECT_EQ(early->missed_events() + late->missed_events(), 0U);
}

TEST(Session, RefusesACommandBeyondItsLimitAndAcceptsAgainWhenOutcomesAreTaken) {
    Rig rig(kPlant);
    const auto session = rig.open();
    const Command get{.kind = Command::Kind::get, .slot = rig.slot("Level"), .tag = 5};
    for (std::size_t i = 0; i < Session::kMostCommands; ++i) ASSERT_TRUE(session->submit(get));
    const auto refused = session->submit(get);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, Code::queue_full);
    rig.serve();
    std::size_t outcomes = 0;
    while (const auto outcome = session->next_outcome()) {
        EXPECT_EQ(outcome->tag, 5U);
        ++outcomes;
    }
    EXPECT_EQ(outcomes, Session::kMostCommands);
    EXPECT_TRUE(session->submit(get));
}

TEST(Session, ASlotIsUsedAgainAndItsNewSessionGetsNoOutcomeOfTheOldOne) {
    Rig rig(kPlant);
    const Command get{.kind = Command::Kind::get, .slot = rig.slot("Level")};
    SessionId first = 0;
    {
        const auto session = rig.open();
        first = session->id();
        ASSERT_TRUE(session->submit(get));
    }
    const auto session = rig.open();
    EXPECT_NE(session->id(), first);
    rig.serve();
    EXPECT_FALSE(session->next_outcome());
}

TEST(Session, AtMostSixtyFourAreOpen) {
    Rig rig(kPlant);
    std::vector<std::unique_ptr<Session>> sessions;
    for (std::size_t i = 0; i < HostLink::kMostSessions; ++i) sessions.push_back(rig.open());
    EXPECT_EQ(rig.link->open_session(), 0U);
    sessions.pop_back();
    EXPECT_NE(rig.link->open_session(), 0U);
}

TEST(Session, WaitsNoLongerThanForSomethingToRead) {
    Rig rig(kPlant);
    const auto session = rig.open();
    EXPECT_FALSE(session->wait(Duration::zero()));
    rig.run(200ms);
    EXPECT_TRUE(session->wait(1h));
    (void)take_events(*session);
    EXPECT_FALSE(session->rearm());
    rig.engine->publish_event(rig.now, EventsLost{1});
    rig.link->notify();
    EXPECT_TRUE(session->wait(1h));
}

TEST(Session, GetsASnapshotOfAHostWithoutAThread) {
    Rig rig(kPlant);
    const auto session = rig.open();
    std::size_t posted = 0;
    rig.link->on_posted = [&](const HostRequest&) {
        ++posted;
        rig.serve();
    };
    const auto snapshot = session->snapshot({}, 0ns);
    ASSERT_TRUE(snapshot);
    EXPECT_EQ(snapshot->t, rig.now);
    EXPECT_EQ(snapshot->values.size(), rig.engine->configuration()->slot_count());
    EXPECT_EQ(posted, 1U);
}

TEST(Session, RefusesCommandsOfAHostThatHasStoppedAndGivesThemAnOutcome) {
    Rig rig(kPlant);
    const auto session = rig.open();
    const Command get{.kind = Command::Kind::get, .slot = rig.slot("Level")};
    ASSERT_TRUE(session->submit(get));
    rig.link->stopped = true;
    rig.link->refuse_rest();
    const auto late = session->next_outcome();
    ASSERT_TRUE(late);
    EXPECT_EQ(late->result, value::CommandResult::expired);
    EXPECT_FALSE(session->submit(get));
}

}  // namespace session_test
}  // namespace takt::host::test
