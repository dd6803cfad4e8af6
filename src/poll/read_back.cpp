// The read that verifies a write, and the value that it must return: what the request carried, not what was
// set, since a value may be rounded on its way into registers.
#include "read_back.hpp"

#include <algorithm>
#include <span>

#include "takt/value/project_slots.hpp"

namespace takt::poll {
namespace {

using wire::Function;

wire::ReadRequest reading(bool bits, std::uint16_t start, std::uint16_t quantity) {
    return {bits ? Function::read_coils : Function::read_holding_registers, DataAddress{start}, quantity};
}

/// Registers from `start` on, as a write has them.
struct Written {
    std::uint16_t start = 0;
    std::span<const std::uint16_t> registers;
};

std::optional<Written> written_registers(const wire::Request& write) {
    if (const auto* single = std::get_if<wire::WriteSingleRegisterRequest>(&write))
        return Written{single->address.value, {&single->value, 1}};
    if (const auto* many = std::get_if<wire::WriteMultipleRegistersRequest>(&write))
        return Written{many->start.value, many->values.span()};
    if (const auto* both = std::get_if<wire::ReadWriteMultipleRegistersRequest>(&write))
        return Written{both->write_start.value, both->values.span()};
    return std::nullopt;
}

std::optional<value::Value> decoded(const Written& written, const model::Variable& variable) {
    if (variable.start() < written.start) return std::nullopt;
    const auto offset = static_cast<std::size_t>(variable.start() - written.start);
    if (offset + variable.items() > written.registers.size()) return std::nullopt;
    auto value =
        value::decode(value::layout_of(variable), written.registers.subspan(offset, variable.items()));
    if (!value) return std::nullopt;
    return std::move(*value);
}

}  // namespace

ReadBack read_back_of(const model::Variable& variable) {
    return {.request = reading(wire::is_bit_area(variable.area), variable.start(), variable.items())};
}

std::optional<ReadBack> read_back_of(const model::Device& device, const plan::Request& request) {
    const auto verified = [&](std::size_t v) { return plan::is_verified(request, device.variables[v]); };
    if (!std::ranges::any_of(request.variables, verified)) return std::nullopt;
    const bool exchange = request.write == Function::read_write_multiple_registers;
    const bool bits = request.write && wire::counts_bits(*request.write);
    return ReadBack{.request = reading(bits, exchange ? request.write_start : request.start,
                                       exchange ? request.write_quantity : request.quantity)};
}

std::optional<value::Value> value_written(const wire::Request& write, const model::Variable& variable) {
    if (const auto* coil = std::get_if<wire::WriteSingleCoilRequest>(&write)) {
        if (variable.start() != coil->address.value) return std::nullopt;
        return value::Value(coil->on);
    }
    if (const auto* coils = std::get_if<wire::WriteMultipleCoilsRequest>(&write)) {
        const std::size_t offset = variable.start() - coils->start.value;
        if (variable.start() < coils->start.value || offset >= coils->values.size()) return std::nullopt;
        return value::Value(coils->values[offset]);
    }
    // The bits that the masks leave alone are not part of the value.
    if (const auto* mask = std::get_if<wire::MaskWriteRegisterRequest>(&write)) {
        const auto bits = static_cast<std::uint16_t>(mask->or_mask & ~mask->and_mask);
        return decoded({mask->address.value, {&bits, 1}}, variable);
    }
    const auto registers = written_registers(write);
    return registers ? decoded(*registers, variable) : std::nullopt;
}

}  // namespace takt::poll
