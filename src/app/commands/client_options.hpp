// The options of the commands that address one device.
#pragma once

#include <string>

#include "takt/client/options.hpp"

namespace takt::app {

struct ClientOptions : client::Options {
    bool json = false;
    std::string traffic;  ///< file for the frames; "-": stderr; empty: none
};

}  // namespace takt::app
