// Protocol data units: a typed request and response for every function (docs/specification.md, section 8;
// MODBUS Application Protocol V1.1b3, section 6).
#pragma once

#include <cstdint>
#include <variant>

#include "takt/base/engine.hpp"
#include "takt/base/inplace_vector.hpp"
#include "takt/base/numbers.hpp"
#include "takt/base/result.hpp"
#include "takt/wire/function.hpp"

namespace takt::wire {

inline constexpr std::size_t kMaxPdu = 253;

/// An encoded PDU: function code and data, 1..253 bytes.
using Pdu = InplaceVector<std::uint8_t, kMaxPdu>;

/// The big-endian number at `index` of a PDU or of an MBAP header. @param index  index + 1 < bytes.size()
constexpr std::uint16_t word_at(Bytes bytes, std::size_t index) {
    return static_cast<std::uint16_t>(bytes[index] << 8 | bytes[index + 1]);
}

/// Register contents in the order of their addresses.
using Registers = InplaceVector<std::uint16_t, 125>;

/// Bits in the order of their addresses, at most 2000.
class Bits {
public:
    static constexpr std::size_t kCapacity = 2000;

    Bits() = default;
    /// `count` bits, all off; count <= kCapacity.
    explicit Bits(std::size_t count);

    [[nodiscard]] bool operator[](std::size_t index) const;
    void set(std::size_t index, bool on);
    void push_back(bool on);

    [[nodiscard]] std::size_t size() const { return size_; }
    [[nodiscard]] std::size_t byte_count() const { return (size_ + 7) / 8; }
    /// The bits as on the wire: the first in the lowest bit of the first byte, unused ones 0. byte_count()
    /// bytes.
    [[nodiscard]] Bytes bytes() const { return {bytes_.data(), byte_count()}; }
    /// `count` bits from their bytes on the wire; surplus bits are ignored. bytes.size() >= ceil(count / 8).
    static Bits from_bytes(Bytes bytes, std::size_t count);

