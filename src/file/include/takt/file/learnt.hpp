// What was learnt of the devices of a project (gaps: learn), as a file beside it.
//
// A JSON object:
//   {"takt_learnt": 1, "lines": [{"line": "rs485-1", "devices": [{"device": "Boiler", "address": 16, "areas":
//     [{"area": "holding_register", "confirmed": ["0..10", "15..35"], "refused": [{"items": "11..14",
//       "exception": 2, "since": "2026-11-21T17:03:20Z", "checked": "2026-11-21T18:03:20Z"}],
//       "most_items": 60}]}]}]}
// Ranges are ascending and do not overlap, both ends included, as on the wire; times are UTC; `most_items` is
// there where it is known. Unknown keys are passed over.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "takt/model/findings.hpp"
#include "takt/model/project.hpp"

namespace takt::file {

/// Most bytes of such a file.
inline constexpr std::size_t kMaxLearntBytes = std::size_t{8} << 20;

/// By line and device of the project.
using LearntOfLines = std::vector<std::vector<model::Learnt>>;

/// The text of the file. Devices that do not learn, or of which nothing is known, are left out.
[[nodiscard]] std::string learnt_text(const model::Project& project, const LearntOfLines& learnt,
                                      std::chrono::sys_seconds now);

/// What was understood of such a text.
struct Recalled {
    bool whole = false;  ///< it is such a file; else nothing was taken from it
    /// Warnings, with the location's `file`: learnt.damaged (value: where in the file), or learnt.stale
    /// (line, device) for a device of the file that the project does not have, or not at that address.
    std::vector<model::Finding> findings;
};

/// Puts what the text says into the devices of the project that learn (Device::learnt).
/// @param file  for the findings' places
[[nodiscard]] Recalled recall(std::string_view text, std::chrono::sys_seconds now, std::uint32_t file,
                              model::Project& project);

}  // namespace takt::file
