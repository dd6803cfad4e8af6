// The parts of bindings of server variables.
#pragma once

#include "servers/interpretation.hpp"

namespace takt::model {

/// The mapping of a key of `outer`, with its own reader.
Reader inner(Interpretation& state, const Reader& outer, std::string_view key, const Node& node,
             Object object);

/// The age from which on a value that is read with that period is stale.
Duration stale_after(Duration every);

/// The object named by the key `variable`, `local` or `instrument`; reports a missing one and one of another
/// type.
Variable* read_polled(Interpretation& state, Reader& reader, const Variable& variable);
std::optional<LocalSource> read_local_name(Interpretation& state, Reader& reader, const Variable& variable);
/// The service variable that `variable` or `local` names.
std::optional<LocalSource> read_service_name(Interpretation& state, Reader& reader, std::string_view key,
                                             const Variable& variable);
std::optional<InstrumentSource> read_instrument_name(Interpretation& state, Reader& reader);
/// The command named by the key `instrument` of a destination.
std::optional<InstrumentSink> read_instrument_command(Interpretation& state, Reader& reader,
                                                      const Variable& variable);

/// `sine`, `ramp`, `random_walk`, `counter`.
Generator read_generator(Interpretation& state, Reader& outer, std::string_view key, const Node& node);

}  // namespace takt::model
