// A random project with one MQTT output, as its text.
#pragma once

#include <cstddef>
#include <string>

#include "takt/sim/random.hpp"

namespace takt::gatewaysim {

/// The names of what commands may concern.
inline constexpr const char* kOutput = "cloud";
inline constexpr const char* kControlTopic = "takt/cloud";
inline constexpr const char* kMode = "Mode";      ///< a local that is listed
inline constexpr const char* kGo = "Go";          ///< a trigger that is listed
inline constexpr const char* kSecret = "Secret";  ///< a local that is not listed

struct DrawnProject {
    std::string text;
    std::size_t brokers = 1;
    bool heavy = false;  ///< many bytes: long texts that change
};

/// One or two lines with one to three devices each. Writable variables are `…set` (listed, written on
/// change), `…order` (listed) and `…hidden` (not listed).
[[nodiscard]] DrawnProject draw_project(sim::Random random);

}  // namespace takt::gatewaysim
