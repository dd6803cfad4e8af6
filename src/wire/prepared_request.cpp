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
    shape.repeated = properties(function).response == ResponseForm::repeated;
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
    const auto& row = properties(function);
    return plain(function, row.most_response_bytes, row.response == ResponseForm::status);
}

std::size_t file_response_length_of(FileParts parts) {
    std::size_t length = 2;
    while (!parts.empty()) length += file_response_bytes(parts.take().length);
    return length;
}

/// Hands the request that write_request() describes to `use`, in its own type.
template <class Made, class Use>
Result<Made> with_write(Function function, DataAddress start, const Bits& bits, const Registers& registers,
                        Use use) {
    const auto& row = properties(function);
    const std::size_t items = row.counts_bits() ? bits.size() : registers.size();
    if (!row.writes_single() && row.request != RequestForm::values) return fail(Code::unsupported);
    if (items == 0 || (row.writes_single() && items != 1)) return fail(Code::unsupported);
    if (row.counts_bits()) {
        if (row.writes_single()) return use(WriteSingleCoilRequest{start, bits[0]});
        return use(WriteMultipleCoilsRequest{start, bits});
    }
    if (row.writes_single()) return use(WriteSingleRegisterRequest{start, registers[0]});
    return use(WriteMultipleRegistersRequest{start, registers});
}

}  // namespace

RequestShape shape_of(const ReadRequest& request) {
    return items(request.function, request.start, request.quantity);
}

RequestShape shape_of(const RequestView& request) {
    const Function function = request.function();
    if (!request.well_formed())
        return {.function = static_cast<std::uint8_t>(function), .effect = request.effect()};
    const auto& row = properties(function);
    switch (row.request) {
        case RequestForm::sub_function: return diagnostics(*request.sub_function(), request.data().size());
        case RequestForm::encapsulated: return encapsulated(*request.sub_function());
        case RequestForm::records:
            if (row.response == ResponseForm::repeated)
                return repeated(plain(function, request.pdu().size(), kFixed));
            return plain(function, file_response_length_of(request.file_parts()));
        default: break;
    }
    if (row.most_items == 0) return other(function);
    const ItemAccess& first = request.accesses().front();
    return items(function, DataAddress{first.start}, first.count);
}

Result<Request> write_request(Function function, DataAddress start, const Bits& bits,
                              const Registers& registers) {
    return with_write<Request>(function, start, bits, registers,
                               [](const auto& request) { return Result<Request>(request); });
}

PreparedRequest::PreparedRequest(const RequestView& request) {
    pdu_.assign(request.pdu());
    if (!request.empty()) shape_ = shape_of(request);
}

PreparedRequest::PreparedRequest(Bytes pdu) : PreparedRequest(RequestView(pdu)) {}

Result<PreparedRequest> prepare(const Request& request) {
    TAKT_TRY(const Pdu pdu, encode(request));
    return PreparedRequest(pdu);
}

Result<PreparedRequest> prepare_write(Function function, DataAddress start, const Bits& bits,
                                      const Registers& registers) {
    const std::size_t quantity = counts_bits(function) ? bits.size() : registers.size();
    return with_write<PreparedRequest>(function, start, bits, registers,
                                       [&](const auto& request) -> Result<PreparedRequest> {
                                           TAKT_TRY(const Pdu pdu, codec::encode(request));
                                           return PreparedRequest(pdu, items(function, start, quantity));
                                       });
}

Result<PreparedRequest> prepare(const MaskWriteRegisterRequest& request) {
    TAKT_TRY(const Pdu pdu, codec::encode(request));
    return PreparedRequest(pdu, items(request.function, request.address, 1));
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
