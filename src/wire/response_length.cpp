// How long the answer to a request can be.
#include "codec.hpp"
#include "takt/wire/frame.hpp"

namespace takt::wire {
namespace {

struct LongestResponse {
    std::size_t operator()(const ReadRequest& request) const {
        return response_pdu_length(request.function, request.quantity);
    }
    std::size_t operator()(const ReadWriteMultipleRegistersRequest& request) const {
        return response_pdu_length(Function::read_write_multiple_registers, request.read_quantity);
    }
    std::size_t operator()(const WriteSingleCoilRequest& /*request*/) const { return 5; }
    std::size_t operator()(const WriteSingleRegisterRequest& /*request*/) const { return 5; }
    std::size_t operator()(const WriteMultipleCoilsRequest& /*request*/) const { return 5; }
    std::size_t operator()(const WriteMultipleRegistersRequest& /*request*/) const { return 5; }
    std::size_t operator()(const MaskWriteRegisterRequest& /*request*/) const { return 7; }
    std::size_t operator()(const ReadExceptionStatusRequest& /*request*/) const { return 2; }
    std::size_t operator()(const DiagnosticsRequest& request) const { return 3 + request.data.size(); }
    std::size_t operator()(const GetCommEventCounterRequest& /*request*/) const { return 5; }
    std::size_t operator()(const GetCommEventLogRequest& /*request*/) const {
        return 8 + decltype(GetCommEventLogResponse::events)::capacity();
    }
    std::size_t operator()(const ReadFileRecordRequest& request) const {
        return codec::file_response_length(request);
    }
    std::size_t operator()(const WriteFileRecordRequest& request) const {
        return 2 + 7 * request.ranges.size() + 2 * request.values.size();
    }
    std::size_t operator()(const ReadFifoQueueRequest& /*request*/) const {
        return 5 + 2 * decltype(ReadFifoQueueResponse::values)::capacity();
    }
    std::size_t operator()(const ReportServerIdRequest& /*request*/) const { return kMaxPdu; }
    std::size_t operator()(const ReadDeviceIdRequest& /*request*/) const { return kMaxPdu; }
    std::size_t operator()(const EncapsulatedRequest& /*request*/) const { return kMaxPdu; }
};

}  // namespace

std::size_t max_response_length(const Request& request) {
    return std::visit(LongestResponse{}, request);
}

}  // namespace takt::wire
