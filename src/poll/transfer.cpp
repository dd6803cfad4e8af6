#include "transfer.hpp"

#include "takt/base/assert.hpp"
#include "takt/poll/project_slots.hpp"

namespace takt::poll {
namespace {

using wire::Function;

Result<wire::Bits> bits_of(std::span<const Member> members) {
    wire::Bits bits;
    for (const auto& [variable, value] : members) {
        if (!wire::is_bit_area(variable->area)) return fail(Code::unsupported, variable->name);
        TAKT_TRY(const value::Encoded encoded, value::encode(layout_of(*variable), *value));
        bits.push_back(encoded.registers[0] != 0);
    }
    return bits;
}

Result<wire::Registers> registers_of(std::span<const Member> members) {
    wire::Registers registers;
    for (const auto& [variable, value] : members) {
        if (variable->type == DataType::boolean) return fail(Code::unsupported, variable->name);
        TAKT_TRY(const value::Encoded encoded, value::encode(layout_of(*variable), *value));
        if (encoded.registers.size() > wire::Registers::capacity() - registers.size())
            return fail(Code::too_long, variable->name);
        registers.append(encoded.registers.span());
    }
    return registers;
}

}  // namespace

wire::ReadRequest read_request(const plan::Request& request) {
    TAKT_ASSERT(request.read);
    return {*request.read, DataAddress{request.start}, request.quantity};
}

Result<value::Value> value_in(const wire::Response& response, const wire::ReadRequest& request,
                              const model::Variable& variable) {
    const auto offset = static_cast<std::size_t>(variable.start() - request.start.value);
    if (const auto* bits = std::get_if<wire::ReadBitsResponse>(&response)) {
        if (offset >= bits->values.size())
            return fail(Code::too_short, static_cast<std::int64_t>(bits->values.size()));
        return value::Value(bits->values[offset]);
    }
    const auto* registers = std::get_if<wire::ReadRegistersResponse>(&response);
    if (!registers || offset >= registers->values.size()) return fail(Code::too_short);
    return value::decode(layout_of(variable), registers->values.span().subspan(offset));
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

Result<Written> as_written(const model::Variable& variable, const value::Value& value) {
    const auto layout = layout_of(variable);
    TAKT_TRY(const value::Encoded encoded, value::encode(layout, value));
    TAKT_TRY(value::Value decoded, value::decode(layout, encoded.registers.span()));
    return Written{std::move(decoded), encoded.rounded};
}

}  // namespace takt::poll
