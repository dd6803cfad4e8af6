// Values to requests, and responses to values. The members of a group are adjacent and in the order of their
// addresses, so their registers or bits are appended one after the other.
#include "transfer.hpp"

#include "takt/base/assert.hpp"
#include "takt/value/project_slots.hpp"

namespace takt::poll {
namespace {

using wire::Function;

Result<wire::Bits> bits_of(std::span<const Member> members) {
    wire::Bits bits;
    for (const auto& [variable, value] : members) {
        if (!wire::is_bit_area(variable->area)) return fail(Code::unsupported, variable->name);
        TAKT_TRY(const value::Encoded encoded, value::encode(value::layout_of(*variable), *value));
        bits.push_back(encoded.registers[0] != 0);
    }
    return bits;
}

Result<wire::Registers> registers_of(std::span<const Member> members) {
    wire::Registers registers;
    for (const auto& [variable, value] : members) {
        if (variable->type == DataType::boolean) return fail(Code::unsupported, variable->name);
        TAKT_TRY(const value::Encoded encoded, value::encode(value::layout_of(*variable), *value));
        if (encoded.registers.size() > wire::Registers::capacity() - registers.size())
            return fail(Code::too_long, variable->name);
        registers.append(encoded.registers.span());
    }
    return registers;
}

}  // namespace

// A function 0x17 reads holding registers; where nothing is written, function 0x03 reads the same.
wire::ReadRequest read_request(const plan::Request& request) {
    TAKT_ASSERT(request.read);
    const Function function = *request.read == Function::read_write_multiple_registers
                                  ? Function::read_holding_registers
                                  : *request.read;
    return {function, DataAddress{request.start}, request.quantity};
}

Result<wire::Registers> registers_in(const wire::ResponseView& response, DataAddress start,
                                     std::uint16_t first, std::size_t count) {
    const wire::RegisterView read = response.registers();
    const auto offset = static_cast<std::size_t>(first - start.value);
    if (first < start.value || offset + count > read.size()) return fail(Code::too_short);
    wire::Registers registers;
    for (std::size_t i = 0; i < count; ++i) registers.push_back(read[offset + i]);
    return registers;
}

Result<value::Value> value_in(const wire::ResponseView& response, DataAddress start,
                              const model::Variable& variable) {
    if (const wire::BitView bits = response.bits(); !bits.empty()) {
        const auto offset = static_cast<std::size_t>(variable.start() - start.value);
        if (offset >= bits.size()) return fail(Code::too_short, static_cast<std::int64_t>(bits.size()));
        return value::Value(bits[offset]);
    }
    TAKT_TRY(const auto registers, registers_in(response, start, variable.start(), variable.items()));
    return value::decode(value::layout_of(variable), registers.span());
}

bool is_register_bit(const model::Variable& variable) {
    return variable.type == DataType::boolean && !wire::is_bit_area(variable.area);
}

Result<wire::Request> write_request(Function function, std::span<const Member> members) {
    TAKT_ASSERT(!members.empty());
    const DataAddress start{members.front().variable->start()};
    if (wire::counts_bits(function)) {
        TAKT_TRY(const wire::Bits bits, bits_of(members));
        if (function == Function::write_single_coil) return wire::WriteSingleCoilRequest{start, bits[0]};
        return wire::WriteMultipleCoilsRequest{start, bits};
    }
    TAKT_TRY(const wire::Registers registers, registers_of(members));
    if (function != Function::write_single_register)
        return wire::WriteMultipleRegistersRequest{start, registers};
    if (registers.size() != 1) return fail(Code::unsupported, members.front().variable->name);
    return wire::WriteSingleRegisterRequest{start, registers[0]};
}

Result<wire::Request> exchange_request(const plan::Request& request, std::span<const Member> members) {
    TAKT_TRY(const wire::Registers registers, registers_of(members));
    return wire::ReadWriteMultipleRegistersRequest{DataAddress{request.start}, request.quantity,
                                                   DataAddress{request.write_start}, registers};
}

Result<RegisterBits> register_bits(std::span<const Member> members) {
    RegisterBits result;
    for (const auto& [variable, value] : members) {
        TAKT_ASSERT(is_register_bit(*variable));
        const auto bit = static_cast<std::uint16_t>(1U << variable->bit.value_or(0));
        TAKT_TRY(const value::Encoded encoded, value::encode(value::layout_of(*variable), *value));
        result.mask |= bit;
        if (encoded.registers[0] != 0) result.bits |= bit;
    }
    return result;
}

// Result = (current AND and_mask) OR (or_mask AND NOT and_mask): MODBUS Application Protocol V1.1b3,
// section 6.16.
wire::Request mask_request(DataAddress address, const RegisterBits& bits) {
    return wire::MaskWriteRegisterRequest{address, static_cast<std::uint16_t>(~bits.mask), bits.bits};
}

wire::Request register_request(Function function, DataAddress address, std::uint16_t value) {
    if (function == Function::write_single_register) return wire::WriteSingleRegisterRequest{address, value};
    return wire::WriteMultipleRegistersRequest{address, {value}};
}

// The value that a read will return: encoding may round it, and limits it to the registers of the variable.
Result<Written> as_written(const model::Variable& variable, const value::Value& value) {
    const auto layout = value::layout_of(variable);
    TAKT_TRY(const value::Encoded encoded, value::encode(layout, value));
    TAKT_TRY(value::Value decoded, value::decode(layout, encoded.registers.span()));
    return Written{std::move(decoded), encoded.rounded};
}

}  // namespace takt::poll
