#include "reading/field_ranges.hpp"

namespace takt::model {
namespace {

std::int64_t most_registers(const Context& context) {
    return static_cast<std::int64_t>(
        wire::max_items(context.framing, wire::Function::read_holding_registers, limits_of(context.profile)));
}

}  // namespace

std::int64_t default_timeout(const Context& context) {
    return in_ns(device_defaults(context.profile).response_timeout);
}

Range device_name(const Context& context) {
    return {1, context.profile == Profile::owen_kc1 ? 14 : 64};
}

Range address(const Context& context) {
    if (!context.is_serial()) return {0, 255};
    return {1, 247, 254};
}

Range period(const Context& context) {
    return {0, in_ns(context.profile == Profile::owen_kc1 ? Duration(65535ms) : Duration(24h))};
}

Range baud(const Context& context) {
    return {50, context.profile == Profile::owen_kc1 ? 115200 : 10'000'000};
}

Range data_bits(const Context& context) {
    return {context.framing == wire::Framing::ascii ? 7 : 8, 8};
}

Range request_gap(const Context& context) {
    return {context.profile == Profile::owen_kc1 ? in_ns(12ms) : 0, in_ns(65535ms)};
}

Range registers_per_request(const Context& context) {
    constexpr std::int64_t kMost = 125;  // more than a frame carries is cut
    return {2, most_registers(context), kMost};
}

Range length(const Context& context) {
    return {1, most_registers(context)};
}

std::int64_t most_written_registers(const Context& context) {
    return static_cast<std::int64_t>(wire::max_items(
        context.framing, wire::Function::write_multiple_registers, limits_of(context.profile)));
}

bool transport_fits(std::size_t word, const Context& context) {
    const auto transport = static_cast<Transport>(word);
    return context.profile == Profile::generic || transport == Transport::serial ||
           transport == Transport::simulated;
}

bool framing_fits(std::size_t word, const Context& context) {
    const auto framing = static_cast<wire::Framing>(word);
    switch (context.transport) {
        case Transport::serial: return framing != wire::Framing::tcp;
        case Transport::tcp: return framing != wire::Framing::ascii;
        case Transport::tls: return framing == wire::Framing::tcp;
        case Transport::simulated:
            return context.profile == Profile::generic || framing != wire::Framing::tcp;
    }
    return false;
}

}  // namespace takt::model
