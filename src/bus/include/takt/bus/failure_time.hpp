// How long a transaction without a response takes the line.
#pragma once

#include <cstddef>

#include "takt/base/time.hpp"
#include "takt/bus/transaction.hpp"
#include "takt/wire/attempt_times.hpp"

namespace takt::bus {

/// The times of one transmission of a request that has a response.
/// @param request, response  the lengths of their PDUs
/// @param wait               Transaction::wait
[[nodiscard]] wire::AttemptTimes<Duration> attempt_times(const LineConfig& config, std::size_t request,
                                                         std::size_t response, Duration wait);

/// From the start of the request until the next one may be sent.
[[nodiscard]] Duration failure_time(const LineConfig& config, std::size_t request, std::size_t response,
                                    Duration wait);

}  // namespace takt::bus
