// What a command concerns in a project, and what its outputs permit.
#pragma once

#include <expected>
#include <set>

#include "takt/host/command.hpp"
#include "takt/host/configuration.hpp"
#include "takt/model/output.hpp"
#include "takt/publish/command_request.hpp"

namespace takt::publish {

/// What the commands of an output may concern, in one configuration.
struct CommandRights {
    host::ConfigurationPtr configuration;
    std::set<value::SlotId> commandable;  ///< for all commands
    std::set<value::SlotId> readable;     ///< for `get` also
};

/// Commandable: what the output lists. Readable: what it delivers.
[[nodiscard]] CommandRights rights_of(host::ConfigurationPtr configuration, const model::Output& output);

/// The command for the host, without tag and expiry.
///
/// `set` of a variable that is written on change becomes `write`: a value that waits for a dead device would
/// be written after the command has expired.
[[nodiscard]] std::expected<host::Command, CommandRefused> target_of(const CommandRequest& request,
                                                                     const CommandRights& rights);

}  // namespace takt::publish
