#include "serial/serial_stream.hpp"

#include <algorithm>

namespace takt::capture {
namespace {

/// The longest pause inside a frame: a segment that was sent again may come that late.
constexpr Duration kPause = std::chrono::seconds(1);

}  // namespace

SerialStream::SerialStream(wire::Framing framing)
    : framer_({.framing = framing, .side = wire::Side::slave, .silence = kPause, .ascii_pause = kPause},
              true) {}

void SerialStream::push(const PacketRef& packet, Bytes bytes, AduSink& sink) {
    last_ns_ = std::max(last_ns_, packet.time_ns);
    const Instant t{Duration(last_ns_)};
    bytes_ += bytes.size();
    while (!bytes.empty()) {
        const auto step = framer_.push(t, bytes);
        bytes = bytes.subspan(step.consumed);
        if (step.complete) {
            const auto frame = framer_.frame();
            ++messages_;
            framed_ += framer_.raw().size();
            sink.on_adu({.unit = frame.unit.value, .pdu = frame.pdu, .packet = packet});
        } else if (step.consumed == 0 && step.fault == wire::FrameFault::none) {
            return;
        }
    }
}

}  // namespace takt::capture
