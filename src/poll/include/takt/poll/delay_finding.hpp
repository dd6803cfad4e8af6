// A device that responds later than a setting of the project says.
#pragma once

#include <cstdint>
#include <string_view>

#include "takt/base/time.hpp"

namespace takt::poll {

struct DelayFinding {
    enum class Setting : std::uint8_t {
        response_timeout,  ///< responses came after the transaction had ended
        turnaround,        ///< responses came later than the turnaround that the project states
        learnt_timeout,    ///< responses came after the learnt time-out, which has grown since
    };
    Setting setting = Setting::response_timeout;
    Duration delay{};  ///< the longest seen: from the end of the request to the first byte of the response
    Duration limit{};  ///< the value of the setting in the project; the learnt time-out before
    /// A value with which all such responses but `later` would have been in time, from the third longest one:
    /// a single pause is no property of the device. Zero: there were fewer than three. For a learnt time-out
    /// the value since.
    Duration advised{};
    std::uint64_t count = 0;  ///< such responses: late ones of all runs, or slower ones than the turnaround
    unsigned later = 0;       ///< of them, later than `advised`
    friend bool operator==(const DelayFinding&, const DelayFinding&) = default;
};
/// The key of the setting in the project file, or "learnt_timeout".
std::string_view name(DelayFinding::Setting setting);

}  // namespace takt::poll
