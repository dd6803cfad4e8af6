// Why a value is as old as it is: hop by hop from its period to its device.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "takt/file/json.hpp"
#include "takt/host/snapshot.hpp"
#include "takt/report/drawing/texts.hpp"

namespace takt::web {

/// One station on the way of a value.
struct WhyHop {
    enum class Kind : std::uint8_t { enable, period, trigger, queue, line, device, back_off };
    enum class State : std::uint8_t {
        ok,
        wait,     ///< it makes the value older, as the project says
        trouble,  ///< it makes the value older than the project says
    };
    Kind kind = Kind::period;
    State state = State::ok;
    std::string_view text;  ///< the code "web.why.…"
    report::Texts::Arguments arguments = {};
    std::optional<Duration> time = {};         ///< period, cycle, response time or pause
    std::optional<Error> error = {};           ///< argument "error"
    std::optional<value::Reason> reason = {};  ///< argument "reason"
};

/// @param snapshot  with values, statistics and plan
[[nodiscard]] std::vector<WhyHop> why(const report::Texts& texts, const host::Snapshot& snapshot,
                                      value::SlotId slot);

/// The object of GET /why.
[[nodiscard]] file::Json why_json(const report::Texts& texts, const host::Snapshot& snapshot,
                                  value::SlotId slot);

}  // namespace takt::web
