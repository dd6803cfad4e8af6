// Reading and writing coils and registers: 0x01..0x06, 0x0F, 0x10, 0x16, 0x17
// (MODBUS Application Protocol V1.1b3, sections 6.1..6.6, 6.11, 6.12, 6.16, 6.17).
#include "codec.hpp"

namespace takt::wire::codec {
namespace {

Result<void> check_function(Function function, bool allowed) {
    if (allowed) return {};
    return fail(Code::unsupported, static_cast<std::int64_t>(function));
}

Result<WriteSingleCoilRequest> decode_coil(Reader& in) {
    const DataAddress address{in.u16()};
    const std::uint16_t value = in.u16();
    TAKT_CHECK(in.finish());
    if (value != 0 && value != kCoilOn) return fail(Code::malformed, value);
    return WriteSingleCoilRequest{address, value == kCoilOn};
}

Result<WriteSingleRegisterRequest> decode_register(Reader& in) {
    const DataAddress address{in.u16()};
    const std::uint16_t value = in.u16();
    TAKT_CHECK(in.finish());
    return WriteSingleRegisterRequest{address, value};
}

Result<MaskWriteRegisterRequest> decode_mask(Reader& in) {
    const DataAddress address{in.u16()};
    const std::uint16_t and_mask = in.u16();
    const std::uint16_t or_mask = in.u16();
    TAKT_CHECK(in.finish());
    return MaskWriteRegisterRequest{address, and_mask, or_mask};
}

Result<Request> decode_read(Function function, Reader& in) {
    const DataAddress start{in.u16()};
    const std::uint16_t quantity = in.u16();
    TAKT_CHECK(in.finish());
    TAKT_CHECK(check_range(quantity, 1, properties(function).most_items));
    return ReadRequest{function, start, quantity};
}

Result<Request> decode_write_coils(Reader& in) {
    const DataAddress start{in.u16()};
    const std::size_t quantity = in.u16();
    const std::size_t byte_count = in.u8();
    TAKT_CHECK(in.check());
    TAKT_CHECK(check_range(quantity, 1, kMaxWriteBits));
    TAKT_CHECK(check_count(byte_count, (quantity + 7) / 8));
    const Bytes values = in.take(byte_count);
    TAKT_CHECK(in.finish());
    return WriteMultipleCoilsRequest{start, Bits::from_bytes(values, quantity)};
}

Result<Request> decode_write_registers(Reader& in) {
    WriteMultipleRegistersRequest request;
    request.start = {in.u16()};
    const std::size_t quantity = in.u16();
    const std::size_t byte_count = in.u8();
    TAKT_CHECK(in.check());
    TAKT_CHECK(check_range(quantity, 1, kMaxWriteRegisters));
    TAKT_CHECK(check_count(byte_count, 2 * quantity));
    in.registers(request.values, quantity);
    TAKT_CHECK(in.finish());
    return request;
}

Result<Request> decode_read_write(Reader& in) {
    ReadWriteMultipleRegistersRequest request;
    request.read_start = {in.u16()};
    request.read_quantity = in.u16();
    request.write_start = {in.u16()};
    const std::size_t written = in.u16();
    const std::size_t byte_count = in.u8();
    TAKT_CHECK(in.check());
    TAKT_CHECK(check_range(request.read_quantity, 1, kMaxReadRegisters));
    TAKT_CHECK(check_range(written, 1, kMaxReadWriteRegisters));
    TAKT_CHECK(check_count(byte_count, 2 * written));
    in.registers(request.values, written);
    TAKT_CHECK(in.finish());
    return request;
}

Result<Response> decode_bits(Function function, Reader& in) {
    const std::size_t byte_count = in.u8();
    TAKT_CHECK(in.check());
    TAKT_CHECK(check_range(byte_count, 1, Bits::kCapacity / 8));
    const Bytes values = in.take(byte_count);
    TAKT_CHECK(in.finish());
    return ReadBitsResponse{function, Bits::from_bytes(values, 8 * byte_count)};
}

Result<Response> decode_registers(Function function, Reader& in) {
    const std::size_t byte_count = in.u8();
    TAKT_CHECK(in.check());
    TAKT_CHECK(check_range(byte_count, 2, 2 * kMaxReadRegisters));
    TAKT_CHECK(check_count(byte_count, byte_count / 2 * 2));
    ReadRegistersResponse response{.function = function, .values = {}};
    in.registers(response.values, byte_count / 2);
    TAKT_CHECK(in.finish());
    return response;
}

Result<Response> decode_written(Function function, Reader& in) {
    const DataAddress start{in.u16()};
    const std::uint16_t quantity = in.u16();
    TAKT_CHECK(in.finish());
    TAKT_CHECK(check_range(quantity, 1, properties(function).most_items));
    return WriteMultipleResponse{function, start, quantity};
}

}  // namespace

Result<Pdu> encode(const ReadRequest& request) {
    TAKT_CHECK(check_function(request.function, properties(request.function).only_reads_items()));
    TAKT_CHECK(check_range(request.quantity, 1, properties(request.function).most_items));
    return Writer(request.function).u16(request.start.value).u16(request.quantity).pdu();
}

Result<Pdu> encode(const WriteSingleCoilRequest& request) {
    return Writer(request.function).u16(request.address.value).u16(request.on ? kCoilOn : 0).pdu();
}

Result<Pdu> encode(const WriteSingleRegisterRequest& request) {
    return Writer(request.function).u16(request.address.value).u16(request.value).pdu();
}

Result<Pdu> encode(const MaskWriteRegisterRequest& request) {
    Writer out(request.function);
    return out.u16(request.address.value).u16(request.and_mask).u16(request.or_mask).pdu();
}
Result<Pdu> encode(const WriteMultipleCoilsRequest& request) {
    TAKT_CHECK(check_range(request.values.size(), 1, kMaxWriteBits));
    Writer out(Function::write_multiple_coils);
    out.u16(request.start.value).u16(request.values.size());
    return out.u8(request.values.byte_count()).bytes(request.values.bytes()).pdu();
}

Result<Pdu> encode(const WriteMultipleRegistersRequest& request) {
    TAKT_CHECK(check_range(request.values.size(), 1, kMaxWriteRegisters));
    Writer out(Function::write_multiple_registers);
    out.u16(request.start.value).u16(request.values.size());
    return out.u8(2 * request.values.size()).registers(request.values.span()).pdu();
}

Result<Pdu> encode(const ReadWriteMultipleRegistersRequest& request) {
    TAKT_CHECK(check_range(request.read_quantity, 1, kMaxReadRegisters));
    TAKT_CHECK(check_range(request.values.size(), 1, kMaxReadWriteRegisters));
    Writer out(Function::read_write_multiple_registers);
    out.u16(request.read_start.value).u16(request.read_quantity);
    out.u16(request.write_start.value).u16(request.values.size());
    return out.u8(2 * request.values.size()).registers(request.values.span()).pdu();
}

Result<Request> decode_data_request(Function function, Reader in) {
    const auto& row = properties(function);
    switch (row.request) {
        case RequestForm::single:
            if (row.counts_bits()) return decode_coil(in);
            return decode_register(in);
        case RequestForm::values:
            return row.counts_bits() ? decode_write_coils(in) : decode_write_registers(in);
        case RequestForm::masks: return decode_mask(in);
        case RequestForm::exchange: return decode_read_write(in);
        default: return decode_read(function, in);
    }
}

Result<Response> decode_data_response(Function function, Reader in) {
    const auto& row = properties(function);
    switch (row.request) {
        case RequestForm::single:
            if (row.counts_bits()) return decode_coil(in);
            return decode_register(in);
        case RequestForm::values: return decode_written(function, in);
        case RequestForm::masks: return decode_mask(in);
        default: return row.counts_bits() ? decode_bits(function, in) : decode_registers(function, in);
    }
}

}  // namespace takt::wire::codec
