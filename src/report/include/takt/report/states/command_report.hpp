// Outcomes of commands as lines of text (standard input, control socket) and as JSON. docs/commands/run.md.
#pragma once

#include <string>
#include <string_view>

#include "takt/base/result.hpp"
#include "takt/file/json.hpp"
#include "takt/host/command.hpp"
#include "takt/host/configuration.hpp"
#include "takt/report/drawing/texts.hpp"

namespace takt::report {

/// The answer to a command, with its line end: "ok NAME VALUE", "ok NAME VALUE bad timeout", "ok NAME VALUE
/// rounded", "ok NAME VALUE waiting", "ok NAME VALUE not_written: text", "error CODE text", "done NAME",
/// "refused NAME exception 2 wanted 50", "refused NAME differs written 50 read 49".
[[nodiscard]] std::string outcome_line(const Texts& texts, const host::Configuration& configuration,
                                       const host::Outcome& outcome);

/// Why the device does not get the value of a `set`, and what sends it; empty if it gets the value.
[[nodiscard]] std::string not_written_text(const Texts& texts, const host::Configuration& configuration,
                                           const host::Outcome& outcome);

/// {"event":"answer"|"error"|"outcome", …}
[[nodiscard]] file::Json outcome_json(const Texts& texts, const host::Configuration& configuration,
                                      const host::Outcome& outcome);

/// The answer to a line that is no command, or whose command was not accepted.
/// @param command, name  as far as they were understood; may be empty
[[nodiscard]] std::string error_line(std::string_view code, std::string_view text);
[[nodiscard]] std::string error_line(const Texts& texts, const Error& error);
[[nodiscard]] file::Json error_json(const Texts& texts, const Error& error, std::string_view command,
                                    std::string_view name);

/// The answer to `quit`.
[[nodiscard]] std::string quit_line();
[[nodiscard]] file::Json quit_json();

/// Why a value is not good or a write was not done, as data: "timeout", "exception 2"; empty for Reason::ok.
[[nodiscard]] std::string reason_word(value::Reason reason);

}  // namespace takt::report
