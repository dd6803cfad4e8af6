// TCP peers that close their connections, in virtual time. takt-sim has them at random (tests/sim).
#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <functional>
#include <set>

#include "takt/plan/plan.hpp"
#include "tcp_frames.hpp"

namespace takt::poll {
namespace closing_peer_test {

using namespace test;

constexpr Duration kWay = 1ms;  // of a segment
constexpr Duration kRun = 30s;

enum class Closes { never, after_each, after_third, with_several };

struct Peer {
    Closes closes = Closes::never;
    std::set<int> dead;  ///< units: closes for each request
    Duration thinks = 5ms;
    std::function<void(Frame&)> spoils{};  ///< the response to unit 1, register 100
};

/// A line to that peer, and what it did.
class World {
public:
    World(model::Project project, Peer peer)
        : project_(std::move(project)),
          plan_(plan::make_plan(project_)),
          master_(project_, plan_),
          peer_(std::move(peer)) {
        line().on_link(now_, true);
        connected_ = true;
    }

    void run(Duration length) {
        const Instant end = now_ + length;
        for (settle(); now_ < end; settle()) {
            Instant next = std::min({end, line().next_wakeup(), closes_at_, opens_at_, wanted_at_});
            if (!to_peer_.empty()) next = std::min(next, to_peer_.front().first);
            if (!to_master_.empty()) next = std::min(next, to_master_.front().first);
            now_ = std::max(now_, next);
            step();
        }
    }

    struct Try {
        Instant t;
    };
    std::map<std::pair<int, int>, std::vector<Try>> tries;  ///< by unit and start
    std::set<std::string> not_good;                         ///< variables that were good and ceased to be
    unsigned connections = 1;

    [[nodiscard]] const plan::LinePlan& plan() const { return plan_.lines[0]; }
    [[nodiscard]] const model::Line& model() const { return project_.lines[0]; }
    LinePoller& line() { return master_.line(0); }
    [[nodiscard]] const value::Slot& slot(const std::string& name) {
        return master_.store()[*master_.store().find(name)];
    }

private:
    void settle() {
        for (Bytes bytes = line().transmit(now_); !bytes.empty(); bytes = line().transmit(now_)) {
            const Frame frame(bytes.begin(), bytes.end());
            tries[{frame[6], frame[8] << 8 | frame[9]}].push_back({now_});
            if (!gone_) to_peer_.emplace_back(now_ + kWay, frame);
        }
        if (connected_ && line().must_reconnect()) lose();
        if (!connected_) (void)line().transmit(now_);  // chooses what comes next
        if (!connected_ && opens_at_ == kNever) {
            const auto wanted = line().opens_at();
            ASSERT_TRUE(wanted) << "the line is at fault";
            wanted_at_ = *wanted;
            if (*wanted <= now_) {
                opens_at_ = now_ + 2 * kWay;
                wanted_at_ = kNever;
            }
        }
        watch();
    }

    // A value ceases to be good.
    void watch() {
        for (const auto& device : model().devices)
            for (const auto& variable : device.variables) {
                const bool good = slot(variable.name).quality == value::Quality::good;
                if (good)
                    good_.insert(variable.name);
                else if (good_.erase(variable.name) > 0)
                    not_good.insert(variable.name);
            }
    }

    void step() {
        if (opens_at_ <= now_) {
            opens_at_ = kNever;
            connected_ = true;
            gone_ = false;
            ++connections;
            line().on_link(now_, true);
        }
        while (!to_master_.empty() && to_master_.front().first <= now_) {
            const Frame frame = to_master_.front().second;
            to_master_.pop_front();
            line().on_bytes(now_, frame);
            settle();
        }
        if (closes_at_ <= now_) return lose();
        while (!to_peer_.empty() && to_peer_.front().first <= now_) {
            const Frame frame = to_peer_.front().second;
            to_peer_.pop_front();
            receive(frame);
        }
        if (connected_ && line().next_wakeup() <= now_) line().on_tick(now_);
        if (!connected_ && line().next_wakeup() <= now_) line().on_tick(now_);
    }

