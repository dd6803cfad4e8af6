// The probe of a device over a scripted connection, which waits for nothing.
#include "takt/bus/device_probe.hpp"

#include <gtest/gtest.h>

#include <deque>
#include <set>

namespace takt::bus {
namespace device_probe_test {

using namespace std::chrono_literals;
using Ranges = std::vector<model::ItemRange>;
using wire::Area;

/// A device that has some holding registers and answers everything else with an exception.
class Connection final : public ProbeConnection {
public:
    Result<int> transact(const wire::PreparedRequest& prepared) override {
        const Bytes request = prepared.pdu();
        ++requests;
        if (interrupt_at > 0 && requests >= interrupt_at) interrupted_ = true;
        if (!script.empty()) {
            const auto next = script.front();
            script.pop_front();
            if (next == Code::busy) return 6;
            return fail(next, "target");
        }
        if (silent) return fail(Code::timed_out, "target", 1000);
        if (request[0] != 3) return int{no_function};
        const unsigned start = request[1] * 256U + request[2];
        const unsigned end = start + request[3] * 256U + request[4];
        if (end - start == 1 && !refused.empty() && start == refused.front()) return 3;
        if (end - start == 1 && !refused.empty() && start == refused.back()) return 4;
        if (end - start > limit || start < first || end > last + 1) return 2;
        return 0;
    }
    void pause(Duration time) override { paused += time; }
    [[nodiscard]] bool interrupted() const override { return interrupted_; }

