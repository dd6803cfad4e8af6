// The state of a running project: as JSON, which the control socket answers with, and as the text that
// `takt ctl` makes of this JSON. docs/commands/ctl.md.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "takt/file/json.hpp"
#include "takt/host/command.hpp"
#include "takt/host/configuration.hpp"
#include "takt/host/snapshot.hpp"
#include "takt/report/drawing/texts.hpp"

namespace takt::report {

/// Health, load, cycle and the states of lines and devices.
/// @param snapshot  with values and statistics
/// @param time      of the snapshot, as text
[[nodiscard]] file::Json status_json(const Texts& texts, const host::Snapshot& snapshot,
                                     const std::string& time);

/// Of a device that does not answer, in the words of the list of problems in status_json().
struct DeviceTrouble {
    std::string text;   ///< what is wrong: a sentence without its stop
    std::string tried;  ///< what the program does about it
};
/// @param snapshot  with values and statistics
[[nodiscard]] DeviceTrouble device_trouble(const Texts& texts, const host::Snapshot& snapshot,
                                           std::size_t line, std::size_t device);

/// The names of all values with what is known of them before the first read.
[[nodiscard]] file::Json list_json(const host::Configuration& configuration);

/// The values whose names match (name_matches()).
/// @param snapshot  with values; with statistics the causes of devices that do not answer are known
/// @param time      of the snapshot, as text
[[nodiscard]] file::Json values_json(const host::Snapshot& snapshot, const std::string& time,
                                     std::string_view pattern);

/// One value, with the keys of an entry of values_json().
/// @param outcome  of a `get` without an error
[[nodiscard]] file::Json get_json(const host::Configuration& configuration, const host::Outcome& outcome);

/// The text of what the functions above return; keys that are missing are left out.
/// @param columns  of the terminal. Words of the tables are cut so that rows fit; names of variables and
///                 qualities are not, so a row may be longer.
[[nodiscard]] std::string status_text(const Texts& texts, const file::Json& status,
                                      std::size_t columns = SIZE_MAX);
[[nodiscard]] std::string list_text(const Texts& texts, const file::Json& list,
                                    std::size_t columns = SIZE_MAX);
[[nodiscard]] std::string values_text(const Texts& texts, const file::Json& values,
                                      std::size_t columns = SIZE_MAX);

/// "ok NAME VALUE" of get_json(), not escaped, without line end; behind it quality and reason of a value that
/// is not good.
[[nodiscard]] std::string get_line(const file::Json& value);

/// "bad, time-out", "bad, not answering (bad checksum)" of an entry of values_json() or of get_json().
[[nodiscard]] std::string quality_text(const Texts& texts, const file::Json& value);

/// The state of a device in words, with the reason of its last failure. A device whose responses are damaged,
/// late or do not fit is not called silent.
/// @param state  poll::name()
/// @param cause  device_cause()
[[nodiscard]] std::string device_state_text(const Texts& texts, std::string_view state,
                                            std::string_view cause, bool troubled);

/// poll::FailureShare::State::failing, and its link is up.
[[nodiscard]] bool fails_often(const poll::DeviceCondition& condition);

/// fails_often(), or it refuses often.
[[nodiscard]] bool is_troubled(const poll::DeviceStatistics& device);

/// Only the transaction id of the last foreign response is another one.
[[nodiscard]] bool has_other_id(const poll::DeviceTraffic& device);

/// Most of the responses that were missed came after the time-out.
[[nodiscard]] bool mostly_late(const poll::DeviceStatistics& device);

/// It does not answer in time, and was not heard of otherwise.
[[nodiscard]] bool answers_late(const poll::DeviceStatistics& device);

/// reason_word() of the last failure of a device; "late" if it answers_late(); empty: none
[[nodiscard]] std::string device_cause(const poll::DeviceStatistics& device);

[[nodiscard]] std::string device_state_text(const Texts& texts, const poll::DeviceStatistics& device);

/// The word of a line's state in JSON: "connected", "never_connected", "lost".
[[nodiscard]] std::string_view link_word(const host::Snapshot::Line& line);

/// Whether a name matches a pattern: `*` stands for any characters, `?` for one. A pattern without them
/// matches each name that contains it; an empty one matches all.
[[nodiscard]] bool name_matches(std::string_view pattern, std::string_view name);

}  // namespace takt::report
