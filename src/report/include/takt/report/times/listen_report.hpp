// Reports of a line that is listened to: exchanges as lines of text and JSON, the summary, the project.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "takt/capture/heard_project.hpp"
#include "takt/capture/line_statistics.hpp"
#include "takt/file/json.hpp"
#include "takt/report/drawing/texts.hpp"
#include "takt/report/times/heard_names.hpp"

namespace takt::report {

/// A line that is listened to.
struct ListenRun {
    std::string port;
    /// The line without devices; of a capture and of a pseudo-terminal the settings mean nothing.
    model::Line connection;
    bool has_settings = true;     ///< the port has the bit rate and the character format
    bool settings_given = false;  ///< by the user
    const capture::LineStatistics& statistics;
    const HeardNames& names;
    std::uint64_t faulty_characters = 0;  ///< that the port reported
    std::string line = {};                ///< of a capture: its name
    bool one_of_several = false;          ///< lines of the capture
};

/// "9600 8N1, RTU"; without known settings "RTU".
[[nodiscard]] std::string line_setting_text(const model::Line& connection, bool has_settings);

/// One line each, without its end: the time, the exchange in words, the response time, names with values.
[[nodiscard]] std::string exchange_line(const Texts& texts, const HeardNames& names, const std::string& time,
                                        const capture::Exchange& exchange);
[[nodiscard]] std::string stray_line(const Texts& texts, const HeardNames& names, const std::string& time,
                                     const capture::LineFrame& frame);
[[nodiscard]] std::string damaged_line(const Texts& texts, const std::string& time,
                                       const capture::DamagedBytes& damaged);

/// The same as objects (docs/commands/listen.md).
[[nodiscard]] file::Json exchange_json(const HeardNames& names, const std::string& time,
                                       const capture::Exchange& exchange);
[[nodiscard]] file::Json stray_json(const std::string& time, const capture::LineFrame& frame);
[[nodiscard]] file::Json damaged_json(const std::string& time, const capture::DamagedBytes& damaged);

/// The line, its faults, its devices, its masters and their requests.
/// @param most  characters of a line of the tables
[[nodiscard]] std::string listen_summary(const Texts& texts, const ListenRun& run, std::size_t most);
[[nodiscard]] file::Json listen_json(const ListenRun& run);

/// The project of what was heard on one line or several (capture::heard_project()).
[[nodiscard]] std::string listen_project(const Texts& texts, std::span<const ListenRun> runs,
                                         int stretch = 1);

}  // namespace takt::report
