// Frames of serial lines: pairing follows the order, because RTU does not mark requests and responses.
#include "takt/capture/serial_analyzer.hpp"

#include <gtest/gtest.h>

#include <string>

#include "capture_bytes.hpp"
#include "takt/wire/frame.hpp"

namespace takt::capture {
namespace serial_analyzer_test {

using namespace test;
using namespace std::chrono_literals;

struct Kept final : ExchangeSink {
    std::string text;
    void on_request(const ObservedRequest& request) override {
        text += "Q" + std::to_string(request.packet.number) + ' ';
    }
    void on_response(const ObservedRequest& request, const ObservedResponse& response) override {
        text += "A" + std::to_string(request.packet.number) + '-' + std::to_string(response.packet.number);
        if (response.exception != 0) text += '!' + std::to_string(response.exception);
        text += ' ';
    }
    void on_no_response(const ObservedRequest& request, NoResponse why) override {
        constexpr const char* kWhy[] = {"U", "E", "B"};
        text += kWhy[static_cast<int>(why)] + std::to_string(request.packet.number) + ' ';
    }
};

class Line {
public:
    void frame(wire::Framing framing, std::uint8_t unit, std::string_view pdu, Duration at = 0ms) {
        const auto bytes = hex(pdu);
        const auto encoded = wire::encode_frame(framing, UnitId{unit}, 0, bytes);
        packet(Octets(encoded.data(), encoded.data() + encoded.size()), LinkType::user_0, at);
    }
    void rtu(std::uint8_t unit, std::string_view pdu, Duration at = 0ms) {
        frame(wire::Framing::rtu, unit, pdu, at);
    }
    void packet(const Octets& bytes, LinkType link = LinkType::user_0, Duration at = 0ms) {
        analyzer.on_packet({.number = ++number_, .time_ns = at.count(), .link = link, .data = bytes});
    }
    Kept kept;
    SerialAnalyzer analyzer{1s, kept};

private:
    std::uint64_t number_ = 0;
};

TEST(SerialAnalyzer, PairsRtuFrames) {
    Line line;
    line.rtu(1, "03 0000 0001");
    line.rtu(1, "03 02 1234");
    line.rtu(2, "03 0000 0001");
    line.rtu(2, "83 02");
    line.analyzer.end();
    EXPECT_EQ(line.kept.text, "Q1 A1-2 Q3 A3-4!2 ");
}

TEST(SerialAnalyzer, PairsAsciiFrames) {
    Line line;
    line.frame(wire::Framing::ascii, 1, "03 0000 0001");
    line.frame(wire::Framing::ascii, 1, "03 02 1234");
    EXPECT_EQ(line.kept.text, "Q1 A1-2 ");
}

TEST(SerialAnalyzer, ASilentDeviceAndTheNextRequest) {
    Line line;
    line.rtu(1, "03 0000 0001");
    line.rtu(2, "03 0000 0001");
    line.rtu(2, "03 02 0000");
    line.rtu(1, "03 0000 0001");
    line.analyzer.end();
    EXPECT_EQ(line.kept.text, "Q1 Q2 A2-3 U1 Q4 E4 ");
}

TEST(SerialAnalyzer, AnEchoIsAResponseUnlessItComesAfterTheTimeout) {
    Line line;
    line.rtu(1, "06 0000 0001", 0ms);
    line.rtu(1, "06 0000 0001", 5ms);
    line.rtu(1, "06 0000 0002", 100ms);
    line.rtu(1, "06 0000 0002", 1200ms);
    line.rtu(1, "06 0000 0002", 1205ms);
    EXPECT_EQ(line.kept.text, "Q1 A1-2 Q3 U3 Q4 A4-5 ");
}

TEST(SerialAnalyzer, ABroadcastNeedsNoResponse) {
    Line line;
    line.rtu(0, "06 0000 0001");
    line.rtu(1, "03 0000 0001");
    line.rtu(1, "03 02 0000");
    EXPECT_EQ(line.kept.text, "Q1 B1 Q2 A2-3 ");
}

TEST(SerialAnalyzer, CountsDamagedAndUnmatchedFrames) {
    Line line;
    line.rtu(1, "03 02 0000");
    line.rtu(1, "83 02");
    line.packet(hex("01 03 00 00 00 01 00 00"));
    line.packet(hex("01 03"));
    line.packet({});
    line.packet(hex("3a 30 31 30 33 30 31 30 0d 0a"));
    EXPECT_EQ(line.kept.text, "");
    EXPECT_EQ(line.analyzer.counts().unmatched, 2u);
    EXPECT_EQ(line.analyzer.counts().damaged, 4u);
}

TEST(SerialAnalyzer, SkipsTheHeaderOfAnRtac) {
    Line line;
    const auto frame = [](std::string_view event, const Octets& bytes) {
        return joined({hex("00000000 00000000"), hex(event), hex("00 0000"), bytes});
    };
    line.packet(frame("01", hex("01 04 00 00 00 02 71 CB")), LinkType::rtac_serial);
    line.packet(frame("03", {}), LinkType::rtac_serial);
    line.packet(frame("02", hex("01 04 04 00 02 00 03 1A 45")), LinkType::rtac_serial);
    line.packet(frame("08", {}), LinkType::rtac_serial);
    EXPECT_EQ(line.kept.text, "Q1 A1-3 ");
    EXPECT_EQ(line.analyzer.counts().line_errors, 1u);
}

}  // namespace serial_analyzer_test
}  // namespace takt::capture
