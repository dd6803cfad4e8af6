// Packets to exchanges.
#include "takt/capture/analysis.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <string>

#include "capture_bytes.hpp"
#include "takt/capture/capture_reader.hpp"
#include "takt/capture/frame_capture.hpp"
#include "takt/wire/frame.hpp"

namespace takt::capture {
namespace analysis_test {

using namespace test;
using namespace std::chrono_literals;

struct Kept final : ExchangeSink {
    std::string text;
    std::vector<ObservedRequest> requests;
    std::uint64_t retransmissions = 0;
    void on_request(const ObservedRequest& request) override { requests.push_back(request); }
    void on_response(const ObservedRequest& request, const ObservedResponse& response) override {
        text += std::to_string(request.packet.number) + '-' + std::to_string(response.packet.number);
        if (response.exception != 0) text += '!' + std::to_string(response.exception);
        text += ' ';
        retransmissions += response.retransmissions;
    }
    void on_no_response(const ObservedRequest& request, NoResponse why) override {
        text += why == NoResponse::end ? 'E' : why == NoResponse::broadcast ? 'B' : 'U';
        text += std::to_string(request.packet.number) + ' ';
    }
};

constexpr std::uint8_t kSyn = 0x02;
constexpr std::uint8_t kSynAck = 0x12;
constexpr std::uint8_t kFin = 0x11;
constexpr std::uint8_t kRst = 0x04;

/// Packets of connections, numbered from 1 on; 1 ms apart.
class Wire {
public:
    /// One end of a connection sends.
    struct End {
        std::uint8_t host;
        std::uint16_t port;
        std::uint32_t sequence;
    };
    struct Connection {
        End client{1, 40000, 1000};
        End server{2, 502, 5000};
    };

    void send(End& from, const End& to, const Octets& payload, std::uint8_t flags = 0x18,
              bool captured = true) {
        const auto packet = ipv4({.from = from.host,
                                  .to = to.host,
                                  .from_port = from.port,
                                  .to_port = to.port,
                                  .sequence = from.sequence,
                                  .acknowledged = to.sequence,
                                  .flags = flags},
                                 payload);
        from.sequence += static_cast<std::uint32_t>(payload.size()) + ((flags & 0x03) != 0 ? 1 : 0);
        if (captured) pass(packet);
    }
    void pass(Octets packet) {
        ++number;
        const auto length = static_cast<std::uint32_t>(packet.size());
        packet.resize(std::min(packet.size(), cut));
        analysis.on_packet({.number = number,
                            .time_ns = static_cast<std::int64_t>(number) * 1'000'000,
                            .link = LinkType::raw,
                            .original_length = length,
                            .data = packet});
    }
    void open(Connection& c) {
        send(c.client, c.server, {}, kSyn);
        send(c.server, c.client, {}, kSynAck);
        send(c.client, c.server, {}, 0x10);
    }
    void request(Connection& c, const Octets& payload, bool captured = true) {
        send(c.client, c.server, payload, 0x18, captured);
    }
    void respond(Connection& c, const Octets& payload, bool captured = true) {
        send(c.server, c.client, payload, 0x18, captured);
    }
    const std::string& result() {
        analysis.end();
        return kept.text;
    }

