// Turns valid frames into damaged ones.
#pragma once

#include "faults.hpp"
#include "frames.hpp"
#include "takt/sim/random.hpp"

namespace takt::sim {

/// Changes, drops, inserts or repeats one character, by kind. `frame` is not empty.
ByteString spoil_characters(Random& random, FaultKind kind, Bytes frame);

/// The frame without its end.
ByteString cut_short(Random& random, Bytes frame);

/// Random characters instead of the frame. Modbus TCP: with a damaged header, or behind a valid one.
ByteString garbage_for(Random& random, wire::Framing framing, Bytes frame);

/// Another transaction id: 0, one more, one less, the bytes in reverse order, or a distant one.
std::uint16_t other_transaction(Random& random, std::uint16_t own);

/// The copy of a valid frame. Modbus TCP: half of the copies have another transaction id.
ByteString copy_of(Random& random, wire::Framing framing, Bytes frame);

std::uint8_t any_byte(Random& random);
ByteString any_bytes(Random& random, std::size_t count);

/// Whether the kind changes the answer to that request into another valid frame.
bool alters(FaultKind kind, Bytes request_pdu, const OpenFrame& answer);

/// Changes a valid answer into a wrong one; only if alters().
void alter(Random& random, FaultKind kind, const UnitSet& units, OpenFrame& answer);

}  // namespace takt::sim
