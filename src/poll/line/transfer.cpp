// Values to requests, and responses to values. The members of a group are adjacent and in the order of their
// addresses, so their registers or bits are appended one after the other.
#include "line/transfer.hpp"

#include <utility>

#include "takt/base/assert.hpp"
#include "takt/value/project_slots.hpp"

namespace takt::poll {

using wire::Function;

wire::PreparedRead prepared(const wire::ReadRequest& read) {
    const auto made = wire::prepare(read);
    TAKT_ASSERT(made);
    return *made;
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

// Encoding may round the value, and limits it to the registers of the variable.
Result<Written> as_written(const model::Variable& variable, const value::Value& value) {
    const auto layout = value::layout_of(variable);
    TAKT_TRY(const value::Encoded encoded, value::encode(layout, value));
    TAKT_TRY(value::Value decoded, value::decode(layout, encoded.registers.span()));
    return Written{std::move(decoded), encoded.registers, encoded.rounded};
}

Result<void> WrittenItems::add(const model::Variable& variable, const wire::Registers& words) {
    if (!first_) first_ = &variable;
    if (wire::counts_bits(function_)) {
        if (!wire::is_bit_area(variable.area)) return fail(Code::unsupported, variable.name);
        bits_.push_back(words[0] != 0);
        return {};
    }
    if (variable.type == DataType::boolean) return fail(Code::unsupported, variable.name);
    if (words.size() > wire::Registers::capacity() - registers_.size())
        return fail(Code::too_long, variable.name);
    registers_.append(words.span());
    return {};
}

Result<wire::Request> WrittenItems::request() const {
    TAKT_ASSERT(first_ != nullptr);
    auto request = wire::write_request(function_, DataAddress{first_->start()}, bits_, registers_);
    if (!request) return fail(Code::unsupported, first_->name);
    return request;
}

wire::Request WrittenItems::exchange(const plan::Request& request) const {
    return wire::ReadWriteMultipleRegistersRequest{DataAddress{request.start}, request.quantity,
                                                   DataAddress{request.write_start}, registers_};
}

void RegisterBits::add(const model::Variable& variable, const wire::Registers& words) {
    TAKT_ASSERT(is_register_bit(variable));
    const auto bit = value::register_mask(value::layout_of(variable));
    mask |= bit;
    bits = static_cast<std::uint16_t>((bits & ~bit) | words[0]);
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

}  // namespace takt::poll
