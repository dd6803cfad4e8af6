// Bus time of a transaction (docs/planning.md, "Bus time"):
//   RTU    max(t3.5, frame_gap) + request + max(turnaround, t3.5) + response
//   ASCII  frame_gap + request + turnaround + response
//   TCP    frame_gap + round_trip + 10 ns a byte
// each stretched to request_gap.
#include <algorithm>
#include <numeric>

#include "cost/exact_time.hpp"
#include "takt/plan/plan.hpp"
#include "takt/plan/request_job.hpp"
#include "takt/wire/silence.hpp"

namespace takt::plan {
namespace {

using namespace std::chrono_literals;

constexpr Duration kTcpByte = 10ns;
constexpr Duration kUnknownTurnaround = 5ms;
constexpr std::int64_t kUnitsPerHalfBit = 1'000'000'000;

std::int64_t units_per_ns(const model::Line& line) {
    const std::int64_t baud = line.is_serial() ? std::int64_t{line.format.baud} : 1;
    return 2 * std::max(baud, std::int64_t{1});
}

}  // namespace

FrameLengths frame_lengths(wire::Framing framing, wire::Function function, std::size_t quantity,
                           std::size_t written) {
    return {wire::frame_length(framing, wire::request_pdu_length(function, quantity, written)),
            wire::frame_length(framing, wire::response_pdu_length(function, quantity))};
}

Transactions read_transactions(wire::Framing framing, const Request& request) {
    if (!request.read) return {};
    return {frame_lengths(framing, *request.read, request.quantity, request.write_quantity)};
}

Transactions write_transactions(wire::Framing framing, const Request& request) {
    if (!request.write) return {};
    Transactions transactions;
    if (request.read_modify_write)
        transactions.push_back(frame_lengths(
            framing, read_before_write(request.start, request.quantity).function, request.quantity));
    transactions.push_back(frame_lengths(framing, *request.write, request.quantity, request.write_quantity));
    return transactions;
}

Transactions main_transactions(wire::Framing framing, const Request& request) {
    return request.read ? read_transactions(framing, request) : write_transactions(framing, request);
}

BusTimeModel::BusTimeModel(const model::Line& line) : line_(line), units_per_ns_(units_per_ns(line)) {}

ExactTime BusTimeModel::half_characters(std::size_t count) const {
    return line_.format.baud == 0 ? 0 : ExactTime{kUnitsPerHalfBit} * line_.format.bits() * count;
}

ExactTime BusTimeModel::silence() const {
    if (line_.framing != wire::Framing::rtu) return 0;
    const auto [half, fixed] = wire::silence_between_frames(line_.format);
    return of(fixed) + half_characters(half);
}

// A connection that is opened for a request costs one more way to the device and back. Each request of a line
// that closes its connections may be that request.
ExactTime BusTimeModel::connecting(Duration way_and_back) const {
    const auto& rules = line_.connection;
    if (rules.use == model::ConnectionUse::keep) return 0;
    return of(way_and_back) + of(rules.pause_after);
}

ExactTime BusTimeModel::occupied(const model::Device& device, std::size_t characters, Duration turnaround,
                                 std::int64_t in_flight) const {
    if (!line_.is_serial())
        return connecting(device.round_trip) + of(device.round_trip) +
               (of(line_.frame_gap) + of(kTcpByte) * characters) * in_flight;
    const ExactTime time = std::max(silence(), of(line_.frame_gap)) + std::max(of(turnaround), silence()) +
                           half_characters(2 * characters);
    return time * in_flight;
}

ExactTime BusTimeModel::transaction(const model::Device& device, std::size_t request_characters,
                                    std::size_t response_characters, Duration turnaround) const {
    const ExactTime time = occupied(device, request_characters + response_characters, turnaround, 1);
    return std::max(time, of(line_.request_gap));
}

std::array<ExactTime, 5> BusTimeModel::parts(const model::Device& device, std::size_t request_characters,
                                             std::size_t response_characters, Duration turnaround) const {
    std::array<ExactTime, 5> lengths{};
    if (line_.is_serial()) {
        lengths = {std::max(silence(), of(line_.frame_gap)), half_characters(2 * request_characters),
                   std::max(of(turnaround), silence()), half_characters(2 * response_characters)};
    } else {
        lengths = {connecting(device.round_trip) + of(line_.frame_gap), of(kTcpByte) * request_characters,
                   of(device.round_trip), of(kTcpByte) * response_characters};
    }
    std::partial_sum(lengths.begin(), lengths.end(), lengths.begin());
    lengths.back() = std::max(lengths.back(), of(line_.request_gap));
    return lengths;
}

ExactTime BusTimeModel::sum(const model::Device& device, const Transactions& transactions,
                            Duration turnaround) const {
    ExactTime time = 0;
    for (const auto& [request, response] : transactions)
        time += transaction(device, request, response, turnaround);
    return time;
}

Duration BusTimeModel::rounded_up(ExactTime time) const {
    const ExactTime whole = (time + units_per_ns_ - 1) / units_per_ns_;
    return Duration(static_cast<std::int64_t>(std::min(whole, ExactTime{Duration::max().count()})));
}

std::int64_t BusTimeModel::microseconds_up(ExactTime time) const {
    const ExactTime unit = ExactTime{units_per_ns_} * 1000;
    const ExactTime most = Duration::max().count() / 1000;
    return static_cast<std::int64_t>(std::min((time + unit - 1) / unit, most));
}

ExactTime BusTimeModel::characters(std::size_t count) const {
    return line_.is_serial() ? half_characters(2 * count) : of(kTcpByte) * count;
}

Duration bus_time(const model::Line& line, const model::Device& device, std::size_t request_characters,
                  std::size_t response_characters, Duration turnaround) {
    const BusTimeModel bus_times(line);
    return bus_times.rounded_up(
        bus_times.transaction(device, request_characters, response_characters, turnaround));
}

Duration estimated_turnaround(const model::Device& device) {
    if (device.turnaround) return *device.turnaround;
    return device.measured_turnaround() ? device.times.measured.p999 : kUnknownTurnaround;
}

}  // namespace takt::plan
