// How a frame becomes a wrong one.
#pragma once

#include "frames.hpp"
#include "takt/sim/faults.hpp"
#include "takt/sim/random.hpp"

namespace takt::sim {

/// A character spoiled, lost, added or repeated, by kind. `frame` is not empty.
ByteString spoil_characters(Random& random, FaultKind kind, Bytes frame);

/// The beginning of it, without the end.
ByteString cut_short(Random& random, Bytes frame);

/// Characters of no meaning in its place; over Modbus TCP behind no header, or behind a good one.
ByteString garbage_for(Random& random, wire::Framing framing, Bytes frame);

std::uint8_t any_byte(Random& random);
ByteString any_bytes(Random& random, std::size_t count);

/// Whether the kind makes another answer of the answer to that request; of the others it tells nothing.
bool alters(FaultKind kind, Bytes request_pdu, const OpenFrame& answer);

/// Makes the wrong answer of a good one; only where alters().
/// @param taken  units whose answers are still on their way: never the wrong unit
void alter(Random& random, FaultKind kind, const UnitSet& units, const UnitSet& taken, OpenFrame& answer);

}  // namespace takt::sim
