#include "read_back.hpp"

#include <algorithm>

#include "transfer.hpp"

namespace takt::poll {
namespace {

using wire::Function;

wire::ReadRequest reading(bool bits, std::uint16_t start, std::uint16_t quantity) {
    return {bits ? Function::read_coils : Function::read_holding_registers, DataAddress{start}, quantity};
}

/// What was written, as if it had been read.
struct AsRead {
    DataAddress start{0};
    wire::Response response;
};

AsRead registers(DataAddress start, const wire::Registers& values) {
    return {start, wire::ReadRegistersResponse{Function::read_holding_registers, values}};
}

AsRead bits(DataAddress start, const wire::Bits& values) {
    return {start, wire::ReadBitsResponse{Function::read_coils, values}};
}

std::optional<AsRead> as_read(const wire::Request& write) {
    if (const auto* coil = std::get_if<wire::WriteSingleCoilRequest>(&write)) {
        wire::Bits one;
        one.push_back(coil->on);
        return bits(coil->address, one);
    }
    if (const auto* coils = std::get_if<wire::WriteMultipleCoilsRequest>(&write))
        return bits(coils->start, coils->values);
    if (const auto* single = std::get_if<wire::WriteSingleRegisterRequest>(&write))
        return registers(single->address, {single->value});
    if (const auto* many = std::get_if<wire::WriteMultipleRegistersRequest>(&write))
        return registers(many->start, many->values);
    if (const auto* mask = std::get_if<wire::MaskWriteRegisterRequest>(&write))
        return registers(mask->address, {static_cast<std::uint16_t>(mask->or_mask & ~mask->and_mask)});
    if (const auto* both = std::get_if<wire::ReadWriteMultipleRegistersRequest>(&write))
        return registers(both->write_start, both->values);
    return std::nullopt;
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

std::optional<value::Value> value_written(const wire::Pdu& write, const model::Variable& variable) {
    const auto request = wire::decode_request(write.span());
    const auto read = request ? as_read(*request) : std::nullopt;
    if (!read || variable.start() < read->start.value) return std::nullopt;
    auto value = value_in(read->response, read->start, variable);
    if (!value) return std::nullopt;
    return std::move(*value);
}

}  // namespace takt::poll
