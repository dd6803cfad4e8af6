// Functions without items: 0x07, 0x08, 0x0B, 0x0C, 0x11 (MODBUS Application Protocol V1.1b3,
// sections 6.7..6.10, 6.13).
#include "codec.hpp"

namespace takt::wire::codec {
namespace {

constexpr std::size_t kEventLogHeader = 6;  // status, event count and message count, within the byte count

constexpr std::size_t kSubFunctionData = 2;    // of every other sub-function
constexpr std::size_t kSubFunctionDataAt = 3;  // behind function and sub-function

bool is_sub_function(std::uint16_t code) {
    return code <= 18 || code == 20;
}

Result<void> check_diagnostics(std::uint16_t sub_function, std::size_t size) {
    if (!is_sub_function(sub_function))
        return fail(Code::unsupported, static_cast<std::int64_t>(Function::diagnostics), sub_function);
    if (sub_function == kReturnQueryData) return check_count(size % 2, 0);
    if (size == kSubFunctionData) return {};
    return fail(size < kSubFunctionData ? Code::too_short : Code::too_long,
                static_cast<std::int64_t>(kSubFunctionDataAt + size), kSubFunctionDataAt + kSubFunctionData);
}

// A response may do without data, except for the loopback.
Result<void> check_diagnostics_response(std::uint16_t sub_function, std::size_t size) {
    return check_diagnostics(sub_function,
                             size == 0 && sub_function != kReturnQueryData ? kSubFunctionData : size);
}

Result<DiagnosticsRequest> decode_diagnostics(Reader& in) {
    DiagnosticsRequest message{.sub_function = in.u16(), .data = {}};
    TAKT_CHECK(in.check());
    message.data.append(in.take(in.left()));
    return message;
}

Result<Request> decode_diagnostics_request(Reader& in) {
    TAKT_TRY(const auto request, decode_diagnostics(in));
    TAKT_CHECK(check_diagnostics(request.sub_function, request.data.size()));
    return request;
}

Result<Response> decode_diagnostics_response(Reader& in) {
    TAKT_TRY(const auto response, decode_diagnostics(in));
    TAKT_CHECK(check_diagnostics_response(response.sub_function, response.data.size()));
    return response;
}

Result<Response> decode_event_log(Reader& in) {
    GetCommEventLogResponse response;
    const std::size_t byte_count = in.u8();
    TAKT_CHECK(in.check());
    TAKT_CHECK(check_range(byte_count, kEventLogHeader, kEventLogHeader + response.events.capacity()));
    response.status = in.u16();
    response.event_count = in.u16();
    response.message_count = in.u16();
    response.events.append(in.take(byte_count - kEventLogHeader));
    TAKT_CHECK(in.finish());
    return response;
}

Result<Response> decode_event_counter(Reader& in) {
    GetCommEventCounterResponse response;
    response.status = in.u16();
    response.event_count = in.u16();
    TAKT_CHECK(in.finish());
    return response;
}

Result<Response> decode_server_id(Reader& in) {
    ReportServerIdResponse response;
    const std::size_t byte_count = in.u8();
    TAKT_CHECK(check_range(byte_count, 0, response.data.capacity()));
    response.data.append(in.take(byte_count));
    TAKT_CHECK(in.finish());
    return response;
}

Result<Response> decode_exception_status(Reader& in) {
    const std::uint8_t status = in.u8();
    TAKT_CHECK(in.finish());
    return ReadExceptionStatusResponse{status};
}

template <class Empty>
Result<Empty> decode_empty(const Reader& in) {
    TAKT_CHECK(in.finish());
    return Empty{};
}

}  // namespace

Result<Pdu> encode(const ReadExceptionStatusRequest& /*request*/) {
    return Writer(Function::read_exception_status).pdu();
}
Result<Pdu> encode(const GetCommEventCounterRequest& /*request*/) {
    return Writer(Function::get_comm_event_counter).pdu();
}
Result<Pdu> encode(const GetCommEventLogRequest& /*request*/) {
    return Writer(Function::get_comm_event_log).pdu();
}
Result<Pdu> encode(const ReportServerIdRequest& /*request*/) {
    return Writer(Function::report_server_id).pdu();
}

Result<Pdu> encode(const DiagnosticsRequest& request) {
    TAKT_CHECK(check_diagnostics(request.sub_function, request.data.size()));
    return Writer(request.function).u16(request.sub_function).bytes(request.data.span()).pdu();
}

Result<Request> decode_status_request(Function function, Reader in) {
    switch (function) {
        case Function::read_exception_status: return decode_empty<ReadExceptionStatusRequest>(in);
        case Function::diagnostics: return decode_diagnostics_request(in);
        case Function::get_comm_event_counter: return decode_empty<GetCommEventCounterRequest>(in);
        case Function::get_comm_event_log: return decode_empty<GetCommEventLogRequest>(in);
        default: return decode_empty<ReportServerIdRequest>(in);
    }
}

Result<Response> decode_status_response(Function function, Reader in) {
    switch (function) {
        case Function::read_exception_status: return decode_exception_status(in);
        case Function::diagnostics: return decode_diagnostics_response(in);
        case Function::get_comm_event_counter: return decode_event_counter(in);
        case Function::get_comm_event_log: return decode_event_log(in);
        default: return decode_server_id(in);
    }
}

}  // namespace takt::wire::codec