    unsigned first = 10;
    unsigned last = 29;
    unsigned limit = 125;
    std::uint8_t no_function = 1;
    std::vector<unsigned> refused;  // the first by exception 3, the last by exception 4
    bool silent = false;
    int interrupt_at = 0;
    std::deque<Code> script;  // of the first requests; busy: exception 6
    int requests = 0;
    Duration paused{};

private:
    bool interrupted_ = false;
};

DeviceProbeConfig small(std::vector<Area> areas = {}) {
    return {.areas = std::move(areas), .first = 0, .last = 63, .step = 1, .max_requests = 200};
}

TEST(DeviceProbe, FindsTheRangesOfEachArea) {
    Connection connection;
    const auto findings = probe_device(small(), connection);
    ASSERT_EQ(findings.areas.size(), 4U);
    EXPECT_EQ(findings.areas[0].area, Area::holding_register);
    EXPECT_EQ(findings.areas[0].result.readable, (Ranges{{10, 29}}));
    EXPECT_EQ(findings.areas[0].items(), 20U);
    EXPECT_EQ(findings.areas[1].result.end, ProbeEnd::no_function);
    EXPECT_TRUE(findings.complete()) << "an area that the device does not have is searched";
    EXPECT_TRUE(findings.any_readable());
    EXPECT_FALSE(findings.no_answer || findings.lost);
    EXPECT_EQ(findings.requests() + 1, static_cast<std::size_t>(connection.requests)) << "and the first one";
    EXPECT_GT(findings.exceptions.at(1), 0U);
    EXPECT_GT(findings.exceptions.at(2), 0U);
}

TEST(DeviceProbe, OnlyTheAreasThatAreWanted) {
    Connection connection;
    const auto findings = probe_device(small({Area::coil, Area::holding_register}), connection);
    ASSERT_EQ(findings.areas.size(), 2U);
    EXPECT_EQ(findings.areas[0].area, Area::holding_register) << "in the order of all areas";
    EXPECT_EQ(findings.areas[1].area, Area::coil);
}

TEST(DeviceProbe, ASilentDeviceIsNotProbed) {
    Connection connection;
    connection.silent = true;
    const auto findings = probe_device(small(), connection);
    ASSERT_TRUE(findings.no_answer);
    EXPECT_EQ(findings.no_answer->code, Code::timed_out);
    EXPECT_EQ(connection.requests, 4) << "one of each area";
    EXPECT_TRUE(findings.areas.empty());
    EXPECT_FALSE(findings.any_readable());
}

TEST(DeviceProbe, AnInterruptionStopsIt) {
    Connection connection;
    connection.interrupt_at = 1;
    connection.silent = true;
    const auto early = probe_device(small(), connection);
    EXPECT_TRUE(early.stopped);
    EXPECT_FALSE(early.no_answer) << "the user ended it, not the device";
    EXPECT_FALSE(early.complete());

    Connection later;
    later.interrupt_at = 30;
    const auto findings = probe_device(small(), later);
    EXPECT_TRUE(findings.stopped);
    ASSERT_EQ(findings.areas.size(), 1U) << "the next area is not begun";
    EXPECT_EQ(findings.not_begun, (std::vector{Area::input_register, Area::coil, Area::discrete_input}));
    EXPECT_EQ(findings.areas[0].result.end, ProbeEnd::stopped);
    EXPECT_FALSE(findings.complete());
}

TEST(DeviceProbe, ABusyDeviceIsAskedAgain) {
    Connection connection;
    connection.script = {Code::busy, Code::busy, Code::busy, Code::busy};
    const auto findings = probe_device(small({Area::holding_register}), connection);
    EXPECT_EQ(findings.areas[0].result.readable, (Ranges{{10, 29}}));
    EXPECT_EQ(connection.paused, 300ms) << "the first answer only shows that it is there";
    EXPECT_FALSE(findings.exceptions.contains(6));
}

TEST(DeviceProbe, ADeviceThatStaysBusyRefuses) {
    Connection connection;
    connection.script = std::deque<Code>(1 + 20, Code::busy);
    const auto findings = probe_device(small({Area::holding_register}), connection);
    EXPECT_EQ(findings.exceptions.at(6), 1U);
    EXPECT_EQ(connection.paused, 19 * 100ms);
}

TEST(DeviceProbe, ALostConnectionIsRestoredOrTheEnd) {
    Connection restored;
    restored.script = std::deque<Code>(10, Code::connection_lost);
    restored.script.push_front(Code::busy);
    const auto findings = probe_device(small({Area::holding_register}), restored);
    EXPECT_TRUE(findings.complete());
    EXPECT_EQ(findings.areas[0].result.readable, (Ranges{{10, 29}}));

    Connection gone;
    gone.script = std::deque<Code>(1000, Code::connection_lost);
    gone.script.push_front(Code::busy);
    const auto ended = probe_device(small({Area::holding_register}), gone);
    ASSERT_TRUE(ended.lost);
    EXPECT_EQ(ended.lost->code, Code::connection_lost);
    EXPECT_TRUE(ended.stopped);
    EXPECT_EQ(gone.requests, 1 + 11);
    EXPECT_EQ(gone.paused, 10 * 500ms);
}

TEST(DeviceProbe, AnUnexpectedReplyIsARefusalAndABadOneIsSilence) {
    Connection connection;
    connection.script = {Code::busy, Code::unexpected_reply, Code::bad_checksum};
    const auto findings = probe_device(small({Area::holding_register}), connection);
    EXPECT_EQ(findings.areas[0].result.readable, (Ranges{{10, 29}}));
    EXPECT_EQ(connection.paused, 0ms) << "neither is trouble of the connection";
}

TEST(DeviceProbe, TheLimitOfAReadIsFound) {
    Connection connection;
    connection.limit = 8;
    const auto findings = probe_device(small({Area::holding_register}), connection);
    EXPECT_TRUE(findings.areas[0].result.limited);
    EXPECT_EQ(findings.areas[0].result.longest, 8);
    EXPECT_EQ(findings.areas[0].result.readable, (Ranges{{10, 29}}));
}

TEST(DeviceProbe, ReportsItsProgress) {
    Connection connection;
    std::vector<ProbeProgress> seen;
    const auto findings = probe_device(small({Area::holding_register}), connection,
                                       [&](const ProbeProgress& progress) { seen.push_back(progress); });
    ASSERT_EQ(seen.size(), findings.requests());
    EXPECT_EQ(seen.front().asked, 1U);
    EXPECT_EQ(seen.back().asked, seen.size());
    EXPECT_EQ(seen.front().area, Area::holding_register);
    EXPECT_GT(seen.front().expected, 0U);
    EXPECT_LE(seen.front().expected, 200U);
}

TEST(DeviceProbe, ReportsExceptions3And4AsRefusals) {
    Connection connection;
    connection.refused = {40, 42};
    const auto findings = probe_device(small({Area::holding_register}), connection);
    const auto& result = findings.areas.at(0).result;
    EXPECT_EQ(result.readable, (Ranges{{10, 29}}));
    EXPECT_EQ(result.refused, (std::vector<RefusedItems>{{{40, 40}, ProbeReply::bad_value},
                                                         {{42, 42}, ProbeReply::failure}}));
}

TEST(DeviceProbe, CountsTheAddressesTested) {
    Connection connection;
    const auto all = probe_device({.areas = {Area::holding_register}, .last = 2000, .step = 1}, connection);
    EXPECT_TRUE(all.complete()) << "the default number of requests is enough for 2001 addresses";
    EXPECT_EQ(all.areas.at(0).addresses(), 2001U);
    EXPECT_EQ(all.areas.at(0).tested(), 2001U);
    EXPECT_FALSE(all.areas.at(0).longest_gap());

    AreaProbe part;
    part.searched = {10, 99};
    part.result.tested = {{10, 19}, {30, 30}, {90, 95}};
    EXPECT_EQ(part.addresses(), 90U);
    EXPECT_EQ(part.tested(), 17U);
    EXPECT_EQ(part.longest_gap(), (model::ItemRange{31, 89}));
    part.result.tested = {{12, 99}};
    EXPECT_EQ(part.longest_gap(), (model::ItemRange{10, 11}));
    part.result.tested = {};
    EXPECT_EQ(part.longest_gap(), (model::ItemRange{10, 99}));
}

TEST(DeviceProbe, TheLongestReadOfRegisters) {
    ProbeFindings findings;
    EXPECT_FALSE(findings.longest_register_read());
    findings.areas.resize(3);
    findings.areas[0].result.longest = 40;
    findings.areas[1].area = Area::input_register;
    findings.areas[1].result.longest = 100;
    findings.areas[2].area = Area::coil;
    findings.areas[2].result.longest = 2000;
    EXPECT_FALSE(findings.longest_register_read()) << "no read was refused for its length";
    findings.areas[0].result.limited = true;
    EXPECT_EQ(findings.longest_register_read(), 40) << "every area accepts it";
    findings.areas[0].result.longest = 1;
    EXPECT_FALSE(findings.longest_register_read());
}

TEST(DeviceProbe, TheStepThatFitsTheNumberOfRequests) {
    const struct {
        std::size_t max_requests;
        std::uint16_t first, last;
        std::uint16_t step;
    } cases[] = {{2000, 0, 999, 1},     {4096, 0, 2000, 1},    {4096, 0, 65535, 128}, {200000, 0, 65535, 1},
                 {2, 0, 65535, 0x4000}, {0, 0, 65535, 0x4000}, {10, 7, 7, 1},         {4096, 0, 2048, 4}};
    for (const auto& c : cases)
        EXPECT_EQ(step_within(c.max_requests, c.first, c.last), c.step) << c.max_requests << ' ' << c.last;
}

}  // namespace device_probe_test
}  // namespace takt::bus
