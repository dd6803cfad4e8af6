// Packets of link type upper_pdu (Wireshark, wsutil/exported_pdu_tlvs.h): tags, then the payload of the
// protocol that a tag names. A tag is its number, its length and its value, all in network order.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "takt/base/engine.hpp"

namespace takt::capture {

inline constexpr std::string_view kRtuDissector = "mbrtu";
inline constexpr std::string_view kDataDissector = "data";

/// A packet of that link type.
[[nodiscard]] std::string upper_pdu(std::string_view dissector, std::string_view payload);

struct UpperPdu {
    std::string_view dissector;
    Bytes payload;
};

/// Points into `packet`. @returns nothing: its tags are cut, or none names a dissector
[[nodiscard]] std::optional<UpperPdu> decode_upper_pdu(Bytes packet);

}  // namespace takt::capture
