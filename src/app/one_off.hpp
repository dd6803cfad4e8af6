// What `read`, `write` and `raw` have in common: how they end, and arguments that are out of range.
#pragma once

#include <cstdint>
#include <string_view>

#include "takt/app/client.hpp"
#include "takt/app/exit_code.hpp"
#include "takt/app/texts.hpp"
#include "takt/file/json.hpp"

namespace takt::app {

/// Reports the error that ended a command. With --json it is also printed on stdout, as `object`.
/// @param client  nullptr: never connected
/// @returns the exit code
ExitCode ended_by(const Texts& texts, const ClientOptions& options, const Client* client, const Error& error,
                  file::Json object, std::string_view interrupted = "app.client.interrupted");

/// The first keys of every object.
file::Json object_of(const ClientOptions& options);

/// Reports arguments that cannot be sent. @returns the exit code
ExitCode bad_arguments(const Texts& texts, const Error& error);

/// @returns true, and reports it, when options of registers were given for bits
bool is_for_registers(const Texts& texts, wire::Area area, bool given);

/// @returns true, and reports it, when the items from `start` on go beyond the last address
bool is_beyond(const Texts& texts, std::uint64_t start, std::uint64_t items);

}  // namespace takt::app
