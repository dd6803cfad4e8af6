// Frames as the faults see them, without the code of the engines: own checksums, own lengths, no limits.
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

/// What is in a good frame; nothing where it is none.
std::optional<OpenFrame> open_frame(wire::Framing framing, Bytes frame);

/// With good checksums and lengths, also beyond what a frame may hold.
ByteString close_frame(wire::Framing framing, const OpenFrame& frame);

/// Characters of the normal answer to a request; 0: not known.
std::size_t answer_length(wire::Framing framing, Bytes request_pdu);

/// Serial framings: whether somebody who listens could take a part of `bytes` for a frame that nobody sent.
///
/// RTU has no framing but silence and length, so a frame may begin at any character; it ends where its
/// function says (as a request, as a response) or at the end of `bytes`. It is to or from one of `units`, and
/// its checksum is good.
/// @param old      the first characters were there before: what ends among them is not looked for
/// @param clean    those behind are a good frame: only what begins before them is looked for
/// @param genuine  a frame that may be found, for it was sent
bool misleads(wire::Framing framing, Bytes bytes, std::size_t old, bool clean, Bytes genuine,
              const UnitSet& units);

}  // namespace takt::sim
