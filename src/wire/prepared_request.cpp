// What is known of a request's response before it comes.
#include "takt/wire/prepared_request.hpp"

#include "codec.hpp"
#include "takt/wire/frame.hpp"

namespace takt::wire {
namespace {

constexpr bool kFixed = true;

constexpr std::size_t kWriteResponse = 5;  // function, address, value or quantity
constexpr std::size_t kMaskResponse = 7;   // function, address, both masks

/// One overload for each request.
struct Shape {
    RequestShape operator()(const ReadRequest& request) const {
        return items(request.function, request.start, request.quantity,
                     response_pdu_length(request.function, request.quantity));
    }
    RequestShape operator()(const ReadWriteMultipleRegistersRequest& request) const {
        return items(request.function, request.read_start, request.read_quantity,
                     response_pdu_length(request.function, request.read_quantity));
    }
    RequestShape operator()(const WriteSingleCoilRequest& request) const {
        return repeated(items(request.function, request.address, 1, kWriteResponse));
    }
    RequestShape operator()(const WriteSingleRegisterRequest& request) const {
        return repeated(items(request.function, request.address, 1, kWriteResponse));
    }
    RequestShape operator()(const WriteMultipleCoilsRequest& request) const {
        return items(request.function, request.start, request.values.size(), kWriteResponse);
    }
    RequestShape operator()(const WriteMultipleRegistersRequest& request) const {
        return items(request.function, request.start, request.values.size(), kWriteResponse);
    }
    RequestShape operator()(const MaskWriteRegisterRequest& request) const {
        return repeated(items(request.function, request.address, 1, kMaskResponse));
    }
    RequestShape operator()(const ReadExceptionStatusRequest& request) const {
        return plain(request.function, 2, kFixed);
    }
    RequestShape operator()(const DiagnosticsRequest& request) const {
        const RequestShape shape = plain(request.function, 3 + request.data.size());
        return is_repeated(request.sub_function) ? repeated(shape) : shape;
    }
    RequestShape operator()(const GetCommEventCounterRequest& request) const {
        return plain(request.function, 5, kFixed);
    }
    RequestShape operator()(const GetCommEventLogRequest& request) const {
        return plain(request.function, 8 + decltype(GetCommEventLogResponse::events)::capacity());
    }
    RequestShape operator()(const ReadFileRecordRequest& request) const {
        return plain(request.function, codec::file_response_length(request));
    }
    RequestShape operator()(const WriteFileRecordRequest& request) const {
        return repeated(plain(request.function,
                              2 + 7 * request.ranges.size() + 2 * request.values.size(), kFixed));
    }
    RequestShape operator()(const ReadFifoQueueRequest& request) const {
        return plain(request.function, 5 + 2 * decltype(ReadFifoQueueResponse::values)::capacity());
    }
    template <class OfAnyLength>
    RequestShape operator()(const OfAnyLength& request) const {
        return plain(request.function, kMaxPdu);
    }

    /// Sub-functions whose response repeats the data of the request: loopback, restart, delimiter and the two
    /// clears.
    static bool is_repeated(std::uint16_t sub_function) {
        return sub_function == 0 || sub_function == 1 || sub_function == 3 || sub_function == 10 ||
               sub_function == 20;
    }
    static RequestShape plain(Function function, std::size_t length, bool fixed = false) {
        return {.function = static_cast<std::uint8_t>(function),
                .decoded = true,
                .fixed_length = fixed,
                .response_length = static_cast<std::uint16_t>(length)};
    }
    static RequestShape items(Function function, DataAddress start, std::size_t quantity,
                              std::size_t length) {
        RequestShape shape = plain(function, length, kFixed);
        shape.start = start;
        shape.quantity = static_cast<std::uint16_t>(quantity);
        return shape;
    }
    static RequestShape repeated(RequestShape shape) {
        shape.repeated = true;
        return shape;
    }
};

}  // namespace

RequestShape shape_of(const Request& request) {
    return std::visit(Shape{}, request);
}

RequestShape shape_of(const ReadRequest& request) {
    return Shape{}(request);
}

std::size_t max_response_length(const Request& request) {
    return shape_of(request).response_length;
}

PreparedRequest::PreparedRequest(Bytes pdu) {
    pdu_.assign(pdu);
    if (pdu.empty()) return;
    shape_.function = pdu[0];
    if (const auto request = decode_request(pdu)) shape_ = shape_of(*request);
}

Result<PreparedRequest> prepare(const Request& request) {
    TAKT_TRY(const Pdu pdu, encode(request));
    return PreparedRequest(pdu, shape_of(request));
}

Result<PreparedRequest> prepare(const ReadRequest& request) {
    TAKT_TRY(const Pdu pdu, codec::encode(request));
    return PreparedRequest(pdu, shape_of(request));
}

}  // namespace takt::wire
