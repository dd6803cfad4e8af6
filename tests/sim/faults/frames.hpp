// Frames as the fault injection sees them: own checksums and lengths, independent of the engines, without
// limits.
#pragma once

#include <bitset>
#include <cstdint>
#include <optional>
#include <vector>

#include "takt/base/engine.hpp"
#include "takt/wire/frame.hpp"

namespace takt::sim {

using ByteString = std::vector<std::uint8_t>;
using UnitSet = std::bitset<256>;

struct OpenFrame {
    std::uint8_t unit = 0;
    std::uint16_t transaction = 0;  // tcp
    ByteString pdu;                 // at least the function
};

/// The content of a valid frame; nothing for any other one.
std::optional<OpenFrame> open_frame(wire::Framing framing, Bytes frame);

/// Encodes a frame with valid checksum and length, even beyond the protocol's limits.
ByteString close_frame(wire::Framing framing, const OpenFrame& frame);

/// Characters of the normal answer to a request; 0: not known.
std::size_t answer_length(wire::Framing framing, Bytes request_pdu);

/// The length of the response at the beginning of a stream of valid responses; all of `bytes` where it is not
/// known.
std::size_t first_response_length(wire::Framing framing, Bytes bytes);

/// Serial framings: whether a receiver could take a part of `bytes` for a frame that was never sent.
///
/// RTU delimits frames only by silence and length. So a frame may begin at any character and end at the
/// length of its function (as request or response) or at the end of `bytes`. Its unit is one of `units` and
/// its checksum is valid.
/// @param old  leading characters that were checked before: no frame that ends among them counts
/// @param clean  trailing characters that form a valid frame: only frames that begin before them count
/// @param genuine  a frame that was sent and may be found
bool misleads(wire::Framing framing, Bytes bytes, std::size_t old, bool clean, Bytes genuine,
              const UnitSet& units);

}  // namespace takt::sim
