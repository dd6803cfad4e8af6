// The outcome of a command: its answer and its line in the audit log.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "takt/file/json.hpp"
#include "takt/host/command.hpp"
#include "takt/host/configuration.hpp"
#include "takt/publish/command_request.hpp"

namespace takt::publish {

enum class CommandEnd : std::uint8_t {
    done,
    refused,  ///< not executed
    unknown,  ///< perhaps executed
    expired,  ///< not executed in time
};
std::string_view name(CommandEnd end);

/// What became of a command.
struct CommandAnswer {
    std::string id;        ///< empty: the request has none
    std::string command;   ///< empty: the request has none
    std::string variable;  ///< or the device; empty: the request has none
    CommandEnd end = CommandEnd::refused;
    std::string reason;  ///< a stable word; empty: none
    std::string detail;  ///< for a reader; empty: none
    file::Json value;    ///< asked for, or of `get` found; null: none
    file::Json read_back;
    std::string quality;                       ///< of `get`; empty: none
    std::optional<std::int64_t> last_good_ns;  ///< of `get`: when the value was last read well, or set
    std::int64_t wall_ns = 0;
};

/// Where a command came from.
struct CommandOrigin {
    std::string output;
    std::string broker;
    std::string topic;
};

/// The answer of a request that is not executed.
[[nodiscard]] CommandAnswer answer_of(const CommandRequest& request, const CommandRefused& refused,
                                      std::int64_t wall_ns);

/// The answer of a request that the host has ended.
/// @param configuration  of the outcome's slot
[[nodiscard]] CommandAnswer answer_of(const CommandRequest& request, const host::Outcome& outcome,
                                      const host::Configuration& configuration, std::int64_t wall_ns);

/// The payload: JSON.
[[nodiscard]] std::string answer_message(const CommandAnswer& answer);

/// Only id, outcome, reason and time, for a broker whose packet limit excludes the whole answer.
[[nodiscard]] std::string short_answer_message(const CommandAnswer& answer);

/// The line of JSON, with its end, in the place of lines that could not be written.
[[nodiscard]] std::string missing_lines_text(std::string_view output, std::uint64_t count,
                                             std::int64_t wall_ns);

/// A JSON object in one line, with its line feed.
[[nodiscard]] std::string audit_line(const CommandOrigin& origin, const CommandAnswer& answer);

}  // namespace takt::publish
