#include "arithmetic.hpp"

#include <algorithm>

namespace takt::judge {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

Duration up_to_microseconds(Duration time) {
    return Duration((time.count() + 999) / 1000 * 1000);
}

}  // namespace

Arithmetic::Arithmetic(const model::Project& project, const model::Line& line)
    : project_(project),
      line_(line),
      serial_(line.is_serial()),
      bits_(1 + line.format.data_bits + (line.format.parity == wire::Parity::none ? 0 : 1) +
            line.format.stop_bits) {
    if (!serial_ || line.framing != wire::Framing::rtu) return;
    const std::int64_t baud = line.format.baud;
    t3_5_ = baud > 19200 ? Duration(1'750'000) : Duration((7 * bits_ * kSecond + 2 * baud - 1) / (2 * baud));
}

Duration Arithmetic::characters(std::size_t count) const {
    if (!serial_) return {};
    const std::int64_t baud = line_.format.baud;
    return Duration((static_cast<std::int64_t>(count) * bits_ * kSecond + baud - 1) / baud);
}

Duration Arithmetic::silence() const {
    return std::max(t3_5_, line_.frame_gap);
}

Duration Arithmetic::wait(const model::Device& device) const {
    bool one_at_a_time = true;
    for (const model::Device& each : line_.devices)
        if (line_.framing == wire::Framing::tcp && each.in_flight > 1) one_at_a_time = false;
    const bool derived =
        project_.derive_timeouts && device.turnaround && !device.response_timeout_set && one_at_a_time;
    return std::max(t3_5_, derived ? *device.turnaround : device.response_timeout);
}

Duration Arithmetic::longest(const model::Device& device, const Asked& asked) const {
    constexpr Duration kBroadcast = std::chrono::milliseconds(100);
    if (is_broadcast(asked))
        return characters(frame_characters(line_.framing, asked.pdu.size())) + kBroadcast;
    const std::size_t answer = std::max<std::size_t>(asked.normal_answer, 2);
    return characters(frame_characters(line_.framing, asked.pdu.size())) + wait(device) +
           characters(frame_characters(line_.framing, answer)) + project_.timeout_margin;
}

Duration Arithmetic::failure(const model::Device& device, const Asked& asked) const {
    return up_to_microseconds(
        std::max(longest(device, asked) + silence() + project_.host.overhead, line_.request_gap));
}

}  // namespace takt::judge
