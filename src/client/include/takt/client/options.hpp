// The device that a client asks, and how long it waits.
#pragma once

#include <cstdint>
#include <string>

#include "takt/base/time.hpp"

namespace takt::client {

struct Options {
    std::string target;  ///< URL as line::parse_target() reads it; the subject of errors
    std::uint8_t unit = 1;
    Duration timeout = std::chrono::seconds(1);  ///< of a response, and of the connection attempt
    std::uint16_t attempts = 1;                  ///< transmissions of a request, at least 1
    /// After the last attempt has timed out: how long to wait for a late response, to report its delay.
    Duration late_wait{};
    bool adaptive = false;  ///< the time-out of all attempts but the last follows the measured response times
    bool reconnect = false;  ///< a stream out of step is reopened; false: it ends the request
};

}  // namespace takt::client