    friend bool operator==(const Bits& a, const Bits& b);

private:
    std::array<std::uint8_t, kCapacity / 8> bytes_{};
    std::size_t size_ = 0;
};

// ---- requests. `function` is a constant where the type has one function only.

/// 0x01..0x04.
struct ReadRequest {
    Function function = Function::read_holding_registers;
    DataAddress start;
    std::uint16_t quantity = 1;  ///< bits 1..2000, registers 1..125
    friend bool operator==(const ReadRequest&, const ReadRequest&) = default;
};
/// 0x05.
struct WriteSingleCoilRequest {
    static constexpr Function function = Function::write_single_coil;
    DataAddress address;
    bool on = false;
    friend bool operator==(const WriteSingleCoilRequest&, const WriteSingleCoilRequest&) = default;
};
/// 0x06.
struct WriteSingleRegisterRequest {
    static constexpr Function function = Function::write_single_register;
    DataAddress address;
    std::uint16_t value = 0;
    friend bool operator==(const WriteSingleRegisterRequest&, const WriteSingleRegisterRequest&) = default;
};
/// 0x07.
struct ReadExceptionStatusRequest {
    static constexpr Function function = Function::read_exception_status;
    friend bool operator==(const ReadExceptionStatusRequest&, const ReadExceptionStatusRequest&) = default;
};
/// 0x08. Sub-functions 0..18 and 20; data kept as bytes: 2, for sub-function 0 any even number up to 250.
struct DiagnosticsRequest {
    static constexpr Function function = Function::diagnostics;
    std::uint16_t sub_function = 0;
    InplaceVector<std::uint8_t, 250> data;
    friend bool operator==(const DiagnosticsRequest&, const DiagnosticsRequest&) = default;
};
/// 0x0B.
struct GetCommEventCounterRequest {
    static constexpr Function function = Function::get_comm_event_counter;
    friend bool operator==(const GetCommEventCounterRequest&, const GetCommEventCounterRequest&) = default;
};
/// 0x0C.
struct GetCommEventLogRequest {
    static constexpr Function function = Function::get_comm_event_log;
    friend bool operator==(const GetCommEventLogRequest&, const GetCommEventLogRequest&) = default;
};
/// 0x0F, 1..1968 bits.
struct WriteMultipleCoilsRequest {
    static constexpr Function function = Function::write_multiple_coils;
    DataAddress start;
    Bits values;
    friend bool operator==(const WriteMultipleCoilsRequest&, const WriteMultipleCoilsRequest&) = default;
};
/// 0x10, 1..123 registers.
struct WriteMultipleRegistersRequest {
    static constexpr Function function = Function::write_multiple_registers;
    DataAddress start;
    Registers values;
    friend bool operator==(const WriteMultipleRegistersRequest&,
                           const WriteMultipleRegistersRequest&) = default;
};
/// 0x11.
struct ReportServerIdRequest {
    static constexpr Function function = Function::report_server_id;
    friend bool operator==(const ReportServerIdRequest&, const ReportServerIdRequest&) = default;
};
/// One range of registers in a file: file 1..65535, record 0..9999, length 1..124 registers. File and record
/// are addresses: encoding and decoding do not check them.
struct FileRange {
    std::uint16_t file = 1;
    std::uint16_t record = 0;
    std::uint16_t length = 1;
    friend bool operator==(const FileRange&, const FileRange&) = default;
};
/// 0x14, 1..35 ranges; the response must fit into a PDU.
struct ReadFileRecordRequest {
    static constexpr Function function = Function::read_file_record;
    InplaceVector<FileRange, 35> ranges;
    friend bool operator==(const ReadFileRecordRequest&, const ReadFileRecordRequest&) = default;
};
/// 0x15: `values` holds the registers of all ranges in their order.
struct WriteFileRecordRequest {
    static constexpr Function function = Function::write_file_record;
    InplaceVector<FileRange, 27> ranges;
    Registers values;
    friend bool operator==(const WriteFileRecordRequest&, const WriteFileRecordRequest&) = default;
};
/// 0x16: new = (old & and_mask) | (or_mask & ~and_mask).
struct MaskWriteRegisterRequest {
    static constexpr Function function = Function::mask_write_register;
    DataAddress address;
    std::uint16_t and_mask = 0xFFFF;
    std::uint16_t or_mask = 0;
    friend bool operator==(const MaskWriteRegisterRequest&, const MaskWriteRegisterRequest&) = default;
};
/// 0x17: writes 1..121 registers, then reads 1..125.
struct ReadWriteMultipleRegistersRequest {
    static constexpr Function function = Function::read_write_multiple_registers;
    DataAddress read_start;
    std::uint16_t read_quantity = 1;
    DataAddress write_start;
    Registers values;
    friend bool operator==(const ReadWriteMultipleRegistersRequest&,
                           const ReadWriteMultipleRegistersRequest&) = default;
};
/// 0x18.
struct ReadFifoQueueRequest {
    static constexpr Function function = Function::read_fifo_queue;
    DataAddress address;
    friend bool operator==(const ReadFifoQueueRequest&, const ReadFifoQueueRequest&) = default;
};
/// 0x2B / 14: code 1 basic, 2 regular, 3 extended, 4 one object.
struct ReadDeviceIdRequest {
    static constexpr Function function = Function::encapsulated_interface;
    std::uint8_t code = 1;
    std::uint8_t object = 0;
    friend bool operator==(const ReadDeviceIdRequest&, const ReadDeviceIdRequest&) = default;
};
/// 0x2B with any other MEI type, for example 13 (CANopen). The data is not interpreted.
struct EncapsulatedRequest {
    static constexpr Function function = Function::encapsulated_interface;
    std::uint8_t mei_type = 13;
    InplaceVector<std::uint8_t, 251> data;
    friend bool operator==(const EncapsulatedRequest&, const EncapsulatedRequest&) = default;
};

using Request = std::variant<ReadRequest, WriteSingleCoilRequest, WriteSingleRegisterRequest,
                             ReadExceptionStatusRequest, DiagnosticsRequest, GetCommEventCounterRequest,
                             GetCommEventLogRequest, WriteMultipleCoilsRequest, WriteMultipleRegistersRequest,
                             ReportServerIdRequest, ReadFileRecordRequest, WriteFileRecordRequest,
                             MaskWriteRegisterRequest, ReadWriteMultipleRegistersRequest,
                             ReadFifoQueueRequest, ReadDeviceIdRequest, EncapsulatedRequest>;

// ---- responses

/// 0x01, 0x02. Decoded without the request, the size is a multiple of 8.
struct ReadBitsResponse {
    Function function = Function::read_coils;
    Bits values;
    friend bool operator==(const ReadBitsResponse&, const ReadBitsResponse&) = default;
};
/// 0x03, 0x04, 0x17.
struct ReadRegistersResponse {
    Function function = Function::read_holding_registers;
    Registers values;
    friend bool operator==(const ReadRegistersResponse&, const ReadRegistersResponse&) = default;
};
/// 0x05: repeats the request.
using WriteSingleCoilResponse = WriteSingleCoilRequest;
/// 0x06: repeats the request.
using WriteSingleRegisterResponse = WriteSingleRegisterRequest;
/// 0x07.
struct ReadExceptionStatusResponse {
    static constexpr Function function = Function::read_exception_status;
    std::uint8_t status = 0;
    friend bool operator==(const ReadExceptionStatusResponse&, const ReadExceptionStatusResponse&) = default;
};
/// 0x08. A sub-function other than 0 may have no data: some slaves answer "force listen only" so.
using DiagnosticsResponse = DiagnosticsRequest;
/// 0x0B.
struct GetCommEventCounterResponse {
    static constexpr Function function = Function::get_comm_event_counter;
    std::uint16_t status = 0;  ///< 0xFFFF while a program command is still being processed
    std::uint16_t event_count = 0;
    friend bool operator==(const GetCommEventCounterResponse&, const GetCommEventCounterResponse&) = default;
};
/// 0x0C.
struct GetCommEventLogResponse {
    static constexpr Function function = Function::get_comm_event_log;
    std::uint16_t status = 0;
    std::uint16_t event_count = 0;
    std::uint16_t message_count = 0;
    InplaceVector<std::uint8_t, 64> events;
    friend bool operator==(const GetCommEventLogResponse&, const GetCommEventLogResponse&) = default;
};
/// 0x0F, 0x10.
struct WriteMultipleResponse {
    Function function = Function::write_multiple_registers;
    DataAddress start;
    std::uint16_t quantity = 0;
    friend bool operator==(const WriteMultipleResponse&, const WriteMultipleResponse&) = default;
};
/// 0x11: device specific bytes, usually the id and then the run indicator (0x00 off, 0xFF on).
struct ReportServerIdResponse {
    static constexpr Function function = Function::report_server_id;
    InplaceVector<std::uint8_t, 251> data;
    friend bool operator==(const ReportServerIdResponse&, const ReportServerIdResponse&) = default;
};
/// 0x14: `values` holds the registers of all ranges in their order; `lengths[i]` is the length of range i.
struct ReadFileRecordResponse {
    static constexpr Function function = Function::read_file_record;
    InplaceVector<std::uint16_t, 35> lengths;
    Registers values;
    friend bool operator==(const ReadFileRecordResponse&, const ReadFileRecordResponse&) = default;
};
/// 0x15: repeats the request.
using WriteFileRecordResponse = WriteFileRecordRequest;
/// 0x16: repeats the request.
using MaskWriteRegisterResponse = MaskWriteRegisterRequest;
/// 0x18: 0..31 registers.
struct ReadFifoQueueResponse {
    static constexpr Function function = Function::read_fifo_queue;
    InplaceVector<std::uint16_t, 31> values;
    friend bool operator==(const ReadFifoQueueResponse&, const ReadFifoQueueResponse&) = default;
};
/// One object of 0x2B / 14 as a part of its response's `text`.
struct DeviceIdObject {
    std::uint8_t id = 0;
    std::uint8_t length = 0;
    friend bool operator==(const DeviceIdObject&, const DeviceIdObject&) = default;
};
/// 0x2B / 14: `text` holds the contents of all objects in their order.
struct ReadDeviceIdResponse {
    static constexpr Function function = Function::encapsulated_interface;
    std::uint8_t code = 1;
    std::uint8_t conformity = 0x01;
    bool more_follows = false;
    std::uint8_t next_object = 0;
    InplaceVector<DeviceIdObject, 123> objects;
    InplaceVector<std::uint8_t, 246> text;
    friend bool operator==(const ReadDeviceIdResponse&, const ReadDeviceIdResponse&) = default;
};
/// 0x2B with any other MEI type.
using EncapsulatedResponse = EncapsulatedRequest;
/// function | 0x80, code. `function` is that of the request, without the top bit.
struct ExceptionResponse {
    Function function = Function::read_holding_registers;
    ExceptionCode code = ExceptionCode::illegal_function;
    friend bool operator==(const ExceptionResponse&, const ExceptionResponse&) = default;
};

using Response = std::variant<ExceptionResponse, ReadBitsResponse, ReadRegistersResponse,
                              WriteSingleCoilResponse, WriteSingleRegisterResponse,
                              ReadExceptionStatusResponse, DiagnosticsResponse, GetCommEventCounterResponse,
                              GetCommEventLogResponse, WriteMultipleResponse, ReportServerIdResponse,
                              ReadFileRecordResponse, WriteFileRecordResponse, MaskWriteRegisterResponse,
                              ReadFifoQueueResponse, ReadDeviceIdResponse, EncapsulatedResponse>;

// ---- encoding and decoding

/// The function code of a request.
Function function_of(const Request& request);

/// @returns out_of_range (value, least, greatest) for a quantity or length the function does not allow
Result<Pdu> encode(const Request& request);

/// Decodes a request as a slave does. Nothing is assumed of the bytes.
/// @returns unsupported (function) for an unknown function — answer exception 1;
///          out_of_range (value, least, greatest), too_short, too_long, malformed for a wrong quantity, byte
///          count, value or length — answer exception 3.
/// Addresses are not checked: start + quantity may exceed 65536.
Result<Request> decode_request(Bytes pdu);

/// Decodes a response to `request` into a value of its own. Masters use a view instead
/// (prepared_request.hpp).
/// @returns an ExceptionResponse for an exception of any code to the request's function;
///          unexpected_reply for another function or an echo that differs;
///          malformed, too_short, too_long for a byte count or a length that the request does not allow.
Result<Response> decode_response(const Request& request, Bytes pdu);

/// Decodes a response without its request (captures, logs). Quantities follow from the byte counts.
Result<Response> decode_response(Bytes pdu);

}  // namespace takt::wire
