// What a project will do, in one line: requests, cycle, load, oldest value.
#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <string>

#include "takt/base/time.hpp"
#include "takt/file/json.hpp"
#include "takt/plan/proof.hpp"
#include "takt/report/drawing/texts.hpp"

namespace takt::report {

/// The greatest figures of all lines of a project.
struct Outlook {
    std::size_t lines = 0;     ///< with requests; the other figures are of these
    std::size_t requests = 0;  ///< counted requests of all lines (docs/specification.md, section 4)
    Duration cycle{};          ///< the longest cycle
    std::size_t slowest = 0;   ///< the line with that cycle; index into the project's lines
    double utilization = 0;    ///< the highest load, estimated
    std::size_t busiest = 0;   ///< the line with that load
    /// The greatest proved age of a polled value. Nothing: no value has a period, or one has no proved age.
    std::optional<Duration> oldest;
    std::string oldest_name;  ///< that variable
};

[[nodiscard]] Outlook outlook(const model::Project& project, const plan::Proof& proof);

/// One line of text: "requests: 7, cycle 170 ms, line busy 45.1 %, oldest value 672 ms (Energy)". With
/// several lines of the project the cycle and the load name theirs. Empty if no line has requests.
[[nodiscard]] std::string outlook_text(const Texts& texts, const model::Project& project,
                                       const Outlook& outlook);

/// {"lines", "requests", "cycle_us", "utilization", "oldest_us": null where it is not proved, "oldest"}
[[nodiscard]] file::Json outlook_json(const Outlook& outlook);

}  // namespace takt::report
