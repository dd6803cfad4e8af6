// The properties of a response that follow from its request.
#include "takt/wire/prepared_request.hpp"

#include <algorithm>

#include "codec.hpp"
#include "item_limits.hpp"
#include "takt/base/assert.hpp"
#include "takt/wire/frame.hpp"

namespace takt::wire {
namespace {

constexpr bool kFixed = true;

RequestShape plain(Function function, std::size_t length, bool fixed = false) {
    return {.function = static_cast<std::uint8_t>(function),
            .decoded = true,
            .fixed_length = fixed,
            .effect = properties(function).effect,
            .response_length = static_cast<std::uint16_t>(length)};
}

RequestShape repeated(RequestShape shape) {
    shape.repeated = true;
    return shape;
}

// 0x01..0x06, 0x0F, 0x10, 0x16; what 0x17 reads.
RequestShape items(Function function, DataAddress start, std::size_t quantity) {
    RequestShape shape = plain(function, response_pdu_length(function, quantity), kFixed);
    shape.start = start;
    shape.quantity = static_cast<std::uint16_t>(quantity);
    shape.repeated = function == Function::write_single_coil || function == Function::write_single_register ||
                     function == Function::mask_write_register;
    return shape;
}

// Sub-functions whose response repeats the data of the request: loopback, restart, delimiter and the two
// clears.
bool is_repeated(std::uint16_t sub_function) {
    return sub_function == 0 || sub_function == 1 || sub_function == 3 || sub_function == 10 ||
           sub_function == 20;
}

RequestShape diagnostics(std::uint16_t sub_function, std::size_t data) {
    RequestShape shape = plain(Function::diagnostics, 3 + data);
    shape.effect = effect(Function::diagnostics, sub_function);
    shape.repeated = is_repeated(sub_function);
    return shape;
}

RequestShape encapsulated(std::uint16_t mei_type) {
    RequestShape shape = plain(Function::encapsulated_interface, kMaxPdu);
    shape.effect = effect(Function::encapsulated_interface, mei_type);
    return shape;
}

// Any other function: the request has nothing that its response depends on.
RequestShape other(Function function) {
    switch (function) {
        case Function::read_exception_status: return plain(function, 2, kFixed);
        case Function::get_comm_event_counter: return plain(function, 5, kFixed);
        case Function::get_comm_event_log:
            return plain(function, 8 + decltype(GetCommEventLogResponse::events)::capacity());
        case Function::read_fifo_queue:
            return plain(function, 5 + 2 * decltype(ReadFifoQueueResponse::values)::capacity());
        default: return plain(function, kMaxPdu);
    }
}

/// One overload for each request.
struct Shape {
    RequestShape operator()(const ReadRequest& request) const {
        return items(request.function, request.start, request.quantity);
    }
    RequestShape operator()(const ReadWriteMultipleRegistersRequest& request) const {
        return items(request.function, request.read_start, request.read_quantity);
    }
    RequestShape operator()(const WriteSingleCoilRequest& request) const {
        return items(request.function, request.address, 1);
    }
    RequestShape operator()(const WriteSingleRegisterRequest& request) const {
        return items(request.function, request.address, 1);
    }
    RequestShape operator()(const WriteMultipleCoilsRequest& request) const {
        return items(request.function, request.start, request.values.size());
    }
    RequestShape operator()(const WriteMultipleRegistersRequest& request) const {
        return items(request.function, request.start, request.values.size());
    }
    RequestShape operator()(const MaskWriteRegisterRequest& request) const {
        return items(request.function, request.address, 1);
    }
    RequestShape operator()(const DiagnosticsRequest& request) const {
        return diagnostics(request.sub_function, request.data.size());
    }
    RequestShape operator()(const ReadFileRecordRequest& request) const {
        return plain(request.function, codec::file_response_length(request));
    }
    RequestShape operator()(const WriteFileRecordRequest& request) const {
        return repeated(plain(request.function,
                              2 + kFileRange * request.ranges.size() + 2 * request.values.size(), kFixed));
    }
    RequestShape operator()(const ReadDeviceIdRequest&) const { return encapsulated(kReadDeviceId); }
    RequestShape operator()(const EncapsulatedRequest& request) const {
        return encapsulated(request.mei_type);
    }
    template <class Other>
    RequestShape operator()(const Other& request) const {
        return other(request.function);
    }
};

std::size_t file_response_length(FileParts parts) {
    std::size_t length = 2;
    while (!parts.empty()) length += file_response_bytes(parts.take().length);
    return length;
}

}  // namespace

RequestShape shape_of(const Request& request) {
    return std::visit(Shape{}, request);
}

RequestShape shape_of(const ReadRequest& request) {
    return Shape{}(request);
}

RequestShape shape_of(const RequestView& request) {
    const Function function = request.function();
    if (!request.well_formed())
        return {.function = static_cast<std::uint8_t>(function), .effect = request.effect()};
    switch (function) {
        case Function::diagnostics: return diagnostics(*request.sub_function(), request.data().size());
        case Function::encapsulated_interface: return encapsulated(*request.sub_function());
        case Function::read_file_record: return plain(function, file_response_length(request.file_parts()));
        case Function::write_file_record: return repeated(plain(function, request.pdu().size(), kFixed));
        default: break;
    }
    if (most_items(function) == 0) return other(function);
    const ItemAccess& first = request.accesses().front();
    return items(function, DataAddress{first.start}, first.count);
}

std::size_t max_response_length(const Request& request) {
    return shape_of(request).response_length;
}

PreparedRequest::PreparedRequest(const RequestView& request) {
    pdu_.assign(request.pdu());
    if (!request.empty()) shape_ = shape_of(request);
}

PreparedRequest::PreparedRequest(Bytes pdu) : PreparedRequest(RequestView(pdu)) {}

Result<PreparedRequest> prepare(const Request& request) {
    TAKT_TRY(const Pdu pdu, encode(request));
    return PreparedRequest(pdu, shape_of(request));
}

Result<PreparedRead> prepare(const ReadRequest& request) {
    TAKT_TRY(const Pdu pdu, codec::encode(request));
    PreparedRead read;
    TAKT_ASSERT(pdu.size() == read.pdu_.size());
    std::ranges::copy(pdu, read.pdu_.begin());
    read.shape_ = shape_of(request);
    return read;
}

}  // namespace takt::wire
