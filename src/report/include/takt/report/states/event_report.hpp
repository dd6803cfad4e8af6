// Events of a running project as text and as JSON. docs/commands/run.md.
#pragma once

#include <optional>
#include <string>

#include "takt/file/json.hpp"
#include "takt/host/configuration.hpp"
#include "takt/host/event.hpp"
#include "takt/report/drawing/texts.hpp"
#include "takt/value/value.hpp"

namespace takt::report {

/// One line without its end and without a time. Empty for events that need no line (a write that was done, a
/// write that differs, which VerifyFailed reports).
[[nodiscard]] std::string event_text(const Texts& texts, const host::Configuration& configuration,
                                     const host::Event& event);

/// One object with `event` and `time_ms` since `started`. Null for events that need no line.
[[nodiscard]] file::Json event_json(const Texts& texts, const host::Configuration& configuration,
                                    Instant started, const host::Event& event);

/// The members that the event of a finding has too; null: none.
[[nodiscard]] file::Json finding_json(const std::optional<poll::DelayFinding>& finding);
[[nodiscard]] file::Json finding_json(const std::optional<poll::NoiseFinding>& finding);

/// Events that a slow reader missed.
[[nodiscard]] std::string missed_text(const Texts& texts, std::uint64_t count);
[[nodiscard]] file::Json missed_json(std::uint64_t count);

/// The text of a notice.
[[nodiscard]] std::string notice_text(const Texts& texts, const host::Notice& notice);

/// A value with its unit; "–" for none.
[[nodiscard]] std::string value_text(const host::Configuration& configuration, value::SlotId slot,
                                     const value::Value& value);

/// Name of the device of a slot; empty for locals.
[[nodiscard]] std::string device_name(const host::Configuration& configuration, value::SlotId slot);

}  // namespace takt::report
