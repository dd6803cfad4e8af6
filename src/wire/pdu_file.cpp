// File records and queues: 0x14, 0x15, 0x18 (MODBUS Application Protocol V1.1b3, sections 6.14, 6.15, 6.18).
// Both file functions are a byte count and then sub-requests or sub-responses, each with the reference
// type 6.
#include "codec.hpp"
#include "item_limits.hpp"

namespace takt::wire::codec {
namespace {

Result<void> check_reference_type(std::uint8_t type) {
    return check_count(type, kFileReferenceType);
}

void put_range(Writer& out, const FileRange& range) {
    out.u8(kFileReferenceType).u16(range.file).u16(range.record).u16(range.length);
}

Result<FileRange> take_range(Reader& in) {
    const std::uint8_t type = in.u8();
    const FileRange range{in.u16(), in.u16(), in.u16()};
    TAKT_CHECK(in.check());
    TAKT_CHECK(check_reference_type(type));
    TAKT_CHECK(check_range(range.length, 1, kMaxFileRegisters));
    return range;
}

// The byte count and what it announces: exactly the rest of the PDU.
Result<void> take_byte_count(Reader& in, std::size_t least, std::size_t most = kMaxFileBytes) {
    const std::size_t byte_count = in.u8();
    TAKT_CHECK(in.check());
    TAKT_CHECK(check_range(byte_count, least, most));
    Reader rest = in;
    (void)rest.take(byte_count);
    return rest.finish();
}

// PDU bytes of the normal response.
std::size_t file_response_length(const ReadFileRecordRequest& request) {
    std::size_t length = 2;
    for (const FileRange& range : request.ranges) length += file_response_bytes(range.length);
    return length;
}

Result<Request> decode_read_file(Reader& in) {
    ReadFileRecordRequest request;
    TAKT_CHECK(take_byte_count(in, kFileRange, kMaxFileBytes / kFileRange * kFileRange));
    TAKT_CHECK(check_count(in.left() % kFileRange, 0));
    while (in.left() > 0) {
        TAKT_TRY(const FileRange range, take_range(in));
        request.ranges.push_back(range);
    }
    TAKT_CHECK(check_range(file_response_length(request), 2, kMaxPdu));
    return request;
}

Result<WriteFileRecordRequest> decode_write_file(Reader& in) {
    WriteFileRecordRequest message;
    TAKT_CHECK(take_byte_count(in, kFileRange + 2));
    while (in.left() > 0) {
        TAKT_TRY(const FileRange range, take_range(in));
        const std::size_t bytes = 2 * std::size_t{range.length};
        if (bytes > in.left())
            return fail(Code::malformed, static_cast<std::int64_t>(in.left()),
                        static_cast<std::int64_t>(bytes));
        message.ranges.push_back(range);
        in.registers(message.values, range.length);
    }
    return message;
}

Result<Response> decode_read_file_response(Reader& in) {
    ReadFileRecordResponse response;
    TAKT_CHECK(take_byte_count(in, file_response_bytes(1)));
    while (in.left() > 0) {
        const std::size_t length = in.u8();  // of reference type and registers
        const std::uint8_t type = in.u8();
        TAKT_CHECK(in.check());
        TAKT_CHECK(check_reference_type(type));
        if (length < 3 || length % 2 == 0 || length - 1 > in.left())
            return fail(Code::malformed, static_cast<std::int64_t>(length),
                        static_cast<std::int64_t>(in.left() + 1));
        if (!response.lengths.try_push_back(static_cast<std::uint16_t>((length - 1) / 2)))
            return fail(Code::malformed, static_cast<std::int64_t>(response.lengths.size() + 1));
        in.registers(response.values, (length - 1) / 2);
    }
    return response;
}

Result<Response> decode_fifo(Reader& in) {
    ReadFifoQueueResponse response;
    const std::size_t byte_count = in.u16();
    const std::size_t count = in.u16();
    TAKT_CHECK(in.check());
    TAKT_CHECK(check_range(count, 0, kMaxFifoRegisters));
    TAKT_CHECK(check_count(byte_count, 2 + 2 * count));
    in.registers(response.values, count);
    TAKT_CHECK(in.finish());
    return response;
}

}  // namespace

Result<Pdu> encode(const ReadFileRecordRequest& request) {
    TAKT_CHECK(check_range(request.ranges.size(), 1, request.ranges.capacity()));
    for (const FileRange& range : request.ranges) TAKT_CHECK(check_range(range.length, 1, kMaxFileRegisters));
    TAKT_CHECK(check_range(file_response_length(request), 2, kMaxPdu));
    Writer out(Function::read_file_record);
    out.u8(kFileRange * request.ranges.size());
    for (const FileRange& range : request.ranges) put_range(out, range);
    return out.pdu();
}

// The lengths of all ranges, none empty, must be what `values` holds.
Result<Pdu> encode(const WriteFileRecordRequest& message) {
    TAKT_CHECK(check_range(message.ranges.size(), 1, message.ranges.capacity()));
    std::size_t registers = 0;
    for (const FileRange& range : message.ranges) {
        TAKT_CHECK(check_range(range.length, 1, kMaxFileRegisters));
        registers += range.length;
    }
    TAKT_CHECK(check_count(message.values.size(), registers));
    const std::size_t byte_count = kFileRange * message.ranges.size() + 2 * registers;
    TAKT_CHECK(check_range(byte_count, 0, kMaxFileBytes));
    Writer out(Function::write_file_record);
    out.u8(byte_count);
    std::size_t first = 0;
    for (const FileRange& range : message.ranges) {
        put_range(out, range);
        out.registers(message.values.span().subspan(first, range.length));
        first += range.length;
    }
    return out.pdu();
}

Result<Pdu> encode(const ReadFifoQueueRequest& request) {
    return Writer(Function::read_fifo_queue).u16(request.address.value).pdu();
}

Result<Request> decode_file_request(Function function, Reader in) {
    switch (function) {
        case Function::read_file_record: return decode_read_file(in);
        case Function::write_file_record: return decode_write_file(in);
        default: {
            const DataAddress address{in.u16()};
            TAKT_CHECK(in.finish());
            return ReadFifoQueueRequest{address};
        }
    }
}

Result<Response> decode_file_response(Function function, Reader in) {
    switch (function) {
        case Function::read_file_record: return decode_read_file_response(in);
        case Function::write_file_record: return decode_write_file(in);
        default: return decode_fifo(in);
    }
}

}  // namespace takt::wire::codec
