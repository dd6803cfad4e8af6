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
    Duration delay{};    ///< the longest seen: from the end of the request to the first byte of the response
    Duration limit{};    ///< the value of the setting in the project; the learnt time-out before
    Duration advised{};  ///< a value with which all responses seen would have been in time; the one since
    friend bool operator==(const DelayFinding&, const DelayFinding&) = default;
};
/// The key of the setting in the project file, or "learnt_timeout".
std::string_view name(DelayFinding::Setting setting);

}  // namespace takt::poll
