#include "exchanges/pdu_shape.hpp"

#include "files/big_endian.hpp"
#include "serial/serial_frame.hpp"
#include "takt/wire/request_view.hpp"

namespace takt::capture {
namespace {

bool has_byte_count(Bytes pdu) {
    return pdu.size() >= 2 && pdu[1] == pdu.size() - 2;
}

}  // namespace

bool could_be_request(Bytes pdu) {
    return wire::RequestView(pdu).well_formed();
}

bool could_be_response(Bytes pdu) {
    const auto function = wire::Function{wire::requested_function(pdu[0])};
    if (!wire::is_known(function)) return false;
    if (wire::is_exception(pdu[0])) return pdu.size() == 2;
    const auto& row = wire::properties(function);
    if (pdu.size() < row.response_bytes || pdu.size() > row.most_response_bytes) return false;
    switch (row.response) {
        case wire::ResponseForm::items:
        case wire::ResponseForm::event_log:
        case wire::ResponseForm::server_id:
        case wire::ResponseForm::records: return has_byte_count(pdu);
        case wire::ResponseForm::repeated: return could_be_request(pdu);
        case wire::ResponseForm::head:
        case wire::ResponseForm::status: return pdu.size() == row.response_bytes;
        case wire::ResponseForm::queue: return be16_at(pdu, 1) + std::size_t{3} == pdu.size();
        case wire::ResponseForm::sub_function:
        case wire::ResponseForm::encapsulated: return true;
        case wire::ResponseForm::unknown: break;
    }
    return false;
}

std::optional<wire::Framing> serial_framing_of(Bytes bytes) {
    if (bytes.empty()) return std::nullopt;
    const auto framing = bytes[0] == ':' ? wire::Framing::ascii : wire::Framing::rtu;
    const auto frame = framing == wire::Framing::ascii ? decode_ascii(bytes) : decode_rtu(bytes);
    if (frame.size() < 2) return std::nullopt;
    const auto pdu = frame.span().subspan(1);
    return could_be_request(pdu) || could_be_response(pdu) ? std::optional(framing) : std::nullopt;
}

}  // namespace takt::capture
