// The read that verifies a write.
#include "read_back.hpp"

#include <algorithm>

#include "transfer.hpp"

namespace takt::poll {
namespace {

using wire::Function;

// A range that one request can write, one request can read.
wire::PreparedRead reading(bool bits, std::uint16_t start, std::uint16_t quantity) {
    return prepared(
        {bits ? Function::read_coils : Function::read_holding_registers, DataAddress{start}, quantity});
}

}  // namespace

bool ReadBack::again(Instant t, const OutcomeClass& outcome_class, std::uint16_t attempts) {
    const bool transient =
        outcome_class.reason != value::Reason::link_lost && (!outcome_class.answered || outcome_class.busy);
    if (!transient || ++failures >= attempts) return false;
    if (outcome_class.busy) not_before = after(t, busy.next());
    return true;
}

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

}  // namespace takt::poll
