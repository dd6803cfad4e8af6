#include <gtest/gtest.h>

#include "listener.hpp"
#include "takt/wire/line_timing.hpp"

namespace takt::wire {
namespace framer_rtu_test {

using namespace std::chrono_literals;

constexpr Duration kSilence = 1750us;
constexpr FramerConfig kSlave{.framing = Framing::rtu, .side = Side::slave, .silence = kSilence};
constexpr FramerConfig kMaster{.framing = Framing::rtu, .side = Side::master, .silence = kSilence};
constexpr Instant at(Duration since_start) {
    return Instant{} + since_start;
}

// As a hex string: unit and PDU with their CRC.
std::string with_crc(std::string_view text) {
    const ByteVector bytes = from_hex(text);
    return to_hex(encode_frame(Framing::rtu, UnitId{bytes[0]}, 0, Bytes(bytes).subspan(1)).span());
}

constexpr std::string_view kGoldenRequests[] = {
    "10 03 00 00 00 02 C7 4A", "10 03 00 12 00 02 67 4F", "10 03 01 F4 00 02 87 44",
    "10 03 01 FA 00 01 A6 86", "10 04 01 FA 00 01 13 46", "01 04 00 00 00 02 71 CB",
    "01 04 00 00 00 10 F1 C6",
};
constexpr std::string_view kGoldenResponses[] = {
    "10 03 04 00 00 3F 80 EB 62", "10 03 04 00 00 40 00 CA F2",
    "10 03 04 00 00 40 40 CB 02", "10 03 04 00 00 40 80 CB 52",
    "10 03 04 00 00 40 A0 CA 8A", "10 03 02 00 00 44 47",
    "01 04 04 00 02 00 03 1A 45", "01 84 02 C2 C1",
};

std::string report_of(std::string_view frame) {
    return std::string(frame.substr(0, 2)) + ": " + std::string(frame.substr(3, frame.size() - 9));
}

TEST(RtuFramer, ReportsGoldenFramesAtTheirLastByte) {
    for (const auto frame : kGoldenRequests) {
        Listener slave(kSlave);
        slave.hex(at(1s), frame);
        EXPECT_EQ(slave.reports(), Reports{report_of(frame)});
        EXPECT_EQ(to_hex(slave.framer().raw()), frame);
    }
    for (const auto frame : kGoldenResponses) {
        for (const auto& config : {kSlave, kMaster}) {
            Listener listener(config);
            listener.hex(at(1s), frame);
            EXPECT_EQ(listener.reports(), Reports{report_of(frame)});
        }
    }
}

TEST(RtuFramer, BytesMayComeOneByOne) {
    Listener slave(kSlave);
    Instant t = at(1s);
    for (const std::uint8_t byte : from_hex(kGoldenRequests[0])) {
        EXPECT_EQ(slave.reports(), Reports{});
        const ByteVector one{byte};
        slave.bytes(t += 1700us, one);
    }
    EXPECT_EQ(slave.reports(), Reports{report_of(kGoldenRequests[0])});
}

TEST(RtuFramer, AMasterMeasuresResponsesOnly) {
    Listener master(kMaster);
    master.hex(at(1s), kGoldenRequests[2]);  // as a response: one byte counted
    EXPECT_EQ(master.reports(), Reports{});
    master.tick(at(1s) + kSilence);
    EXPECT_EQ(master.reports(), Reports{report_of(kGoldenRequests[2])})
        << "the silence ends it, also at another length";
}

TEST(RtuFramer, EndsFramesOfUnknownLengthByTheSilence) {
    const auto frame = with_crc("01 63 AA BB CC");
    Listener slave(kSlave);
    slave.hex(at(1s), frame);
    EXPECT_EQ(slave.reports(), Reports{});
    EXPECT_EQ(slave.framer().next_wakeup(), at(1s) + kSilence);
    slave.tick(at(1s) + kSilence - 1ns);
    EXPECT_EQ(slave.reports(), Reports{});
    slave.tick(at(1s) + kSilence);
    EXPECT_EQ(slave.reports(), Reports{"01: 63 AA BB CC"});
    EXPECT_EQ(slave.framer().next_wakeup(), kNever);
}

// Hostile-inputs 41: the decoder refuses it then, with exception 3.
TEST(RtuFramer, ReportsAGoodChecksumAtAWrongLengthAfterTheSilence) {
    for (const std::string_view body :
         {"01 03 00 00 00 01 00 00", "01 03 00 00 00", "01 10 00 00 00 01 04 00 00"}) {
        Listener slave(kSlave);
        slave.hex(at(1s), with_crc(body));
        EXPECT_EQ(slave.reports(), Reports{});
        slave.tick(at(2s));
        EXPECT_EQ(slave.reports(),
                  (Reports{std::string(body.substr(0, 2)) + ": " + std::string(body.substr(3))}));
    }
}

// Hostile-inputs 35, 36.
TEST(RtuFramer, ReportsFaultsAtTheSilenceAndGoesOn) {
    struct Row {
        std::string bytes;
        std::string_view fault;
    };
    const Row rows[] = {
        {"10 03 00 00 00 02 C7 4B", "!checksum"}, {"10", "!too_short"},    {"10 03 00", "!too_short"},
        {"FF FF FF FF FF FF FF FF", "!checksum"}, {"00 00", "!too_short"},
    };
    for (const auto& [bytes, fault] : rows) {
        for (const bool ticked : {false, true}) {
            Listener slave(kSlave);
            slave.hex(at(1s), bytes);
            if (ticked) slave.tick(at(1s) + kSilence);
            slave.hex(at(2s), kGoldenRequests[0]);
            EXPECT_EQ(slave.reports(), (Reports{std::string(fault), report_of(kGoldenRequests[0])})) << bytes;
        }
    }
}

TEST(RtuFramer, ReportsAMissingEndOnce) {
    Listener slave(kSlave);
    const ByteVector noise(1000, 0x55);
    for (int i = 0; i < 1000; ++i) slave.bytes(at(1s + i * 1ms), noise);
    slave.hex(at(3s), kGoldenRequests[0]);
    EXPECT_EQ(slave.reports(), (Reports{"!too_long", report_of(kGoldenRequests[0])}));
}

TEST(RtuFramer, TakesTheLongestFrame) {
    std::string body = "01 10 00 00 00 7B F6";
    for (int i = 0; i < 246; ++i) body += " 5A";
    Listener slave(kSlave);
    slave.hex(at(1s), with_crc(body));
    EXPECT_EQ(slave.reports().size(), 1U);
    std::string longest = "01 63";
    for (int i = 0; i < 252; ++i) longest += " 5A";
    slave.hex(at(2s), with_crc(longest));
    slave.tick(at(3s));
    EXPECT_EQ(slave.reports().size(), 1U);
    EXPECT_EQ(slave.framer().raw().size(), kMaxRtuFrame);
}

// Hostile-inputs 37.
TEST(RtuFramer, StrictlyAPauseSpoilsTheFrame) {
    FramerConfig strict = kSlave;
    strict.strict_pause = 750us;
    for (const auto& [pause, reports] :
         {std::pair(750us, Reports{report_of(kGoldenRequests[0])}), std::pair(751us, Reports{"!pause"})}) {
        Listener slave(strict);
        slave.hex(at(1s), "10 03 00 00");
        slave.hex(at(1s) + pause, "00 02 C7 4A");
        slave.tick(at(2s));
        EXPECT_EQ(slave.reports(), reports);
        slave.hex(at(3s), kGoldenRequests[1]);
        EXPECT_EQ(slave.reports(), Reports{report_of(kGoldenRequests[1])});
    }
}

// 9600 8N1: a character takes 1.04 ms, the silence 3.65 ms. An adapter hands over 8 characters each 8.3 ms.
TEST(RtuFramer, SeesPausesBetweenChunksNotTheirOwnTime) {
    const CharacterFormat line{9600, 8, Parity::none, 1};
    const FramerConfig config{.framing = Framing::rtu,
                              .side = Side::slave,
                              .silence = t3_5(line),
                              .character = transmission_time(line, 1),
                              .strict_pause = t1_5(line)};
    Listener slave(config);
    const auto frame = from_hex(with_crc("01 10 00 00 00 04 08 00 01 00 02 00 03 00 04"));
    const Duration chunk = transmission_time(line, 8);
    slave.bytes(at(1s), Bytes(frame).first(8));
    slave.bytes(at(1s) + chunk, Bytes(frame).subspan(8, 8));
    slave.bytes(at(1s) + chunk + transmission_time(line, 1), Bytes(frame).subspan(16));
    EXPECT_EQ(slave.reports(), Reports{"01: 10 00 00 00 04 08 00 01 00 02 00 03 00 04"});
}

// Hostile-inputs 39.
TEST(RtuFramer, DropsWhatFollowsWithoutASilence) {
    Listener slave(kSlave);
    slave.hex(at(1s), std::string(kGoldenRequests[0]) + std::string(kGoldenRequests[1]));
    slave.hex(at(1s + 1ms), kGoldenRequests[2]);
    EXPECT_EQ(slave.reports(), (Reports{report_of(kGoldenRequests[0]), "!surplus"}));
    slave.hex(at(1s + 1ms) + kSilence, kGoldenRequests[3]);
    EXPECT_EQ(slave.reports(), Reports{report_of(kGoldenRequests[3])});
}

TEST(RtuFramer, NoiseRightBeforeAFrameCostsThatFrameOnly) {
    Listener slave(kSlave);
    slave.hex(at(1s), "00" + std::string(kGoldenRequests[0]));
    slave.hex(at(2s), kGoldenRequests[1]);
    EXPECT_EQ(slave.reports(), (Reports{"!checksum", report_of(kGoldenRequests[1])}));
}

// Hostile-inputs 38: unit 5 is another slave, unit 1 the own one.
constexpr std::string_view kForeignRequest = "05 03 00 00 00 04";
constexpr std::string_view kForeignResponse = "05 03 08 01 02 03 04 05 06 07 08";
constexpr std::string_view kOwnRequest = "01 03 00 00 00 01";

std::string report_of_body(std::string_view body) {
    return std::string(body.substr(0, 2)) + ": " + std::string(body.substr(3));
}

TEST(RtuFramer, IsNotDeafForOtherUnitsTraffic) {
    const std::string request = with_crc(kForeignRequest);
    const std::string response = with_crc(kForeignResponse);
    const std::string own = with_crc(kOwnRequest);
    const Reports all{report_of_body(kForeignRequest), report_of_body(kForeignResponse),
                      report_of_body(kOwnRequest)};
    const std::vector<std::string> chunkings[] = {
        {request, response, own},
        {request, response + own},
        {request + response, own},
        {request + response + own},
    };
    for (const auto& chunks : chunkings) {
        Listener slave(kSlave);
        slave.own_units_up_to(1);
        Instant t = at(1s);
        for (const auto& chunk : chunks) slave.hex(t += 10ms, chunk);
        EXPECT_EQ(slave.reports(), all) << chunks.size() << " chunks";
    }
}

TEST(RtuFramer, ReceivesTheNextRequestWhileAnotherUnitIsDead) {
    Listener slave(kSlave);
    slave.own_units_up_to(1);
    Instant t = at(1s);
    // a start address that could be a byte count: the second attempt is measured as a response until the
    // silence
    const std::string_view dead = "05 03 20 00 00 04";
    for (int attempt = 0; attempt < 3; ++attempt) {
        slave.hex(t += 100ms, with_crc(dead));
        slave.tick(t + kSilence);
        EXPECT_EQ(slave.reports(), Reports{report_of_body(dead)}) << attempt;
    }
    slave.hex(t += 100ms, with_crc(kOwnRequest));
    EXPECT_EQ(slave.reports(), Reports{report_of_body(kOwnRequest)});
    slave.hex(t += 100ms, with_crc(dead));
    EXPECT_EQ(slave.reports(), Reports{report_of_body(dead)})
        << "after another frame nothing is awaited any more";
}

TEST(RtuFramer, ServesTheFirstOfTwoGluedOwnRequestsOnly) {
    Listener slave(kSlave);
    slave.own_units_up_to(1);
    slave.hex(at(1s), with_crc(kForeignRequest) + with_crc(kForeignResponse) + with_crc(kOwnRequest) +
                          with_crc(kOwnRequest));
    EXPECT_EQ(slave.reports(), (Reports{report_of_body(kForeignRequest), report_of_body(kForeignResponse),
                                        report_of_body(kOwnRequest), "!surplus"}));
}

// Registers of another slave whose contents look like the end of a request and a request to unit 1 after it.
TEST(RtuFramer, TakesNoFrameOutOfAnotherUnitsResponse) {
    const std::string body = with_crc("05 03 0E 00 00 00") + " " + with_crc("01 06 00 00 12 34") + " 00";
    ASSERT_EQ(from_hex(body).size(), 3U + 0x0E);
    Listener slave(kSlave);
    slave.own_units_up_to(1);
    slave.hex(at(1s), with_crc("05 03 00 00 00 07"));
    slave.reports();
    slave.hex(at(1s + 10ms), with_crc(body));
    EXPECT_EQ(slave.reports(), Reports{report_of_body(body)});
}

TEST(RtuFramer, OverAStreamFramesFollowEachOther) {
    Listener server({.framing = Framing::rtu, .side = Side::slave, .silence = 50ms}, true);
    server.hex(at(1s), std::string(kGoldenRequests[0]) + std::string(kGoldenRequests[1]) + "10 03");
    server.hex(at(1s + 49ms), "01 F4 00 02 87 44");
    EXPECT_EQ(server.reports(), (Reports{report_of(kGoldenRequests[0]), report_of(kGoldenRequests[1]),
                                         report_of(kGoldenRequests[2])}));
    server.hex(at(2s), "10 03 00");
    server.hex(at(3s), kGoldenRequests[3]);
    EXPECT_EQ(server.reports(), (Reports{"!too_short", report_of(kGoldenRequests[3])}));
}

TEST(RtuFramer, ResetForgetsAFrameBegun) {
    Listener master(kMaster);
    master.hex(at(1s), "10 03 04 00");
    master.framer().reset();
    EXPECT_EQ(master.framer().next_wakeup(), kNever);
    master.hex(at(1s), kGoldenResponses[0]);
    EXPECT_EQ(master.reports(), Reports{report_of(kGoldenResponses[0])});
}

TEST(RtuFramer, NoBytesAreNoBytes) {
    StandaloneFramer framer(kSlave);
    EXPECT_EQ(framer.push(at(1s), {}).consumed, 0U);
    EXPECT_EQ(framer.next_wakeup(), kNever);
}

// --- over a byte stream

constexpr FramerConfig kStream{.framing = Framing::rtu, .side = Side::slave, .silence = 500ms};

const std::string kRequests[] = {
    with_crc("10 03 00 00 00 02"),
    with_crc("01 05 00 07 FF 00"),
    with_crc("01 0F 00 00 00 09 02 AA 01"),
    with_crc("01 10 00 01 00 02 04 00 0A 01 02"),
    with_crc("01 17 00 00 00 02 00 05 00 01 02 12 34"),
};

TEST(RtuFramerOverAStream, FindsTheRequestBehindAStrayByte) {
    for (unsigned stray = 0; stray < 256; ++stray)
        for (const auto& request : kRequests) {
            Listener slave(kStream, true);
            const ByteVector one{static_cast<std::uint8_t>(stray)};
            slave.bytes(at(1s), one);
            slave.hex(at(1100ms), request);
            slave.tick(at(1600ms));
            auto reports = slave.reports();
            std::erase(reports, "!checksum");
            EXPECT_EQ(reports, Reports{report_of(request)}) << stray;
        }
}

// The stray byte and the unit look like a unit and a function, whose length may be unknown or large.
TEST(RtuFramerOverAStream, FindsTheRequestOfAnyUnitBehindAStrayByteAtOnce) {
    for (const unsigned stray : {0x00U, 0x01U, 0x10U, 0x55U, 0xFFU})
        for (unsigned unit = 1; unit < 248; ++unit)
            for (const char* const read : {"03 00 00 00 02", "03 01 2C 00 64", "04 00 00 00 64"}) {
                Listener slave(kStream, true);
                const ByteVector one{static_cast<std::uint8_t>(stray)};
                char number[4];
                std::snprintf(number, sizeof number, "%02X ", unit);
                const auto request = with_crc(std::string(number) + read);
                slave.bytes(at(1s), one);
                slave.hex(at(1100ms), request);
                auto reports = slave.reports();
                std::erase(reports, "!checksum");
                EXPECT_EQ(reports, Reports{report_of(request)}) << stray << ' ' << request;
            }
}

// The data of a good request may look like a request, also where the bytes come one by one.
TEST(RtuFramerOverAStream, LeavesTheDataOfAGoodRequestAlone) {
    const auto inner = with_crc("01 03 00 00 00 02");
    const auto outer = with_crc("01 10 00 00 00 05 0A " + inner + " 00 00");
    Listener slave(kStream, true);
    const auto bytes = from_hex(outer);
    for (std::size_t i = 0; i < bytes.size(); ++i)
        slave.bytes(at(1s) + std::chrono::milliseconds(i), ByteVector{bytes[i]});
    EXPECT_EQ(slave.reports(), Reports{report_of(outer)});
}

// Its counts contradict each other, which the server refuses with exception 3.
TEST(RtuFramerOverAStream, TakesARequestWithWrongCounts) {
    const auto request = with_crc("01 10 00 00 00 02 02 12 34");
    Listener slave(kStream, true);
    slave.hex(at(1s), request);
    EXPECT_EQ(slave.reports(), Reports{report_of(request)});
}

TEST(RtuFramerOverAStream, FindsTheRequestBehindADamagedOne) {
    for (const auto& request : kRequests) {
        Listener slave(kStream, true);
        ByteVector damaged = from_hex(request);
        damaged.back() ^= 0x01;
        slave.bytes(at(1s), damaged);
        EXPECT_EQ(slave.reports(), Reports{"!checksum"});
        slave.hex(at(1010ms), request);
        EXPECT_EQ(slave.reports(), Reports{report_of(request)});
        slave.hex(at(1020ms), kGoldenRequests[0]);
        EXPECT_EQ(slave.reports(), Reports{report_of(kGoldenRequests[0])}) << "back in step";
    }
}

TEST(RtuFramerOverAStream, FindsTheRequestBehindMoreThanAFrameOfGarbage) {
    Listener slave(kStream, true);
    slave.bytes(at(1s), ByteVector(700, 0x41));
    EXPECT_EQ(slave.reports(), Reports{"!too_long"});
    slave.hex(at(1010ms), kGoldenRequests[0]);
    EXPECT_EQ(slave.reports(), Reports{report_of(kGoldenRequests[0])});
}

TEST(RtuFramerOverAStream, TakesNoRequestOutOfTheDataOfAnother) {
    const std::string inner = with_crc("01 06 00 00 00 01");
    const std::string outer = with_crc("01 10 00 00 00 04 08 " + inner);
    Listener slave(kStream, true);
    for (std::size_t i = 0; i < 3; ++i) {
        slave.hex(at(1s), outer);
        EXPECT_EQ(slave.reports(), Reports{report_of(outer)});
    }
}

}  // namespace framer_rtu_test
}  // namespace takt::wire
