#include "requests.hpp"

#include "takt/wire/broadcast.hpp"

namespace takt::relay {
namespace {

using wire::ExceptionCode;
using wire::Function;

constexpr std::uint8_t kReadDeviceIdentification = 14;
constexpr std::uint8_t kExceptionBit = 0x80;
constexpr std::size_t kAnswerToSeveral = 5;  // function, start, quantity

}  // namespace

bool only_reads(Bytes request) {
    switch (Function{request[0]}) {
        case Function::read_coils:
        case Function::read_discrete_inputs:
        case Function::read_holding_registers:
        case Function::read_input_registers:
        case Function::read_exception_status:
        case Function::report_server_id:
        case Function::read_file_record:
        case Function::read_fifo_queue: return true;
        case Function::encapsulated_interface:
            return request.size() > 1 && request[1] == kReadDeviceIdentification;
        default: return false;
    }
}

std::optional<ExceptionCode> refusal(Bytes request, bool broadcast) {
    const Function function{request[0]};
    if (request[0] == 0 || (request[0] & kExceptionBit) != 0) return ExceptionCode::illegal_function;
    if (broadcast && !wire::may_be_broadcast(function)) return ExceptionCode::illegal_function;
    const bool other_interface =
        function == Function::encapsulated_interface && !only_reads(request) && request.size() > 1;
    if (wire::is_known(function) && !other_interface && !wire::decode_request(request))
        return ExceptionCode::illegal_data_value;
    return std::nullopt;
}

wire::Pdu answer_to_broadcast(Bytes request) {
    const Function function{request[0]};
    const bool several =
        function == Function::write_multiple_coils || function == Function::write_multiple_registers;
    wire::Pdu answer;
    answer.assign(several ? request.first(kAnswerToSeveral) : request);
    return answer;
}

}  // namespace takt::relay
