// Where the readers of traffic taps get their frames from.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "takt/host/session.hpp"
#include "takt/host/traffic_tap.hpp"
#include "takt/model/line.hpp"

namespace takt::console {

using LineOf = std::function<std::optional<model::Line>(const host::TrafficRecord&)>;

/// Where frames come from: a ring that the I/O thread writes and that never makes it wait. Called by one
/// thread.
struct TapSource {
    std::function<std::optional<host::TrafficRecord>()> next;
    std::function<std::uint64_t()> missed;  ///< frames that were overwritten before they were read
    LineOf line_of;
    bool overheard = false;  ///< the frames of others on a line: requests count as received
};

/// @param session  with `traffic`
[[nodiscard]] TapSource tap_source(const std::shared_ptr<host::Session>& session);
[[nodiscard]] TapSource tap_source(const host::TrafficTap& tap);

/// The period of a thread that reads a tap: the ring holds the frames of a longer time.
inline constexpr auto kTapPeriod = std::chrono::milliseconds(20);

}  // namespace takt::console
