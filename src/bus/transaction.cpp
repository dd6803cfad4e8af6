#include "takt/bus/transaction.hpp"

namespace takt::bus {
namespace {

using wire::Function;

bool length_is_fixed(Function function) {
    switch (function) {
        case Function::read_coils:
        case Function::read_discrete_inputs:
        case Function::read_holding_registers:
        case Function::read_input_registers:
        case Function::write_single_coil:
        case Function::write_single_register:
        case Function::read_exception_status:
        case Function::get_comm_event_counter:
        case Function::write_multiple_coils:
        case Function::write_multiple_registers:
        case Function::write_file_record:
        case Function::mask_write_register:
        case Function::read_write_multiple_registers: return true;
        default: return false;
    }
}

}  // namespace

std::string_view name(Status status) {
    switch (status) {
        case Status::ok: return "ok";
        case Status::exception: return "exception";
        case Status::timeout: return "timeout";
        case Status::bad_checksum: return "bad_checksum";
        case Status::unexpected_reply: return "unexpected_reply";
        case Status::link_lost: return "link_lost";
        case Status::line_busy: return "line_busy";
        case Status::cancelled: return "cancelled";
    }
    return "unknown";
}

AnswerShape answer_shape(Bytes request_pdu) {
    if (request_pdu.empty()) return {};
    AnswerShape shape{request_pdu[0], 0};
    const auto request = wire::decode_request(request_pdu);
    if (request && length_is_fixed(wire::function_of(*request)))
        shape.pdu_length = wire::max_response_length(*request);
    return shape;
}

}  // namespace takt::bus
