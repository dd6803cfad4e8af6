// The parts of an instrument that its exchanges and its commands share.
#pragma once

#include <set>
#include <string>
#include <string_view>

#include "servers/interpretation.hpp"

namespace takt::model {

/// The bytes behind a key, with the escapes of a template; empty if invalid or missing.
std::string read_bytes(Reader& reader, std::string_view key);

/// The answer behind a key of `outer`.
/// @param names  those of measurements that are taken; takes those of this answer
AnswerFormat read_answer(Interpretation& state, Reader& outer, std::string_view key,
                         std::set<std::string>& names);

/// `start`, `start_retry`, `reset`, `silent_after` and `commands`. The exchanges must be known.
void read_commands(Interpretation& state, Reader& reader, Instrument& instrument);

}  // namespace takt::model
