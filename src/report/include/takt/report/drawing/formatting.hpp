// Times, functions, areas and requests as text.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "takt/base/time.hpp"
#include "takt/file/json.hpp"
#include "takt/plan/plan.hpp"
#include "takt/poll/availability.hpp"
#include "takt/report/drawing/texts.hpp"

namespace takt::report {

/// For JSON.
[[nodiscard]] double milliseconds(Duration duration);
[[nodiscard]] double microseconds(Duration duration);

/// "12.3 %". @param share  of 1
[[nodiscard]] std::string percent_text(double share);

/// A period, and behind it a phase that is not zero: "1 s", "1 s +300 ms".
[[nodiscard]] std::string turn_text(const Texts& texts, Duration period, Duration phase);

/// Rounded up, so that a bus time is never reported shorter than it is.
[[nodiscard]] std::int64_t whole_microseconds(Duration duration);

/// "99.98 %", rounded down: 100.00 % is without any downtime. "–" if nothing is known.
[[nodiscard]] std::string availability_text(std::optional<double> share);
/// Sets `availability_percent` (null if nothing is known) and `downtime_ms`.
void set_availability(file::Json& object, const poll::Availability& availability);

/// "0x03 500..501", with a write "0x03+0x10 500..501".
[[nodiscard]] std::string request_text(const plan::Request& request);

/// The area as options and JSON of the command line name it: "coils", "discrete", "input", "holding".
[[nodiscard]] std::string_view area_word(wire::Area area);

/// "holding 500"
[[nodiscard]] std::string item_text(wire::Area area, std::uint32_t address);

/// "7", "0..99".
[[nodiscard]] std::string range_text(const model::ItemRange& range);

/// "0x03"
[[nodiscard]] std::string function_text(wire::Function function);

/// The function code; null if there is no function.
[[nodiscard]] file::Json function_json(const std::optional<wire::Function>& function);

/// A cell of CSV (RFC 4180): in quotes if it holds a quote, the separator or an end of line.
[[nodiscard]] std::string csv_cell(std::string_view text, char separator);

}  // namespace takt::report