    Kept kept;
    Analysis analysis{{}, 1s, kept};
    std::uint64_t number = 0;
    std::size_t cut = SIZE_MAX;  // bytes of a packet that are captured
};

constexpr const char* kRead = "03 0000 0002";
constexpr const char* kAnswer = "03 04 0000 0001";

TEST(Analysis, OneExchange) {
    Wire wire;
    Wire::Connection c;
    wire.open(c);
    wire.request(c, adu(1, 17, "03 006B 0003"));
    wire.respond(c, adu(1, 17, "03 06 022B 0064 007F"));
    EXPECT_EQ(wire.result(), "4-5 ");
    const auto& request = wire.kept.requests.at(0);
    EXPECT_EQ(request.unit, 17);
    EXPECT_EQ(request.function, 3);
    EXPECT_EQ(request.items, 0x006B0003u);
    EXPECT_EQ(request.route.client, (Endpoint{*parse_ip("10.0.0.1"), 40000}));
    EXPECT_EQ(request.route.server, (Endpoint{*parse_ip("10.0.0.2"), 502}));
    EXPECT_EQ(wire.analysis.tcp().connections, 1u);
}

TEST(Analysis, ManyInFlightAreAnsweredInAnyOrder) {
    Wire wire;
    Wire::Connection c;
    wire.open(c);
    wire.request(c, joined({adu(1, 1, kRead), adu(2, 1, kRead), adu(3, 2, kRead)}));
    wire.request(c, adu(4, 1, "04 0000 0002"));
    wire.respond(c, adu(3, 2, kAnswer));
    wire.respond(c, joined({adu(4, 1, "04 04 0000 0001"), adu(1, 1, "83 02")}));
    wire.respond(c, adu(2, 1, kAnswer));
    EXPECT_EQ(wire.result(), "4-6 5-7 4-7!2 4-8 ");
}

TEST(Analysis, UnitAndFunctionMustBeThoseOfTheRequest) {
    Wire wire;
    Wire::Connection c;
    wire.open(c);
    wire.request(c, adu(1, 1, kRead));
    wire.respond(c, adu(1, 2, kAnswer));
    wire.respond(c, adu(1, 1, "04 04 0000 0001"));
    wire.respond(c, adu(2, 1, kAnswer));
    EXPECT_EQ(wire.result(), "E4 ");
    EXPECT_EQ(wire.analysis.tcp().unmatched, 3u);
}

TEST(Analysis, EqualIdsOnTwoConnections) {
    Wire wire;
    Wire::Connection a;
    Wire::Connection b{{1, 40001, 9000}, {2, 502, 100}};
    wire.open(a);
    wire.open(b);
    wire.request(a, adu(1, 1, kRead));
    wire.request(b, adu(1, 1, kRead));
    wire.respond(b, adu(1, 1, kAnswer));
    wire.respond(a, adu(1, 1, kAnswer));
    EXPECT_EQ(wire.result(), "8-9 7-10 ");
}

TEST(Analysis, EqualIdsInFlightAreAnsweredInTheirOrder) {
    Wire wire;
    Wire::Connection c;
    wire.open(c);
    wire.request(c, adu(0, 1, kRead));
    wire.request(c, adu(0, 1, kRead));
    wire.respond(c, adu(0, 1, kAnswer));
    wire.respond(c, adu(0, 1, kAnswer));
    EXPECT_EQ(wire.result(), "4-6 5-7 ");
    EXPECT_EQ(wire.analysis.tcp().repeated_ids, 1u);
}

TEST(Analysis, ALostResponseDoesNotShiftThoseOfAConstantId) {
    for (const int lost : {0, 2}) {
        Wire wire;
        Wire::Connection c;
        wire.open(c);
        std::string wanted;
        for (int i = 0; i < 5; ++i) {
            wire.request(c, adu(0, 1, kRead));
            if (i != lost) {
                wire.respond(c, adu(0, 1, kAnswer));
                wanted += std::to_string(wire.number - 1) + '-' + std::to_string(wire.number) + ' ';
            }
            wire.number += 200;  // ms
        }
        EXPECT_EQ(wire.result(), wanted + (lost == 0 ? "E4 " : "E408 ")) << lost;
    }
}

TEST(Analysis, AResponseTimeOfYearsIsNoUsualOne) {
    Wire wire;
    Wire::Connection c;
    wire.open(c);
    wire.request(c, adu(0, 1, kRead));
    const auto late = kMostTime / 1'000'000 - 1'000'000;  // ms
    wire.number = static_cast<std::uint64_t>(late);
    wire.respond(c, adu(0, 1, kAnswer));
    wire.request(c, adu(0, 1, kRead));
    wire.number += 700'000;  // more than ten usual response times
    wire.request(c, adu(0, 1, kRead));
    wire.respond(c, adu(0, 1, kAnswer));
    const auto number = [&](int more) { return std::to_string(late + more); };
    EXPECT_EQ(wire.result(),
              "4-" + number(1) + " U" + number(2) + ' ' + number(700'003) + '-' + number(700'004) + ' ');
}

TEST(Analysis, OfEqualIdsTheResponseFitsItsRequest) {
    Wire wire;
    Wire::Connection c;
    wire.open(c);
    wire.request(c, adu(7, 1, "03 0000 0001"));
    wire.request(c, adu(7, 1, "03 0000 0002"));
    wire.request(c, adu(7, 1, "06 0001 0005"));
    wire.request(c, adu(7, 1, "06 0002 0005"));
    wire.request(c, adu(7, 1, "01 0000 0009"));
    wire.request(c, adu(7, 1, "01 0000 0008"));
    wire.respond(c, adu(7, 1, "01 01 00"));
    wire.respond(c, adu(7, 1, "06 0002 0005"));
    wire.respond(c, adu(7, 1, kAnswer));
    wire.respond(c, adu(7, 1, "83 02"));
    EXPECT_EQ(wire.result(), "9-10 7-11 5-12 4-13!2 E6 E8 ");
}

TEST(Analysis, MessagesOfPacketsCutByTheCapture) {
    for (const bool handshake : {true, false}) {
        Wire wire;
        Wire::Connection c;
        if (handshake) wire.open(c);
        for (int i = 0; i < 2; ++i) {
            wire.request(c, adu(static_cast<std::uint16_t>(i), 1, "10 0000 0004 08 0001 0002 0003 0004"));
            wire.cut = 40 + 8;  // headers, MBAP and function
            wire.respond(c, adu(static_cast<std::uint16_t>(i), 1, "10 0000 0004"));
            wire.cut = 40 + 13;
        }
        EXPECT_EQ(wire.result(), handshake ? "4-5 6-7 " : "1-2 3-4 ");
        EXPECT_EQ(wire.analysis.tcp().resynchronisations, 0u);
        EXPECT_EQ(wire.kept.requests.at(1).items, wire.kept.requests.at(0).items);
    }
}

TEST(Analysis, CountsRetransmissionsInsideAnExchange) {
    Wire wire;
    Wire::Connection c;
    wire.open(c);
    auto again = c.client;
    wire.request(c, adu(1, 1, kRead));
    wire.send(again, c.server, adu(1, 1, kRead));
    wire.respond(c, adu(1, 1, kAnswer));
    auto response = c.server;
    response.sequence -= 13;
    wire.send(response, c.client, adu(1, 1, kAnswer));
    wire.request(c, adu(2, 1, kRead));
    wire.respond(c, adu(2, 1, kAnswer));
    EXPECT_EQ(wire.result(), "4-6 8-9 ");
    EXPECT_EQ(wire.kept.retransmissions, 1u);
    EXPECT_EQ(wire.analysis.tcp().streams.retransmissions, 2u);
}

TEST(Analysis, ASegmentWithOldAndNewBytesIsARetransmission) {
    Wire wire;
    Wire::Connection c;
    wire.open(c);
    auto again = c.client;
    wire.request(c, adu(1, 1, kRead));
    wire.send(again, c.server, joined({adu(1, 1, kRead), adu(2, 1, kRead)}));
    c.client = again;
    wire.respond(c, adu(1, 1, kAnswer));
    wire.respond(c, adu(2, 1, kAnswer));
    EXPECT_EQ(wire.result(), "4-6 5-7 ");
    EXPECT_EQ(wire.kept.retransmissions, 1u);
}

TEST(Analysis, ARequestThatWasNotCaptured) {
    Wire wire;
    Wire::Connection c;
    wire.open(c);
    wire.request(c, adu(1, 1, kRead), false);
    wire.respond(c, adu(1, 1, kAnswer));
    wire.request(c, adu(2, 1, kRead));
    wire.respond(c, adu(2, 1, kAnswer));
    EXPECT_EQ(wire.result(), "5-6 ");
    EXPECT_EQ(wire.analysis.tcp().unmatched, 1u);
    EXPECT_EQ(wire.analysis.tcp().streams.gaps, 1u);
    EXPECT_EQ(wire.analysis.tcp().streams.missing_bytes, 12u);
}

TEST(Analysis, APartOfAResponseThatWasNotCaptured) {
    Wire wire;
    Wire::Connection c;
    wire.open(c);
    wire.request(c, adu(1, 1, kRead));
    const auto response = adu(1, 1, kAnswer);
    wire.respond(c, Octets(response.begin(), response.begin() + 5));
    wire.respond(c, Octets(response.begin() + 5, response.begin() + 9), false);
    wire.respond(c, Octets(response.begin() + 9, response.end()));
    wire.request(c, adu(2, 1, kRead));
    wire.respond(c, adu(2, 1, kAnswer));
    EXPECT_EQ(wire.result(), "7-8 E4 ");
    EXPECT_EQ(wire.analysis.tcp().resynchronisations, 1u);
}

TEST(Analysis, AnEndedConnectionLeavesRequestsUnanswered) {
    for (const bool reset : {false, true}) {
        Wire wire;
        Wire::Connection c;
        wire.open(c);
        wire.request(c, adu(1, 1, kRead));
        if (reset) {
            wire.send(c.server, c.client, {}, kRst);
        } else {
            wire.send(c.client, c.server, {}, kFin);
            wire.send(c.server, c.client, {}, kFin);
        }
        EXPECT_EQ(wire.result(), "U4 ");
        EXPECT_EQ(wire.analysis.tcp().streams.gaps, 0u);
    }
}

TEST(Analysis, TheSamePortsOpenAnotherConnection) {
    Wire wire;
    Wire::Connection first;
    wire.open(first);
    wire.request(first, adu(1, 1, kRead));
    Wire::Connection second;
    second.client.sequence = 77;
    second.server.sequence = 99;
    wire.open(second);
    wire.request(second, adu(1, 1, kRead));
    wire.respond(second, adu(1, 1, kAnswer));
    EXPECT_EQ(wire.result(), "U4 8-9 ");
}

/// The capture may lack one SYN of the second connection, or both, and its numbers may be near the first
/// ones.
TEST(Analysis, AnotherConnectionOfTheSamePortsWithoutItsSyn) {
    struct Case {
        bool client_syn, server_syn, end;
        std::uint32_t first;
    };
    for (const auto& each :
         {Case{true, false, true, 1000}, Case{false, true, true, 1000}, Case{true, false, false, 900},
          Case{false, true, false, 1010}, Case{false, false, true, 50'000'000}}) {
        SCOPED_TRACE(testing::Message() << each.client_syn << each.server_syn << each.end << each.first);
        Wire wire;
        Wire::Connection first;
        wire.open(first);
        wire.request(first, adu(1, 1, kRead));
        wire.respond(first, adu(1, 1, kAnswer));
        if (each.end) {
            wire.send(first.client, first.server, {}, kFin);
            wire.send(first.server, first.client, {}, kFin);
        }
        Wire::Connection second;
        second.client.sequence = each.first;
        second.server.sequence = each.first + 4000;
        wire.send(second.client, second.server, {}, kSyn, each.client_syn);
        wire.send(second.server, second.client, {}, kSynAck, each.server_syn);
        std::string wanted = "4-5 ";
        for (int i = 0; i < 2; ++i) {
            wire.request(second, adu(2, 1, kRead));
            wire.respond(second, adu(2, 1, kAnswer));
            wanted += std::to_string(wire.number - 1) + '-' + std::to_string(wire.number) + ' ';
        }
        EXPECT_EQ(wire.result(), wanted);
        EXPECT_EQ(wire.analysis.tcp().streams.missing_bytes, 0u);
    }
}

TEST(Analysis, ACaptureThatBeginsInTheMiddle) {
    Wire wire;
    Wire::Connection c;
    wire.respond(c, adu(7, 1, kAnswer));
    wire.request(c, adu(8, 1, kRead));
    wire.respond(c, adu(8, 1, kAnswer));
    EXPECT_EQ(wire.result(), "2-3 ");
}

TEST(Analysis, FindsTheServerOnAnyPort) {
    for (const bool handshake : {false, true})
        for (const bool server_is_lower : {false, true}) {
            SCOPED_TRACE(testing::Message() << handshake << server_is_lower);
            Wire wire;
            Wire::Connection c{{1, 30000, 1},
                               {2, static_cast<std::uint16_t>(server_is_lower ? 5020 : 50200), 1}};
            if (handshake) wire.open(c);
            wire.request(c, adu(1, 1, kRead));
            wire.respond(c, adu(1, 1, kAnswer));
            EXPECT_EQ(wire.result(), handshake ? "4-5 " : "1-2 ");
            EXPECT_EQ(wire.kept.requests.at(0).route.server.port, c.server.port);
        }
}

TEST(Analysis, FindsRtuAndAsciiFramesOnAnyPort) {
    const auto text = [](std::string_view frame) { return Octets(frame.begin(), frame.end()); };
    const std::pair<Octets, Octets> frames[] = {{hex("01 03 0000 0002 C40B"), hex("01 03 04 00010002 2A32")},
                                                {text(":010300000002FA\r\n"), text(":01030400010002F5\r\n")}};
    for (const auto& [request, response] : frames)
        for (const std::uint16_t port : {std::uint16_t{502}, std::uint16_t{4001}, std::uint16_t{50200}})
            for (const bool handshake : {true, false}) {
                SCOPED_TRACE(testing::Message() << port << handshake);
                Wire wire;
                Wire::Connection c{{1, 30000, 1}, {2, port, 1}};
                if (handshake) wire.open(c);
                // The first seven bytes of the RTU frame are a header of Modbus TCP.
                const auto cut = request.begin() + (handshake ? 5 : 0);
                if (handshake) wire.request(c, Octets(request.begin(), cut));
                wire.request(c, Octets(cut, request.end()));
                wire.respond(c, response);
                wire.request(c, request);
                wire.respond(c, response);
                EXPECT_EQ(wire.result(), handshake ? "5-6 7-8 " : "1-2 3-4 ");
                EXPECT_EQ(wire.kept.requests.size(), 2u);
                EXPECT_EQ(wire.analysis.tcp().serial_framing, 1u);
            }
}

// Takt writes frames of serial lines as segments of Modbus TCP.
TEST(Analysis, ABroadcastOfASerialLineNeedsNoResponse) {
    const Octets pdu = hex("06 0005 1234");
    const auto rtu_of = [&](std::uint8_t unit) {
        Octets frame{unit};
        frame.insert(frame.end(), pdu.begin(), pdu.end());
        const auto sum = wire::crc16(frame);
        frame.push_back(static_cast<std::uint8_t>(sum & 0xFFU));
        frame.push_back(static_cast<std::uint8_t>(sum >> 8U));
        return frame;
    };
    const auto broadcast = rtu_of(0);
    const auto write = rtu_of(16);
    FrameCapture capture;
    std::string file;
    capture.begin_file(file);
    const auto add = [&](const CapturedFrame& frame) { capture.add(frame, file); };
    using wire::Framing;
    add({.framing = Framing::rtu, .request = true, .unit = 16, .pdu = pdu, .raw = write});
    add({.wall_ns = 1, .framing = Framing::rtu, .unit = 16, .pdu = pdu, .raw = write});
    add({.wall_ns = 2, .framing = Framing::rtu, .request = true, .pdu = pdu, .raw = broadcast});
    add({.wall_ns = 3, .line = 1, .framing = Framing::tcp, .request = true, .pdu = pdu});
    Kept kept;
    Analysis analysis({}, 1s, kept);
    CaptureReader reader(analysis);
    std::ranges::copy(file, reader.space().begin());
    EXPECT_TRUE(reader.filled(file.size()));
    reader.end();
    analysis.end();
    EXPECT_EQ(kept.text, "1-2 B3 E4 ");
}

TEST(Analysis, OtherProtocolsAreCounted) {
    Wire wire;
    Wire::Connection c{{1, 40000, 1}, {2, 80, 1}};
    wire.open(c);
    for (int i = 0; i < 10; ++i) wire.request(c, Octets(1000, 'x'));
    EXPECT_EQ(wire.result(), "");
    EXPECT_EQ(wire.analysis.tcp().foreign, 1u);
    EXPECT_EQ(wire.analysis.tcp().connections, 0u);
}

TEST(Analysis, ConnectionsAndRequestsAreBounded) {
    Wire wire;
    std::size_t open = 0;
    for (std::size_t i = 0; i < TcpAnalyzer::kMostConnections + 10; ++i) {
        Wire::Connection c{{1, static_cast<std::uint16_t>(10000 + i), 1}, {2, 502, 1}};
        wire.request(c, adu(1, 1, kRead));
        ++open;
    }
    EXPECT_EQ(wire.analysis.tcp().evicted, 10u);
    Wire::Connection c{{1, 9999, 1}, {2, 502, 1}};
    for (std::uint16_t i = 0; i < 1000; ++i) wire.request(c, adu(i, 1, kRead));
    wire.respond(c, adu(999, 1, kAnswer));
    wire.analysis.end();
    EXPECT_EQ(wire.kept.requests.size(), open + 1000);
    EXPECT_NE(wire.kept.text.find("-" + std::to_string(wire.number) + " "), std::string::npos);
}

TEST(Analysis, CountsPacketsByTheirContent) {
    Wire wire;
    auto udp = ipv4({}, hex("00"));
    udp[9] = 17;
    wire.pass(udp);
    auto fragment = ipv4({}, hex("00"));
    fragment[6] = 0x20;
    wire.pass(fragment);
    wire.pass(Octets(udp.begin(), udp.begin() + 8));
    wire.analysis.on_packet({.number = 4, .timed = false, .link = LinkType::raw});
    wire.analysis.on_packet({.number = 5, .time_ns = 1, .link = LinkType{9}});
    const auto& counts = wire.analysis.packets();
    EXPECT_EQ(counts.packets, 5u);
    EXPECT_EQ(counts.other, 1u);
    EXPECT_EQ(counts.fragments, 1u);
    EXPECT_EQ(counts.cut, 1u);
    EXPECT_EQ(counts.untimed, 1u);
    EXPECT_EQ(counts.other_link, 1u);
    EXPECT_EQ(counts.first_other_link, 9u);
    EXPECT_EQ(counts.backwards, 1u);
    EXPECT_EQ(counts.first_ns, 1'000'000);
}

}  // namespace analysis_test
}  // namespace takt::capture
