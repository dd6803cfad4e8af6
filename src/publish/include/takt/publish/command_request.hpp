// A command of a message: what it asks for, and why it is refused. docs/mqtt-messages.md.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "takt/base/time.hpp"
#include "takt/file/json.hpp"

namespace takt::publish {

enum class CommandVerb : std::uint8_t { set, write, trigger, get, enable, disable };
std::string_view name(CommandVerb verb);

/// Why a command is not executed. The names are stable.
enum class CommandRefusal : std::uint8_t {
    retained,          ///< the broker kept it
    not_subscribed,    ///< it arrived before the broker accepted the subscriptions of the connection
    expired,           ///< it is older than its expiry
    clock,             ///< sent more than a minute in the future
    not_listed,        ///< the project does not let commands of this output concern the variable
    unknown_variable,  ///< no variable, local or device has this name
    malformed,         ///< a key or a value is not as documented
    too_many,          ///< too many commands have no outcome yet
    duplicate_id,      ///< another command had this id
    no_poll_enable,    ///< the device has no local that switches it
};
std::string_view name(CommandRefusal refusal);

struct CommandRefused {
    CommandRefusal why = CommandRefusal::malformed;
    std::string detail;  ///< the key, the value and what is allowed
};

struct CommandRequest {
    static constexpr std::size_t kMostBytes = std::size_t{8} << 10U;  ///< of a payload
    static constexpr std::size_t kLongestId = 64;
    static constexpr std::size_t kLongestName = 256;
    static constexpr std::size_t kLongestValue = 1024;  ///< a string variable has 250 bytes at most
    static constexpr Duration kLongestExpiry = std::chrono::hours(24);

    std::string id;  ///< printable ASCII
    CommandVerb verb = CommandVerb::get;
    std::string subject;               ///< the variable; the device of enable and disable
    std::optional<std::string> value;  ///< of set and write: as value::parse() reads it
    enum class ValueForm : std::uint8_t {
        plain,   ///< a payload: a value of any type
        string,  ///< a JSON string: for variables of type `string` only
        other,   ///< a JSON number or bool: for all others
    };
    ValueForm form = ValueForm::plain;
    std::optional<std::int64_t> sent_ns;     ///< wall time
    std::optional<std::int64_t> expires_ns;  ///< wall time
    std::optional<Duration> expiry;
};

/// A request as far as it could be parsed, for its answer.
struct ParsedCommand {
    CommandRequest request;
    std::optional<CommandRefused> refused;
};

/// Parses the payload of a command topic. Never fails: a payload that is no request is refused as malformed.
[[nodiscard]] ParsedCommand parse_command(std::string_view payload);

/// The request of a topic `set/<variable>`, with a plain value.
[[nodiscard]] ParsedCommand plain_set(std::string id, std::string_view variable, std::string_view payload);

}  // namespace takt::publish
