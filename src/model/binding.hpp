// What variables of servers are bound to, in parts.
#pragma once

#include "interpretation.hpp"

namespace takt::model {

/// A mapping behind a key of `outer` with a reader of its own.
Reader inner(Interpretation& state, const Reader& outer, std::string_view key, const Node& node,
             Object object);

/// What the keys `variable`, `local` and `instrument` name; reports where there is no such thing, or one of
/// another type.
const Variable* read_polled(Interpretation& state, Reader& reader, const Variable& variable);
std::optional<LocalSource> read_local_name(Interpretation& state, Reader& reader, const Variable& variable);
std::optional<InstrumentSource> read_instrument_name(Interpretation& state, Reader& reader);

/// `sine`, `ramp`, `random_walk`, `counter`.
Generator read_generator(Interpretation& state, Reader& outer, std::string_view key, const Node& node);

}  // namespace takt::model
