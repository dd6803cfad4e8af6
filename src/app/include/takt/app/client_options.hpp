// The options that the commands have in common which talk to one device.
#pragma once

#include <cstdint>
#include <string>

#include "takt/base/time.hpp"

namespace takt::app {

/// What `read`, `write` and `raw` have in common: whom to ask, and how long to wait.
struct ClientOptions {
    std::string target;
    std::uint8_t unit = 1;
    Duration timeout = std::chrono::seconds(1);
    std::uint16_t attempts = 1;
    bool json = false;
    std::string traffic;
    bool adaptive = false;   ///< the first attempt waits only as long as the answers so far let expect
    bool reconnect = false;  ///< a stream out of step is made anew instead of being the end
};

}  // namespace takt::app
