// Frames as the judge parses them: with its own parser, CRC and LRC, so that an error of the engines' framers
// is not repeated here (MODBUS Application Protocol V1.1b3, MODBUS over Serial Line V1.02).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "takt/wire/frame.hpp"
#include "takt/wire/function.hpp"

namespace takt::judge {

using ByteVector = std::vector<std::uint8_t>;
using Words = std::vector<std::uint16_t>;

/// A request on the wire.
struct Asked {
    std::uint8_t unit = 0;
    std::uint8_t function = 0;
    std::uint16_t transaction = 0;  ///< tcp
    bool reads = false;
    wire::Area read_area = wire::Area::holding_register;
    std::uint16_t read_start = 0;
    std::uint16_t read_count = 0;
    bool writes = false;  ///< whole items
    wire::Area write_area = wire::Area::holding_register;
    std::uint16_t write_start = 0;
    Words values;        ///< that are written; bits as 0 and 1
    bool masks = false;  ///< 0x16 at write_start
    std::uint16_t and_mask = 0xFFFF;
    std::uint16_t or_mask = 0;
    ByteVector pdu;
    std::size_t normal_answer = 0;  ///< bytes of the PDU of its normal answer
};

/// Nothing: no frame of this framing, or a request that no plan sends.
[[nodiscard]] std::optional<Asked> parse_request(wire::Framing framing, std::span<const std::uint8_t> frame);

/// The answer to a request among the bytes received since.
enum class Answer : std::uint8_t {
    none,       ///< no frame that could be its answer
    good,       ///< the normal answer
    exception,  ///< a refusal
    odd,        ///< only unit and function match
};
struct Received {
    Answer answer = Answer::none;
    std::uint8_t exception = 0;
    bool among_others = false;  ///< with other bytes around it: the master may have missed it
    Words values;               ///< of a read that was answered well
};

/// The values in the PDU of a normal answer.
[[nodiscard]] Words values_in(const Asked& asked, std::span<const std::uint8_t> pdu);

/// Finds the answer anywhere in the received bytes.
[[nodiscard]] Received find_answer(wire::Framing framing, const Asked& asked,
                                   std::span<const std::uint8_t> received);

/// A frame with a valid checksum, and its PDU.
struct FoundFrame {
    std::size_t end = 0;  ///< offset behind it
    std::uint8_t unit = 0;
    ByteVector pdu;
};

/// All responses in the bytes of an RTU or ASCII line. Other bytes between them are skipped.
/// @param parsed  bytes from there on may be the beginning of a frame
[[nodiscard]] std::vector<FoundFrame> find_frames(wire::Framing framing, std::span<const std::uint8_t> bytes,
                                                  std::size_t& parsed);

/// Bytes of the complete frames at the beginning of a Modbus TCP stream.
[[nodiscard]] std::size_t complete_frames(std::span<const std::uint8_t> stream);

/// Characters of a frame with a PDU of that length.
[[nodiscard]] std::size_t frame_characters(wire::Framing framing, std::size_t pdu);

/// @param before  the CRC of the bytes before them
[[nodiscard]] std::uint16_t crc(std::span<const std::uint8_t> bytes, std::uint16_t before = 0xFFFF);

}  // namespace takt::judge
