#include "takt/bus/failure_time.hpp"

#include <algorithm>

#include "takt/wire/silence.hpp"

namespace takt::bus {

wire::AttemptTimes<Duration> attempt_times(const LineConfig& config, std::size_t request,
                                           std::size_t response, Duration wait) {
    return {.request = config.frame_time(request),
            .wait = wire::response_wait(config.framing, config.format, wait),
            .response = config.frame_time(response),
            .margin = config.margin,
            .silence = config.silence_before_request()};
}

Duration failure_time(const LineConfig& config, std::size_t request, std::size_t response, Duration wait) {
    return std::max(attempt_times(config, request, response, wait).failure(), config.request_gap);
}

}  // namespace takt::bus
