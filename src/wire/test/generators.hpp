// Random requests of every function, and for each a random answer, for the property tests of this module.
#pragma once

#include <rapidcheck.h>

#include "bytes.hpp"
#include "encode_response.hpp"
#include "takt/wire/pdu.hpp"

namespace takt::wire {

/// At full size from the first case on: numbers of all magnitudes, not small ones first.
template <class T>
T any(const rc::Gen<T>& gen) {
    return *rc::gen::resize(rc::kNominalSize, gen);
}

inline std::uint16_t any_u16() {
    return any(rc::gen::arbitrary<std::uint16_t>());
}
inline std::uint8_t any_u8() {
    return any(rc::gen::arbitrary<std::uint8_t>());
}
inline bool any_bool() {
    return any(rc::gen::arbitrary<bool>());
}
/// least..greatest, both included, the ends more often than chance would have them.
inline std::size_t any_of(std::size_t least, std::size_t greatest) {
    return any(rc::gen::weightedOneOf<std::size_t>({{1, rc::gen::just(least)},
                                                    {1, rc::gen::just(greatest)},
                                                    {6, rc::gen::inRange(least, greatest + 1)}}));
}

template <std::size_t N>
InplaceVector<std::uint16_t, N> any_registers(std::size_t count) {
    InplaceVector<std::uint16_t, N> values;
    for (std::size_t i = 0; i < count; ++i) values.push_back(any_u16());
    return values;
}

template <std::size_t N>
InplaceVector<std::uint8_t, N> any_bytes(std::size_t count) {
    InplaceVector<std::uint8_t, N> bytes;
    for (std::size_t i = 0; i < count; ++i) bytes.push_back(any_u8());
    return bytes;
}

inline Bits any_bits(std::size_t count) {
    Bits bits;
    for (std::size_t i = 0; i < count; ++i) bits.push_back(any_bool());
    return bits;
}

inline FileRange any_range(std::size_t most) {
    return {any_u16(), any_u16(), static_cast<std::uint16_t>(any_of(1, most))};
}

inline std::uint16_t any_sub_function() {
    const auto code = static_cast<std::uint16_t>(any_of(0, 19));
    return code == 19 ? 20 : code;
}

inline ReadFileRecordRequest any_read_file() {
    ReadFileRecordRequest request;
    std::size_t left = 251;  // bytes of the response behind its byte count
    const std::size_t ranges = any_of(1, 35);
    for (std::size_t i = 0; i < ranges && left >= 4; ++i) {
        request.ranges.push_back(any_range(std::min<std::size_t>((left - 2) / 2, 20)));
        left -= 2U + 2U * request.ranges.back().length;
    }
    return request;
}

inline WriteFileRecordRequest any_write_file() {
    WriteFileRecordRequest request;
    std::size_t left = 251;
    const std::size_t ranges = any_of(1, 27);
    for (std::size_t i = 0; i < ranges && left >= 9; ++i) {
        const FileRange range = any_range((left - 7) / 2);
        request.ranges.push_back(range);
        for (std::size_t k = 0; k < range.length; ++k) request.values.push_back(any_u16());
        left -= 7U + 2U * range.length;
    }
    return request;
}

/// The functions, with 0x08 and 0x2B in two shapes each.
inline constexpr int kRequestKinds = 21;

inline Request any_request(int kind) {
    switch (kind) {
        case 0:
            return ReadRequest{
                Function::read_coils, {any_u16()}, static_cast<std::uint16_t>(any_of(1, 2000))};
        case 1:
            return ReadRequest{
                Function::read_discrete_inputs, {any_u16()}, static_cast<std::uint16_t>(any_of(1, 2000))};
        case 2:
            return ReadRequest{
                Function::read_holding_registers, {any_u16()}, static_cast<std::uint16_t>(any_of(1, 125))};
        case 3:
            return ReadRequest{
                Function::read_input_registers, {any_u16()}, static_cast<std::uint16_t>(any_of(1, 125))};
        case 4: return WriteSingleCoilRequest{{any_u16()}, any_bool()};
        case 5: return WriteSingleRegisterRequest{{any_u16()}, any_u16()};
        case 6: return ReadExceptionStatusRequest{};
        case 7: return DiagnosticsRequest{0, any_bytes<250>(2 * any_of(0, 125))};
        case 8: return DiagnosticsRequest{std::max<std::uint16_t>(1, any_sub_function()), any_bytes<250>(2)};
        case 9: return GetCommEventCounterRequest{};
        case 10: return GetCommEventLogRequest{};
        case 11: return WriteMultipleCoilsRequest{{any_u16()}, any_bits(any_of(1, 1968))};
        case 12: return WriteMultipleRegistersRequest{{any_u16()}, any_registers<125>(any_of(1, 123))};
        case 13: return ReportServerIdRequest{};
        case 14: return any_read_file();
        case 15: return any_write_file();
        case 16: return MaskWriteRegisterRequest{{any_u16()}, any_u16(), any_u16()};
        case 17:
            return ReadWriteMultipleRegistersRequest{{any_u16()},
                                                     static_cast<std::uint16_t>(any_of(1, 125)),
                                                     {any_u16()},
                                                     any_registers<125>(any_of(1, 121))};
        case 18: return ReadFifoQueueRequest{{any_u16()}};
        case 19: return ReadDeviceIdRequest{static_cast<std::uint8_t>(any_of(1, 4)), any_u8()};
        default: break;
    }
    const std::uint8_t mei_type = any_u8();
    return EncapsulatedRequest{mei_type == 14 ? std::uint8_t{13} : mei_type, any_bytes<251>(any_of(0, 251))};
}

inline Request any_request() {
    return any_request(any(rc::gen::inRange(0, kRequestKinds)));
}

inline ReadDeviceIdResponse any_device_id(std::uint8_t code) {
    ReadDeviceIdResponse response{.code = code, .conformity = any_u8(), .more_follows = any_bool()};
    response.next_object = any_u8();
    std::size_t left = 246;
    const std::size_t objects = any_of(0, 123);
    for (std::size_t i = 0; i < objects && left >= 2; ++i) {
        const std::size_t length = any_of(0, std::min<std::size_t>(left - 2, 40));
        response.objects.push_back({any_u8(), static_cast<std::uint8_t>(length)});
        for (std::size_t k = 0; k < length; ++k) response.text.push_back(any_u8());
        left -= 2 + length;
    }
    return response;
}

/// A normal answer that fits the request.
struct AnyAnswer {
    Response operator()(const ReadRequest& r) const {
        if (counts_bits(r.function)) return ReadBitsResponse{r.function, any_bits(r.quantity)};
        return ReadRegistersResponse{r.function, any_registers<125>(r.quantity)};
    }
    Response operator()(const WriteSingleCoilRequest& r) const {
        return WriteSingleCoilResponse{r.address, r.on};
    }
    Response operator()(const WriteSingleRegisterRequest& r) const {
        return WriteSingleRegisterResponse{r.address, r.value};
    }
    Response operator()(const ReadExceptionStatusRequest&) const {
        return ReadExceptionStatusResponse{any_u8()};
    }
    Response operator()(const DiagnosticsRequest& r) const {
        return DiagnosticsResponse{r.sub_function, r.data};
    }
    Response operator()(const GetCommEventCounterRequest&) const {
        return GetCommEventCounterResponse{any_u16(), any_u16()};
    }
    Response operator()(const GetCommEventLogRequest&) const {
        return GetCommEventLogResponse{any_u16(), any_u16(), any_u16(), any_bytes<64>(any_of(0, 64))};
    }
    Response operator()(const WriteMultipleCoilsRequest& r) const {
        return WriteMultipleResponse{r.function, r.start, static_cast<std::uint16_t>(r.values.size())};
    }
    Response operator()(const WriteMultipleRegistersRequest& r) const {
        return WriteMultipleResponse{r.function, r.start, static_cast<std::uint16_t>(r.values.size())};
    }
    Response operator()(const ReportServerIdRequest&) const {
        return ReportServerIdResponse{any_bytes<251>(any_of(0, 251))};
    }
    Response operator()(const ReadFileRecordRequest& r) const {
        ReadFileRecordResponse response;
        for (const FileRange& range : r.ranges) {
            response.lengths.push_back(range.length);
            for (std::size_t i = 0; i < range.length; ++i) response.values.push_back(any_u16());
        }
        return response;
    }
    Response operator()(const WriteFileRecordRequest& r) const {
        return WriteFileRecordResponse{r.ranges, r.values};
    }
    Response operator()(const MaskWriteRegisterRequest& r) const {
        return MaskWriteRegisterResponse{r.address, r.and_mask, r.or_mask};
    }
    Response operator()(const ReadWriteMultipleRegistersRequest& r) const {
        return ReadRegistersResponse{r.function, any_registers<125>(r.read_quantity)};
    }
    Response operator()(const ReadFifoQueueRequest&) const {
        return ReadFifoQueueResponse{any_registers<31>(any_of(0, 31))};
    }
    Response operator()(const ReadDeviceIdRequest& r) const { return any_device_id(r.code); }
    Response operator()(const EncapsulatedRequest& r) const {
        return EncapsulatedResponse{r.mei_type, any_bytes<251>(any_of(0, 251))};
    }
};

inline Response any_answer(const Request& request) {
    return std::visit(AnyAnswer{}, request);
}

/// The bytes of a PDU with some changed, and cut or with surplus.
inline ExactBytes damaged(const Pdu& pdu) {
    ByteVector bytes(pdu.begin(), pdu.end());
    const std::size_t changes = any_of(0, 3);
    for (std::size_t i = 0; i < changes; ++i) bytes[any_of(0, bytes.size() - 1)] = any_u8();
    if (any_of(0, 3) == 0) bytes.resize(any_of(0, bytes.size() + 2));
    return ExactBytes(bytes);
}

}  // namespace takt::wire
