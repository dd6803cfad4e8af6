// What an observer is notified of besides frames.
#include <gtest/gtest.h>

#include "rig.hpp"

namespace takt::bus {
namespace incidents_test {

using test::at;
using test::Rig;
using test::rtu;
using test::transaction;
using namespace std::chrono_literals;
using wire::Incident;

class Log final : public wire::TrafficObserver {
public:
    void on_frame(Instant, wire::Direction, UnitId, Bytes, Bytes) override {}
    void on_fault(Instant, wire::FrameFault, Bytes) override {}
    void on_incident(Instant t, UnitId unit, Incident incident, Duration after) override {
        seen.push_back({t, unit, incident, after});
    }
    struct Seen {
        Instant t;
        UnitId unit;
        Incident incident;
        Duration after;
        friend bool operator==(const Seen&, const Seen&) = default;
    };
    std::vector<Seen> seen;
};

TEST(Incidents, ATimeoutALateAndASurplusResponseAreTold) {
    Log log;
    Rig rig(test::kLine, &log);
    rig.submit(at(0ms), transaction(1, 1, "03 00 6B 00 02", 100ms));
    rig.run_until(at(130ms));
    rig.receive(at(200ms), rtu(1, "03 04 11 11 22 22"));
    rig.receive(at(300ms), rtu(1, "03 04 11 11 22 22"));
    ASSERT_EQ(log.seen.size(), 4U);
    EXPECT_EQ(log.seen[0], (Log::Seen{at(0ms), UnitId{0}, Incident::connected, {}}));
    EXPECT_EQ(log.seen[1].incident, Incident::no_response);
    EXPECT_EQ(log.seen[1].unit, UnitId{1});
    EXPECT_EQ(log.seen[1].after, 100ms);
    EXPECT_EQ(log.seen[2], (Log::Seen{at(200ms), UnitId{1}, Incident::late_response, {}}));
    EXPECT_EQ(log.seen[3], (Log::Seen{at(300ms), UnitId{1}, Incident::surplus_response, {}}));
}

TEST(Incidents, ALinkThatIsLostIsNoTimeout) {
    Log log;
    Rig rig(test::kLine, &log);
    rig.submit(at(0ms), transaction(1, 1, "03 00 6B 00 02", 100ms));
    rig.run_until(at(20ms));
    rig.engine.on_link(at(20ms), false);
    rig.engine.on_link(at(50ms), true);
    std::vector<Incident> incidents;
    for (const auto& its : log.seen) incidents.push_back(its.incident);
    EXPECT_EQ(incidents, (std::vector{Incident::connected, Incident::disconnected, Incident::connected}));
}

}  // namespace incidents_test
}  // namespace takt::bus
