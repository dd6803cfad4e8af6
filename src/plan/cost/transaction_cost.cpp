// C and F with the proved turnaround (docs/guarantees.md, "Model"). All terms are exact; C, the time-out and
// F are rounded up to microseconds once each.
#include "cost/transaction_cost.hpp"

#include <algorithm>

#include "takt/plan/guarantee.hpp"
#include "takt/wire/attempt_times.hpp"
#include "takt/wire/broadcast.hpp"
#include "takt/wire/silence.hpp"

namespace takt::plan {
Duration answer_wait(const model::Project& project, const model::Line& line, const model::Device& device) {
    const Duration wait = device.wait(project.derive_timeouts && requests_in_flight(line) == 1);
    return line.is_serial() ? wire::response_wait(line.framing, line.format, wait) : wait;
}

RequestCosts TransactionCosts::of_read(const Request& request) const {
    return costs(request, read_transactions(line_.framing, request));
}

// Nothing goes between the read and the write of a read-modify-write, and one that fails begins anew.
RequestCosts TransactionCosts::of_write(const Request& request) const {
    auto all = costs(request, write_transactions(line_.framing, request));
    if (all.size() == 2)
        all = RequestCosts{
            TransactionCost{all[0].transaction + all[1].transaction, all[0].transaction + all[1].failure}};
    const model::Device& device = line_.devices[request.device];
    const bool verified = std::ranges::any_of(
        request.variables, [&](std::size_t v) { return is_verified(request, device.variables[v]); });
    if (verified) all.push_back(cost(device, read_back_lengths(request)));
    return all;
}

// Bits of a register are written with 0x16, or by a read and a write with nothing between them.
RequestCosts TransactionCosts::of_command(const model::Device& device,
                                          const model::Variable& variable) const {
    const auto lengths = [&](const wire::ReadRequest& read) {
        return frame_lengths(line_.framing, read.function, read.quantity);
    };
    const bool bit = variable.type == DataType::boolean && !wire::is_bit_area(variable.area);
    const wire::Function function =
        bit && device.fc22 ? wire::Function::mask_write_register : command_function(device, variable);
    RequestCosts all{cost(device, frame_lengths(line_.framing, function, variable.items()))};
    if (bit && !device.fc22) {
        const TransactionCost read = cost(device, lengths(read_before_write(variable.start(), 1)));
        all[0].transaction += read.transaction;
        all[0].failure += read.transaction;
    }
    if (variable.verify) all.push_back(cost(device, lengths(read_back_of(variable))));
    return all;
}

// A verified write is read back by a frame of its own. A more urgent frame may precede it.
FrameLengths TransactionCosts::read_back_lengths(const Request& request) const {
    const wire::ReadRequest read = read_back_of(request);
    return frame_lengths(line_.framing, read.function, read.quantity);
}

// To any unit; the longest request that can have the longest answer.
Microseconds TransactionCosts::of_relayed() const {
    const std::size_t frame = wire::frame_length(line_.framing, wire::kMaxPdu);
    const FrameLengths longest{frame, frame};
    model::Device unknown_device;
    unknown_device.response_timeout = line_.relayed->response_timeout;
    Microseconds most = cost(unknown_device, longest).failure;
    for (const auto& device : line_.devices) most = std::max(most, cost(device, longest).failure);
    if (!line_.relayed->broadcast) return most;
    unknown_device.address = kBroadcast;
    return std::max(most, cost(unknown_device, longest).failure);
}

RequestCosts TransactionCosts::costs(const Request& request, const Transactions& transactions) const {
    RequestCosts all;
    for (const FrameLengths& frames : transactions)
        all.push_back(cost(line_.devices[request.device], frames));
    return all;
}

TransactionCost TransactionCosts::cost(const model::Device& device, const FrameLengths& frames) const {
    const Duration turnaround =
        line_.is_broadcast(device)
            ? wire::kBroadcastTurnaround
            : device.expected_turnaround(requests_in_flight(line_)).value_or(device.response_timeout);
    const std::size_t answer = line_.is_broadcast(device) ? 0 : frames.response;
    const wire::AttemptTimes<ExactTime> attempt{
        .request = bus_times_.characters(frames.request),
        .wait = bus_times_.of(answer_wait(project_, line_, device)),
        .response = bus_times_.characters(answer),
        .margin = bus_times_.of(project_.timeout_margin),
        .silence = std::max(bus_times_.silence(), bus_times_.of(line_.frame_gap))};
    const ExactTime wait = std::max(bus_times_.of(turnaround), bus_times_.silence());
    const ExactTime overhead = bus_times_.of(project_.host.overhead) + bus_times_.connecting(turnaround);
    const ExactTime time = std::max(attempt.request + wait + attempt.response + attempt.silence + overhead,
                                    bus_times_.of(line_.request_gap));
    const std::chrono::microseconds time_out(bus_times_.microseconds_up(attempt.time_out()));
    const ExactTime failure = attempt.failure(bus_times_.of(time_out)) + overhead;
    const Microseconds transaction = bus_times_.microseconds_up(time);
    return {transaction, std::max(transaction, bus_times_.microseconds_up(failure))};
}

}  // namespace takt::plan
