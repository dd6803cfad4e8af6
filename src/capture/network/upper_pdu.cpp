#include "network/upper_pdu.hpp"

#include <cstdint>

#include "files/big_endian.hpp"

namespace takt::capture {
namespace {

constexpr std::uint16_t kEnd = 0;
constexpr std::uint16_t kDissectorName = 12;
constexpr std::size_t kTag = 4;

void put_tag(std::string& out, std::uint16_t tag, std::size_t length) {
    put_be16(out, tag);
    put_be16(out, length);
}

}  // namespace

std::string upper_pdu(std::string_view dissector, std::string_view payload) {
    std::string name(dissector);
    while (name.size() % 4 != 0) name += '\0';
    std::string out;
    put_tag(out, kDissectorName, name.size());
    out += name;
    put_tag(out, kEnd, 0);
    out += payload;
    return out;
}

std::optional<UpperPdu> decode_upper_pdu(Bytes packet) {
    UpperPdu result;
    while (packet.size() >= kTag) {
        const auto tag = be16_at(packet, 0);
        const std::size_t length = be16_at(packet, 2);
        packet = packet.subspan(kTag);
        if (length > packet.size()) return std::nullopt;
        if (tag == kEnd) {
            result.payload = packet.subspan(length);
            return result.dissector.empty() ? std::nullopt : std::optional(result);
        }
        if (tag == kDissectorName) {
            const std::string_view name(reinterpret_cast<const char*>(packet.data()), length);
            result.dissector = name.substr(0, name.find('\0'));
        }
        packet = packet.subspan(length);
    }
    return std::nullopt;
}

}  // namespace takt::capture
