// How long a transaction without a response takes the line.
#pragma once

#include <algorithm>
#include <cstddef>

#include "takt/base/time.hpp"
#include "takt/bus/transaction.hpp"
#include "takt/wire/frame.hpp"
#include "takt/wire/line_timing.hpp"

namespace takt::bus {

/// From the start of the request until the next one may be sent.
/// @param silence            TransactionEngine::silence()
/// @param request, response  the lengths of their PDUs
/// @param wait               Transaction::wait
[[nodiscard]] inline Duration failure_time(const LineConfig& config, Duration silence, std::size_t request,
                                           std::size_t response, Duration wait) {
    const auto characters = [&](std::size_t pdu) {
        const auto count = wire::frame_length(config.framing, pdu);
        return config.is_serial() ? wire::transmission_time(config.format, count) : Duration::zero();
    };
    const Duration time_out = std::max(wait, silence) + characters(response) + config.margin;
    return std::max(characters(request) + time_out + silence, config.request_gap);
}

}  // namespace takt::bus
