#include "faults.hpp"

#include <numeric>

namespace takt::sim {
namespace {

constexpr std::size_t index(FaultKind kind) {
    return static_cast<std::size_t>(kind);
}

}  // namespace

std::string_view name(FaultKind kind) {
    static constexpr std::array<std::string_view, kFaultKinds> kNames{"bit_error",
                                                                      "lost_byte",
                                                                      "extra_byte",
                                                                      "repeated_byte",
                                                                      "lost_request",
                                                                      "lost_response",
                                                                      "late_response",
                                                                      "duplicate_response",
                                                                      "past_response",
                                                                      "glitch",
                                                                      "fragmented",
                                                                      "truncated",
                                                                      "garbage",
                                                                      "wrong_unit",
                                                                      "wrong_transaction",
                                                                      "wrong_function",
                                                                      "wrong_byte_count",
                                                                      "oversized",
                                                                      "wrong_echo",
                                                                      "busy",
                                                                      "wrong_exception",
                                                                      "ignored_write",
                                                                      "device_dead",
                                                                      "device_back",
                                                                      "device_babbles",
                                                                      "device_reboots",
                                                                      "device_forgets",
                                                                      "noise",
                                                                      "clock_jump",
                                                                      "link_down",
                                                                      "link_up",
                                                                      "tcp_reset",
                                                                      "tcp_half_open",
                                                                      "connect_refused",
                                                                      "close_after_response",
                                                                      "close_at_random",
                                                                      "close_on_request",
                                                                      "close_when_idle"};
    return index(kind) < kFaultKinds ? kNames[index(kind)] : "fault";
}

bool is_timed(FaultKind kind) {
    return (kind >= FaultKind::device_dead && kind < FaultKind::connect_refused) ||
           kind == FaultKind::close_when_idle;
}

bool is_close(FaultKind kind) {
    return kind >= FaultKind::close_after_response;
}

bool is_of_line(FaultKind kind) {
    return kind >= FaultKind::noise;
}

bool possible(FaultKind kind, wire::Framing framing, bool serial) {
    switch (kind) {
        case FaultKind::bit_error:
        case FaultKind::lost_byte:
        case FaultKind::extra_byte:
        case FaultKind::repeated_byte:
        case FaultKind::device_babbles:
        case FaultKind::noise:
        case FaultKind::link_down:
        case FaultKind::link_up: return serial;
        case FaultKind::fragmented:
        case FaultKind::tcp_reset:
        case FaultKind::tcp_half_open:
        case FaultKind::connect_refused:
        case FaultKind::close_after_response:
        case FaultKind::close_at_random:
        case FaultKind::close_on_request:
        case FaultKind::close_when_idle: return !serial;
        case FaultKind::glitch: return framing != wire::Framing::tcp;
        case FaultKind::wrong_transaction: return framing == wire::Framing::tcp;
        default: return true;
    }
}

std::uint64_t FaultCounts::total() const {
    return std::accumulate(injected.begin(), injected.end(), std::uint64_t{0});
}

FaultCounts& FaultCounts::operator+=(const FaultCounts& other) {
    for (std::size_t i = 0; i < kFaultKinds; ++i) {
        injected[i] += other.injected[i];
        recovered[i] += other.recovered[i];
    }
    exchanges += other.exchanges;
    bytes += other.bytes;
    redrawn += other.redrawn;
    return *this;
}

FaultRates& FaultRates::set(FaultKind kind, std::uint32_t of_a_million) {
    per_million[index(kind)] = of_a_million;
    return *this;
}

FaultRates& FaultRates::every(FaultKind kind, Duration mean) {
    mean_between[index(kind)] = mean;
    return *this;
}

FaultRates FaultRates::all(std::uint32_t per_million, Duration mean_between) {
    FaultRates rates;
    for (std::size_t i = 0; i < kFaultKinds; ++i) {
        const auto kind = static_cast<FaultKind>(i);
        if (is_timed(kind))
            rates.every(kind, mean_between);
        else
            rates.set(kind, per_million);
    }
    return rates;
}

Duration Turnaround::draw(Random& random) const {
    switch (shape) {
        case Shape::constant: return least;
        case Shape::uniform: return random.between(least, most);
        case Shape::long_tail: break;
    }
    // x^64 is above 1/2 for one x in 93.
    double part = random.fraction();
    for (int i = 0; i < 6; ++i) part *= part;
    return least + Duration(static_cast<Duration::rep>(part * static_cast<double>((most - least).count())));
}

}  // namespace takt::sim
