// Commands: one action with an expiry and exactly one outcome (docs/architecture.md).
#pragma once

#include <cstdint>
#include <string_view>

#include "takt/base/time.hpp"
#include "takt/value/store.hpp"
#include "takt/value/value.hpp"

namespace takt::value {

/// Chosen by the sender of the command and returned with its outcome.
using CommandId = std::uint64_t;

/// Writes `value` to the variable of `slot`.
struct WriteCommand {
    CommandId id = 0;
    SlotId slot;
    Value value;
    Instant expires = kNever;  ///< not sent after this instant
};

enum class CommandResult : std::uint8_t {
    done,     ///< the device confirmed it
    refused,  ///< it was not done: an exception, a value that does not fit or was read back as another one, a
              ///< device that does not answer
    unknown,  ///< it was sent, but may or may not have been executed, or could not be verified
    expired,  ///< it was not sent in time
    queue_full,  ///< the queue was full
};
std::string_view name(CommandResult result);

struct CommandOutcome {
    CommandId id = 0;
    SlotId slot;
    CommandResult result = CommandResult::done;
    Reason reason = Reason::ok;  ///< why it was refused or is unknown
    bool rounded = false;        ///< what was written is the nearest value the device can hold
    Instant t;
    Value written;    ///< with Reason::differs: what was written
    Value read_back;  ///< and what was read
};

}  // namespace takt::value
