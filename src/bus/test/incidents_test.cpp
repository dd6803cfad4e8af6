// What an observer is notified of besides frames.
#include <gtest/gtest.h>

#include "rig.hpp"

namespace takt::bus {
namespace incidents_test {

using test::at;
using test::frame;
using test::kLine;
using test::mbap;
using test::Rig;
using test::rtu;
using test::transaction;
using namespace std::chrono_literals;
using wire::Incident;

std::uint16_t wire_id_of(const std::vector<std::uint8_t>& frame) {
    return static_cast<std::uint16_t>(frame[0] << 8U | frame[1]);
}

class Log final : public wire::TrafficObserver {
public:
    void on_frame(Instant, wire::Direction, UnitId, Bytes, Bytes) override {}
    void on_fault(Instant, wire::FrameFault, Bytes) override {}
    void on_incident(Instant t, UnitId unit, Incident incident, Duration after,
                     const std::optional<Mismatch>& instead) override {
        seen.push_back({t, unit, incident, after, instead});
    }
    struct Seen {
        Instant t;
        UnitId unit;
        Incident incident;
        Duration after;
        std::optional<Mismatch> instead = {};
        friend bool operator==(const Seen&, const Seen&) = default;
    };
    std::vector<Seen> seen;
};

TEST(Incidents, ATimeoutALateAndASurplusResponseAreTold) {
    Log log;
    Rig rig(test::kLine, &log);
    rig.submit(at(0ms), transaction(1, 1, "03 00 6B 00 02", 100ms));
    rig.run_until(at(130ms));
    const Duration ended = rig.last().ended_at - at(0ms);
    rig.receive(at(200ms), rtu(1, "03 04 11 11 22 22"));
    rig.receive(at(300ms), rtu(1, "03 04 11 11 22 22"));
    ASSERT_EQ(log.seen.size(), 4U);
    EXPECT_EQ(log.seen[0], (Log::Seen{at(0ms), UnitId{0}, Incident::connected, {}}));
    EXPECT_EQ(log.seen[1].incident, Incident::no_response);
    EXPECT_EQ(log.seen[1].unit, UnitId{1});
    EXPECT_EQ(log.seen[1].after, 100ms);
    EXPECT_EQ(log.seen[2], (Log::Seen{at(200ms), UnitId{1}, Incident::late_response, 200ms - ended}));
    EXPECT_EQ(log.seen[3], (Log::Seen{at(300ms), UnitId{1}, Incident::surplus_response, {}}));
}

// Of each request the outcome has the response that came instead.
TEST(Incidents, OverTcpResponsesOfOthersAreSurplus) {
    const LineConfig tcp{.framing = wire::Framing::tcp, .margin = 2ms};
    const auto answered = [&](std::vector<std::uint8_t> response) {
        Log log;
        Rig rig(tcp, &log);
        rig.submit(at(0ms), transaction(1, 5, "03 00 6B 00 01"));
        rig.run_until(at(20ms));
        rig.receive(at(30ms), response);
        rig.run_until(at(200ms));
        EXPECT_EQ(rig.last().status, Status::timeout);
        EXPECT_EQ(log.seen[1].incident, Incident::surplus_response);
        EXPECT_EQ(log.seen[1].t, at(30ms));
        EXPECT_EQ(rig.last().instead, log.seen[1].instead);
        return rig.last().instead;
    };
    const std::uint16_t id = wire_id_of(mbap(1, ""));
    using enum Mismatch::Part;
    EXPECT_EQ(answered(mbap(1, "00 05 01 03 02 00 07")), (Mismatch{unit, 1, 5}));
    EXPECT_EQ(answered(mbap(1, "00 05 05 04 02 00 07")), (Mismatch{function, 4, 3}));
    EXPECT_EQ(answered(frame(0, "00 05 05 03 02 00 07")), (Mismatch{transaction, 0, id}));
    EXPECT_EQ(answered(frame(0, "00 05 05 04 02 00 07")), std::nullopt);
    EXPECT_EQ(answered(frame(0, "00 05 01 03 02 00 07")), std::nullopt) << "noise of a neighbour";
}

// The incident and the outcome say how many bytes came, also if the silence behind them ends after the
// deadline. It is one cause: it has one status.
TEST(Incidents, AResponseThatIsCutShortIsDamaged) {
    const auto after = [](const LineConfig& config, const std::vector<std::uint8_t>& came,
                          const char* request = "03 00 6B 00 02") {
        Log log;
        Rig rig(config, &log);
        rig.submit(at(0ms), transaction(1, 5, request, 20ms));
        rig.run_until(at(20ms));
        rig.receive(at(20ms), came);
        rig.run_until(at(200ms));
        EXPECT_EQ(rig.last().status, Status::bad_checksum);
        EXPECT_EQ(log.seen.size(), 2U);
        EXPECT_EQ(log.seen.back().incident, Incident::no_response);
        EXPECT_EQ(log.seen.back().instead, rig.last().instead);
        EXPECT_FALSE(rig.engine.rejection()) << "no other setting helps";
        return rig.last().instead;
    };
    const auto cut = [](std::vector<std::uint8_t> frame, std::size_t bytes) {
        frame.resize(frame.size() - bytes);
        return frame;
    };
    using enum Mismatch::Part;
    LineConfig early_silence = kLine;
    early_silence.frame_silence = 4ms;
    LineConfig terminal = early_silence;  // the request may be repeated
    terminal.echo = Echo::untimed;
    for (const auto& serial : {kLine, early_silence, terminal})
        for (const auto missing : {std::uint16_t{1}, std::uint16_t{3}, std::uint16_t{6}}) {
            const auto left = [missing](unsigned whole) {
                return Mismatch{length, static_cast<std::uint16_t>(whole - missing),
                                static_cast<std::uint16_t>(whole)};
            };
            EXPECT_EQ(after(serial, cut(rtu(5, "03 04 00 07 00 08"), missing)), left(9));
            EXPECT_EQ(after(serial, cut(rtu(5, "03 04 00 6B 00 02"), missing)), left(9));
            EXPECT_EQ(after(serial, cut(rtu(5, "06 00 01 00 03"), missing), "06 00 01 00 03"), left(8));
            EXPECT_EQ(after(serial, cut(rtu(5, "10 00 01 00 02"), missing), "10 00 01 00 02 04 00 05 00 06"),
                      left(8));
        }
    for (const auto& serial : {kLine, early_silence, terminal}) {
        EXPECT_EQ(after(serial, cut(rtu(5, "83 02"), 2)), (Mismatch{length, 3, 5}));
        EXPECT_EQ(after(serial, cut(rtu(5, "03 02 00 00"), 2), "03 02 00 00 01"), (Mismatch{length, 5, 7}))
            << "it begins like its request";
    }
    LineConfig ascii = kLine;
    ascii.framing = wire::Framing::ascii;
    LineConfig ascii_terminal = ascii;
    ascii_terminal.echo = Echo::untimed;
    for (const auto& config : {ascii, ascii_terminal})
        for (const std::string text : {":050304000700", ":05030400070008E5"})
            EXPECT_EQ(after(config, {text.begin(), text.end()}),
                      (Mismatch{length, static_cast<std::uint16_t>(text.size()), 19}));
    const LineConfig tcp{.framing = wire::Framing::tcp, .margin = 2ms};
    LineConfig tolerant = tcp;
    tolerant.length_tolerance = true;
    for (const auto& config : {tcp, tolerant}) {
        EXPECT_EQ(after(config, mbap(1, "00 07 05 03 04 00 07 00")), (Mismatch{length, 12, 13}));
        EXPECT_EQ(after(config, mbap(1, "00 06 05 03 04 00 07 00")), (Mismatch{length, 12, 13}))
            << "its header has the length that came";
    }
}

// What came before the last request is no noise before its response.
TEST(Incidents, OverTcpNoiseIsCountedForOneRequest) {
    Rig rig({.framing = wire::Framing::tcp, .margin = 2ms});
    rig.submit(at(0ms), transaction(1, 8, "03 00 6B 00 01"));
    rig.run_until(at(5ms));
    rig.receive(at(5ms), "FF FF FF FF FF FF FF FF FF FF FF");
    rig.run_until(at(400ms));
    EXPECT_NE(rig.last().status, Status::ok);
    rig.engine.on_link(at(400ms), false);
    rig.engine.on_link(at(400ms), true);
    rig.submit(at(400ms), transaction(2, 5, "03 00 6B 00 01"));
    rig.run_until(at(405ms));
    rig.receive(at(405ms), mbap(2, "00 05 05 03 02 00 07"));
    rig.run_until(at(600ms));
    EXPECT_EQ(rig.last().id, 2U);
    EXPECT_EQ(rig.last().status, Status::ok);
    EXPECT_EQ(rig.last().noise, 0U);
}

// A frame that would answer the request, had it not another unit; not the response to another master, which
// follows the request of that one.
TEST(Incidents, OnASerialLineAResponseOfAnotherUnitIsForeign) {
    const auto after = [](const std::vector<std::vector<std::uint8_t>>& frames) {
        Rig rig;
        rig.submit(at(0ms), transaction(1, 5, "03 00 6B 00 01"));
        rig.run_until(at(20ms));
        auto t = at(20ms);
        for (const auto& frame : frames) {
            rig.receive(t += 15ms, frame);
            rig.run_until(t += 5ms);
        }
        rig.run_until(at(200ms));
        return rig.last().instead;
    };
    using enum Mismatch::Part;
    const auto response = rtu(1, "03 02 00 07");
    EXPECT_EQ(after({response}), (Mismatch{unit, 1, 5}));
    EXPECT_EQ(after({rtu(1, "83 02")}), (Mismatch{unit, 1, 5}));
    EXPECT_EQ(after({rtu(1, "03 04 00 07 00 08")}), std::nullopt) << "of two registers";
    EXPECT_EQ(after({rtu(5, "04 02 00 07")}), (Mismatch{function, 4, 3})) << "another function";
    EXPECT_EQ(after({rtu(5, "84 02")}), (Mismatch{function, 4, 3}));
    EXPECT_EQ(after({rtu(5, "04 00 00 00 01"), rtu(5, "04 02 00 07")}), std::nullopt) << "another master";
    const auto request = rtu(1, "03 00 6B 00 01");
    EXPECT_EQ(after({request, response}), std::nullopt);
    EXPECT_EQ(after({response, request}), std::nullopt);
}

// Each response to the one looks like a late response of the other. One that comes after the other request of
// its unit has ended is late, though another unit is asked.
TEST(Incidents, OnASerialLineUnitsWithSwappedAddressesAreForeignAndLateOnesAreNot) {
    for (const bool swapped : {true, false}) {
        Rig rig;
        for (std::uint8_t n = 0; n < 20; ++n) {
            const auto unit = static_cast<std::uint8_t>(1 + n % 2);
            rig.submit(rig.now, transaction(n, unit, "03 00 6B 00 01"));
            while (rig.sent.size() == n) rig.run_until(rig.now + 1ms);
            rig.run_until(rig.now + 20ms);
            const auto other = static_cast<std::uint8_t>(3 - unit);
            if (swapped || n > 0) rig.receive(rig.now, rtu(other, "03 02 00 07"));
            while (rig.outcomes.size() == n) rig.run_until(rig.now + 1ms);
            ASSERT_EQ(rig.last().status, Status::timeout);
            EXPECT_EQ(rig.last().instead.has_value(), swapped) << int{n};
        }
        EXPECT_EQ(rig.engine.counters().late_answers, swapped ? 0U : 19U);
    }
}

// Before that both were dead for so long that their responses are not expected any more.
TEST(Incidents, OnASerialLineUnitsThatWereDeadBeforeTheirAddressesWereSwappedAreForeign) {
    for (const auto dead : {std::uint8_t{20}, std::uint8_t{60}}) {
        Rig rig;
        for (std::uint8_t n = 0; n < dead + 8; ++n) {
            const auto unit = static_cast<std::uint8_t>(1 + n % 2);
            rig.submit(rig.now, transaction(n, unit, "03 00 6B 00 01"));
            while (rig.sent.size() == n) rig.run_until(rig.now + 1ms);
            rig.run_until(rig.now + 20ms);
            if (n >= dead) rig.receive(rig.now, rtu(static_cast<std::uint8_t>(3 - unit), "03 02 00 07"));
            while (rig.outcomes.size() == n) rig.run_until(rig.now + 1ms);
            EXPECT_EQ(rig.last().instead.has_value(), n >= dead) << int{n};
        }
        EXPECT_EQ(rig.engine.counters().late_answers, 0U);
    }
}

// One response of it was lost: as many are missing as of a unit that is dead, but it was heard meanwhile.
TEST(Incidents, OnASerialLineTheResponsesOfAUnitThatIsAlwaysLateAreLate) {
    Rig rig;
    unsigned late = 0;
    for (std::uint8_t n = 0; n < 60; ++n) {
        const auto unit = static_cast<std::uint8_t>(1 + n % 2);
        rig.submit(rig.now, transaction(n, unit, "03 00 6B 00 01"));
        while (rig.sent.size() == n) rig.run_until(rig.now + 1ms);
        rig.run_until(rig.now + 20ms);
        if (unit == 2 && n > 2 && n % 10 != 1) {
            rig.receive(rig.now, rtu(1, "03 02 00 07"));
            ++late;
        }
        while (rig.outcomes.size() == n) rig.run_until(rig.now + 1ms);
        rig.run_until(rig.now + 500ms);
    }
    EXPECT_EQ(rig.engine.counters().late_answers, late);
}

// Over TCP a response that comes again has the id of a request that has ended.
TEST(Incidents, OverTcpARepeatedResponseIsSurplus) {
    Rig rig({.framing = wire::Framing::tcp, .margin = 2ms});
    const auto response = mbap(1, "00 05 05 03 02 00 07");
    rig.submit(at(0ms), transaction(1, 5, "03 00 6B 00 01"));
    rig.run_until(at(20ms));
    rig.receive(at(30ms), response);
    EXPECT_EQ(rig.engine.take_surplus(), std::nullopt);
    rig.receive(at(31ms), response);
    const auto repeated = rig.engine.take_surplus();
    ASSERT_TRUE(repeated);
    EXPECT_EQ(repeated->unit, UnitId{5});
    for (const std::uint16_t id : {std::uint16_t{0}, std::uint16_t{1}, std::uint16_t{2}}) {
        const auto other = static_cast<std::uint16_t>(wire_id_of(response) + id + 1);
        rig.receive(at(40ms), frame(other, "00 05 05 03 02 00 07"));
    }
    rig.receive(at(41ms), frame(0, "00 05 05 03 02 00 07"));
    EXPECT_EQ(rig.engine.take_surplus(), std::nullopt);
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
