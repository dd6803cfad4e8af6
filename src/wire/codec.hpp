// Shared by the codecs of all functions: a bounded big-endian reader, a writer, and the list of codecs. A
// codec reads or writes the bytes after the function code.
#pragma once

#include <span>

#include "takt/wire/pdu.hpp"

namespace takt::wire::codec {

/// Reads a PDU from the byte after its function code to its end. Beyond the end it returns zeros and empty
/// spans, and counts the bytes that were missing: a codec checks once, after it has read.
class Reader {
public:
    explicit Reader(Bytes pdu) : bytes_(pdu) {}

    std::uint8_t u8();
    std::uint16_t u16();
    Bytes take(std::size_t count);
    /// Appends `count` registers to `values`; they must fit.
    template <std::size_t N>
    void registers(InplaceVector<std::uint16_t, N>& values, std::size_t count) {
        for (std::size_t i = 0; i < count; ++i) values.push_back(u16());
    }

    /// Bytes that were not read yet.
    [[nodiscard]] std::size_t left() const { return needed_ < bytes_.size() ? bytes_.size() - needed_ : 0; }
    /// too_short when more was read than there is.
    [[nodiscard]] Result<void> check() const;
    /// too_short or too_long unless all bytes and no more were read.
    [[nodiscard]] Result<void> finish() const;

private:
    Bytes bytes_;
    std::size_t needed_ = 1;
};

/// Writes front to back; the caller has checked that it fits.
class Writer {
public:
    explicit Writer(Function function) { u8(static_cast<std::uint8_t>(function)); }

    Writer& u8(std::size_t value);
    Writer& u16(std::size_t value);
    Writer& bytes(Bytes values);
    Writer& registers(std::span<const std::uint16_t> values);

    [[nodiscard]] const Pdu& pdu() const { return pdu_; }

private:
    Pdu pdu_;
};

/// out_of_range with value and limits unless least <= value <= greatest.
Result<void> check_range(std::size_t value, std::size_t least, std::size_t greatest);
/// malformed with both unless equal: byte counts that must agree with something else.
Result<void> check_count(std::size_t count, std::size_t expected);

// Read and write of coils and registers: 0x01..0x06, 0x0F, 0x10, 0x16, 0x17.
Result<Pdu> encode(const ReadRequest& request);
Result<Pdu> encode(const WriteSingleCoilRequest& request);
Result<Pdu> encode(const WriteSingleRegisterRequest& request);
Result<Pdu> encode(const WriteMultipleCoilsRequest& request);
Result<Pdu> encode(const WriteMultipleRegistersRequest& request);
Result<Pdu> encode(const MaskWriteRegisterRequest& request);
Result<Pdu> encode(const ReadWriteMultipleRegistersRequest& request);
Result<Request> decode_data_request(Function function, Reader in);
Result<Response> decode_data_response(Function function, Reader in);

// Diagnostics and identification without items: 0x07, 0x08, 0x0B, 0x0C, 0x11.
Result<Pdu> encode(const ReadExceptionStatusRequest& request);
Result<Pdu> encode(const DiagnosticsRequest& request);
Result<Pdu> encode(const GetCommEventCounterRequest& request);
Result<Pdu> encode(const GetCommEventLogRequest& request);
Result<Pdu> encode(const ReportServerIdRequest& request);
Result<Request> decode_status_request(Function function, Reader in);
Result<Response> decode_status_response(Function function, Reader in);

// Files and queues: 0x14, 0x15, 0x18.
Result<Pdu> encode(const ReadFileRecordRequest& request);
Result<Pdu> encode(const WriteFileRecordRequest& request);
Result<Pdu> encode(const ReadFifoQueueRequest& request);
Result<Request> decode_file_request(Function function, Reader in);
Result<Response> decode_file_response(Function function, Reader in);

// The encapsulated interface: 0x2B.
Result<Pdu> encode(const ReadDeviceIdRequest& request);
Result<Pdu> encode(const EncapsulatedRequest& request);
Result<Request> decode_encapsulated_request(Reader in);
Result<Response> decode_encapsulated_response(Reader in);

}  // namespace takt::wire::codec