    void receive(const Frame& frame) {
        if (gone_) return;
        const std::pair<int, int> asked{frame[6], frame[8] << 8 | frame[9]};
        const bool refuses =
            peer_.dead.contains(asked.first) || (peer_.closes == Closes::with_several && !to_peer_.empty());
        if (refuses) return close(peer_.thinks);
        const auto count = static_cast<std::uint8_t>(2 * frame[11]);
        Frame pdu{3, count};
        pdu.resize(pdu.size() + count);
        auto answer = tcp_response(frame, pdu);
        if (peer_.spoils && asked == std::pair(1, 100)) peer_.spoils(answer);
        to_master_.emplace_back(std::max(now_ + peer_.thinks + kWay, last_answer_), answer);
        last_answer_ = to_master_.back().first;
        const bool third = ++answers_ % 3 == 0 && peer_.closes == Closes::after_third;
        if (third || peer_.closes == Closes::after_each) close(peer_.thinks);
    }

    void close(Duration later) {
        gone_ = true;
        to_peer_.clear();
        closes_at_ = now_ + later + kWay;
    }

    void lose() {
        to_peer_.clear();
        to_master_.clear();
        closes_at_ = kNever;
        connected_ = false;
        gone_ = true;
        line().on_close(now_);
    }

    model::Project project_;
    plan::Plan plan_;
    Master master_;
    Peer peer_;
    int answers_ = 0;
    Instant now_ = at(1s);
    bool connected_ = false;
    bool gone_ = false;  // the peer has closed its side
    Instant closes_at_ = kNever;
    Instant opens_at_ = kNever;
    Instant wanted_at_ = kNever;
    Instant last_answer_ = Instant::min();
    std::deque<std::pair<Instant, Frame>> to_peer_;
    std::deque<std::pair<Instant, Frame>> to_master_;
    std::set<std::string> good_;
};

model::Project described(int units, int reads, Duration period, int in_flight) {
    std::vector<model::Device> devices;
    for (int unit = 1; unit <= units; ++unit) {
        std::vector<Item> items;
        for (int i = 0; i < reads; ++i)
            items.push_back(
                int16("V" + std::to_string(unit) + "_" + std::to_string(i), 100 * i).read(3).every(period));
        auto& made = devices.emplace_back(device(unit, items));
        made.poll_period = period;
        made.response_timeout = 500ms;
        made.attempts = 3;
        made.strategy = model::Strategy::single;
        made.in_flight = static_cast<std::uint16_t>(in_flight);
    }
    return tcp_project(std::move(devices));
}

/// All units but `dead` are asked once a period, and their values stay good.
void expect_served(World& world, Duration period, int dead = 0) {
    for (const auto& [asked, all] : world.tries) {
        if (asked.first == dead) continue;
        EXPECT_GE(static_cast<std::int64_t>(all.size()), kRun / period)
            << "unit " << asked.first << ", start " << asked.second;
        for (std::size_t i = 1; i < all.size(); ++i) EXPECT_LE(all[i].t - all[i - 1].t, 2 * period);
    }
    for (const auto& name : world.not_good) EXPECT_EQ(name[1] - '0', dead) << name << " ceased to be good";
}

TEST(ClosingPeer, WithSeveralInFlightOnlyTheDeadUnitIsCharged) {
    World world(described(2, 2, 500ms, 4), {.closes = Closes::after_each, .dead = {2}, .thinks = 20ms});
    world.run(kRun);
    expect_served(world, 500ms, 2);
}

TEST(ClosingPeer, OneThatTakesOneRequestAtATimeIsServed) {
    World world(described(2, 3, 1s, 4), {.closes = Closes::with_several});
    world.run(kRun);
    expect_served(world, 1s);
}

TEST(ClosingPeer, ADeadUnitBehindAGatewayIsProbedMoreAndMoreSeldom) {
    World world(described(3, 1, 1s, 1), {.dead = {2}});
    world.run(60s);
    EXPECT_GE(world.tries[std::pair(1, 0)].size(), 59u);
    EXPECT_GE(world.tries[std::pair(3, 0)].size(), 59u);
    EXPECT_LE(world.tries[std::pair(2, 0)].size(), 12u);
    EXPECT_EQ(world.line().device(1).state, DeviceState::not_answering);
    EXPECT_EQ(world.slot("V2_0").reason, value::Reason::not_answering);
    EXPECT_EQ(world.slot("V3_0").quality, value::Quality::good);
}

TEST(ClosingPeer, OneThatClosesAfterEachResponseIsAskedOnceAConnection) {
    World world(described(1, 3, 1s, 1), {.closes = Closes::after_each});
    world.run(20s);
    for (const auto& [asked, all] : world.tries) {
        EXPECT_GE(all.size(), 20u);
        EXPECT_LE(all.size(), 22u);
    }
    EXPECT_LE(world.connections, 64u);
    EXPECT_TRUE(world.not_good.empty());
}

// The close comes while the next request waits, later than any response did. That one is repeated at once.
TEST(ClosingPeer, ACloseThatIsFollowedByAResponseChangesNoValue) {
    World world(described(1, 4, 1s, 1), {.closes = Closes::after_third, .thinks = 20ms});
    world.run(kRun);
    expect_served(world, 1s);
}

// No other read is charged, and none is sent less often. The connection ends, because it is not known where
// the next response begins.
TEST(ClosingPeer, AReadWithAWrongHeaderCostsOnlyItself) {
    const std::pair<const char*, std::function<void(Frame&)>> kSpoils[] = {
        {"protocol", [](Frame& frame) { frame[3] = 1; }},
        {"length too small", [](Frame& frame) { --frame[5]; }},
        {"length too large", [](Frame& frame) { ++frame[5]; }},
        {"length too large, with that byte",
         [](Frame& frame) {
             ++frame[5];
             frame.push_back(0);
         }},
        {"length of an exception too small",
         [](Frame& frame) { frame = {frame[0], frame[1], 0, 0, 0, 2, frame[6], 0x83, 2}; }},
    };
    for (const auto& [kind, spoils] : kSpoils) {
        SCOPED_TRACE(kind);
        auto project = described(2, 3, 1s, 1);
        project.lines[0].devices[0].response_timeout = 100ms;  // that the missing byte takes
        World world(project, {.spoils = spoils});
        world.run(kRun);
        EXPECT_LE(world.tries[std::pair(1, 100)].size(), 35u);
        world.tries.erase(std::pair(1, 100));
        world.not_good.erase("V1_1");
        expect_served(world, 1s);
        EXPECT_EQ(world.line().device(1).counters.link_lost, 0u);
    }
}

// Over TCP a response belongs to its request by unit, function and transaction id.
TEST(MisdirectedResponse, IsNoSilence) {
    const std::pair<const char*, std::function<void(Frame&)>> kSpoils[] = {
        {"unit", [](Frame& frame) { frame[6] = 9; }},
        {"transaction id", [](Frame& frame) { frame[0] = frame[1] = 0; }},
    };
    for (const auto& [kind, spoils] : kSpoils) {
        SCOPED_TRACE(kind);
        auto project = described(1, 2, 1s, 1);
        project.lines[0].devices[0].variables.erase(project.lines[0].devices[0].variables.begin());
        World world(project, {.spoils = spoils});
        world.run(kRun);
        const auto device = world.line().device(0);
        EXPECT_EQ(device.state, DeviceState::not_answering);
        EXPECT_EQ(device.failure, value::Reason::unexpected_reply);
        EXPECT_GT(device.foreign, 3U);
        EXPECT_EQ(device.foreign, device.counters.timeouts);
        ASSERT_TRUE(device.last_foreign);
        EXPECT_EQ(device.last_foreign->part == Mismatch::Part::unit, std::string_view(kind) == "unit");
        if (device.last_foreign->part == Mismatch::Part::unit) EXPECT_EQ(device.last_foreign->came, 9);
        EXPECT_EQ(device.share.state(), FailureShare::State::steady) << "it never answers";
    }
}

TEST(ClosingPeer, TheWayOfConnectingIsKept) {
    using model::ConnectionUse;
    for (const auto& [use, most] : {std::pair{ConnectionUse::keep, 1u},
                                    {ConnectionUse::per_cycle, 21u},
                                    {ConnectionUse::per_request, 61u},
                                    {ConnectionUse::on_demand, 21u}}) {
        auto project = described(1, 3, 1s, 1);
        project.lines[0].connection.use = use;
        if (use == ConnectionUse::on_demand) project.lines[0].connection.idle_close = 200ms;
        project.lines[0].connection.pause_after = 20ms;
        World world(project, {});
        world.run(20s);
        EXPECT_LE(world.connections, most);
        EXPECT_GE(world.connections, most * 9 / 10);
        EXPECT_TRUE(world.not_good.empty());
        for (const auto& [asked, all] : world.tries) EXPECT_GE(all.size(), 19u);
    }
}

}  // namespace closing_peer_test
}  // namespace takt::poll
