// Arbitrary bytes as a capture, in pieces whose size is the first byte. It also chooses the framing in TCP.
// Each request has one end. Each packet is read as one of a serial line too.
#include <algorithm>
#include <array>

#include "input.hpp"
#include "takt/capture/analysis.hpp"
#include "takt/capture/capture_reader.hpp"
#include "takt/capture/latency.hpp"
#include "takt/capture/serial_packet.hpp"

namespace {

using namespace takt;

/// Passes packets on after they were read as those of a serial line.
class SerialFirst final : public capture::PacketSink {
public:
    explicit SerialFirst(capture::PacketSink& next) : next_(next) {}
    void on_packet(const capture::Packet& packet) override {
        const capture::SerialPacket serial(packet);
        const bool none = serial.kind() == capture::SerialPacket::Kind::none;
        fuzz::require(none == serial.bytes().empty());
        next_.on_packet(packet);
    }

private:
    capture::PacketSink& next_;
};

void read(capture::CaptureReader& reader, Bytes file, std::size_t piece) {
    while (!file.empty()) {
        const auto space = reader.space();
        const auto count = std::min({piece, file.size(), space.size()});
        std::copy_n(file.begin(), count, space.begin());
        if (!reader.filled(count)) return;
        file = file.subspan(count);
    }
    reader.end();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::Input input({data, size});
    const unsigned first = input.byte();
    const std::size_t piece = 1U + first * 16U;
    static constexpr std::array kFramings{wire::Framing::tcp, wire::Framing::rtu, wire::Framing::ascii};
    capture::LatencyReport report({.limit = std::chrono::milliseconds(1), .microsecond_buckets = 10});
    capture::Analysis analysis({.framing = kFramings[first % kFramings.size()]}, std::chrono::seconds(1),
                               report);
    SerialFirst serial(analysis);
    capture::CaptureReader reader(serial);
    read(reader, input.bytes(size), piece);
    analysis.end();
    report.end(analysis.packets().last_ns);
    const auto& total = report.total();
    fuzz::require(total.requests == total.decided() + total.open + total.broadcasts);
    fuzz::require(total.exceeded <= total.decided());
    fuzz::require(analysis.packets().packets == reader.packets());
    return 0;
}
