// What was learnt of the devices of a project, as a file next to it: gaps (gaps: learn) and response times.
//
// A JSON object:
//   {"takt_learnt": 2, "lines": [{"line": "rs485-1", "devices": [{"device": "Boiler", "address": 16, "areas":
//     [{"area": "holding_register", "confirmed": ["0..10", "15..35"], "refused": [{"items": "11..14",
//       "exception": 2, "since": "2026-11-21T17:03:20Z", "checked": "2026-11-21T18:03:20Z"}],
//       "most_items": 60}],
//     "times": {"exchanges": 3120, "longest_us": 7612, "p999_us": 7100, "counts": [[4095, 3100], [7679, 20]],
//       "attempts": 3124, "late": 3, "lateness_us": 412300, "next_latest_us": [407100, 398000]}}],
//       "lengths_off": true}]}
// Ranges are ascending and do not overlap, both ends included, as on the wire; times are UTC; `most_items` is
// written only if known. `times` is written if something was measured (model::LearntTimes): each of `counts`
// has the longest time in microseconds and how many exchanges it counts; their sum is `exchanges`.
// Without `next_latest_us` the late responses count as equally late.
// `lengths_off` is written for a line whose devices sent lengths that are off by one. Unknown keys are
// ignored. Version 1 has no `times`; it is read, and replaced by version 2.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "takt/model/findings.hpp"
#include "takt/model/project.hpp"

namespace takt::file {

/// Limit of the file's size.
inline constexpr std::size_t kMaxLearntBytes = std::size_t{8} << 20;

/// By line and device of the project.
using LearntOfLines = std::vector<std::vector<model::Learnt>>;
using TimesOfLines = std::vector<std::vector<model::LearntTimes>>;
/// By line: headers of responses had a length that is off by one.
using LengthsOfLines = std::vector<bool>;

/// The text of the file. Gaps of devices that do not learn them, and devices without results, are omitted.
/// @param times        of each device, or empty
/// @param lengths_off  of each line, or empty
[[nodiscard]] std::string learnt_text(const model::Project& project, const LearntOfLines& learnt,
                                      const TimesOfLines& times, std::chrono::sys_seconds now,
                                      const LengthsOfLines& lengths_off = {});

/// The result of reading such a text.
struct Recalled {
    bool whole = false;  ///< the text is valid; else nothing was applied
    /// Warnings, with the location's `file`: learnt.damaged (value: where in the file), or learnt.stale
    /// (line, device) for a device of the file that the project does not have, or not at that address. At
    /// the line: learnt.lengths_off (line), if it does not accept such lengths.
    std::vector<model::Finding> findings;
};

/// Applies the text to the devices of the project: Device::times, and Device::learnt of those that learn
/// gaps.
/// @param file  file index of the findings' locations
[[nodiscard]] Recalled recall(std::string_view text, std::chrono::sys_seconds now, std::uint32_t file,
                              model::Project& project);

}  // namespace takt::file
