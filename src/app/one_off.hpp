// What `read`, `write` and `raw` have in common: how they end, and arguments that cannot be meant.
#pragma once

#include <cstdint>
#include <string_view>

#include "takt/app/client.hpp"
#include "takt/app/exit_code.hpp"
#include "takt/app/texts.hpp"
#include "takt/file/json.hpp"

namespace takt::app {

/// How it ended without what was asked for, told. With --json `object` says so on stdout, too.
/// @param client  may be nullptr: never connected
ExitCode ended_by(const Texts& texts, const ClientOptions& options, const Client* client, const Error& error,
                  file::Json object, std::string_view interrupted = "app.client.interrupted");

/// What the objects of all of them begin with.
file::Json object_of(const ClientOptions& options);

/// Arguments that cannot be sent, whatever is wrong with them: told.
ExitCode bad_arguments(const Texts& texts, const Error& error);

/// Whether options of registers were given for bits, told.
bool is_for_registers(const Texts& texts, wire::Area area, bool given);

/// Whether that many items from `start` on are more than there are, told.
bool is_beyond(const Texts& texts, std::uint64_t start, std::uint64_t items);

}  // namespace takt::app
