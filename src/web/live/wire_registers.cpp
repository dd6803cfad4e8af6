#include "live/wire_registers.hpp"

#include <utility>

#include "takt/wire/request_view.hpp"

namespace takt::web {
namespace {

constexpr std::size_t kMostUnanswered = 4096;
constexpr std::size_t kMbapHead = 7;
constexpr std::size_t kDataAt = 2;  // of a response: function, byte count

std::uint16_t transaction_of(const TrafficFrame& frame) {
    const auto& raw = frame.record.raw;
    if (!frame.mbap || raw.size() < kMbapHead) return 0;
    return static_cast<std::uint16_t>(raw[0] << 8 | raw[1]);
}

std::size_t bytes_of(wire::Area area, std::size_t items) {
    return wire::is_bit_area(area) ? (items + 7) / 8 : 2 * items;
}

std::uint16_t item_of(const std::vector<std::uint8_t>& bytes, bool bit, std::size_t index) {
    if (bit) return static_cast<std::uint16_t>(bytes[index / 8] >> (index % 8) & 1);
    return static_cast<std::uint16_t>(bytes[2 * index] << 8 | bytes[2 * index + 1]);
}

}  // namespace

void WireRegisters::take(const TrafficFrame& frame) {
    const auto& record = frame.record;
    if (record.fault || record.pdu.empty()) return;
    const Exchange exchange{frame.line, record.unit.value, transaction_of(frame)};
    if (frame.request)
        take_request(exchange, record.pdu);
    else
        take_response(exchange, record);
}

void WireRegisters::take_request(const Exchange& exchange, const std::vector<std::uint8_t>& pdu) {
    asked_.erase(exchange);
    const wire::RequestView request(pdu);
    if (!request.well_formed() || request.accesses().empty() || request.accesses()[0].write) return;
    if (asked_.size() >= kMostUnanswered) asked_.clear();
    asked_.emplace(exchange, Asked{request.function(), request.accesses()[0]});
}

void WireRegisters::take_response(const Exchange& exchange, const host::TrafficRecord& record) {
    const auto node = asked_.extract(exchange);
    if (node.empty()) return;
    const auto& [function, access] = node.mapped();
    const auto size = bytes_of(access.area, access.count);
    if (record.pdu[0] != std::to_underlying(function) || record.pdu.size() != kDataAt + size ||
        record.pdu[1] != size)
        return;
    if (reads_ >= kMostReads) clear();
    auto& reads = answers_[{std::get<0>(exchange), record.unit.value, access.area}];
    const auto [answer, added] =
        reads.try_emplace(Read{std::to_underlying(function), access.start, access.count});
    reads_ += added ? 1U : 0U;
    answer->second.t = record.t;
    const auto data = Bytes(record.pdu).subspan(kDataAt);
    answer->second.bytes.assign(data.begin(), data.end());
}

void WireRegisters::clear() {
    asked_.clear();
    answers_.clear();
    reads_ = 0;
}

std::optional<WireRegisters::Found> WireRegisters::find(const std::string& line, UnitId unit, wire::Area area,
                                                        std::uint16_t start, std::uint16_t count) const {
    const auto reads = answers_.find({line, unit.value, area});
    if (reads == answers_.end()) return std::nullopt;
    const std::pair<const Read, Answer>* newest = nullptr;
    for (const auto& entry : reads->second) {
        const auto& read = entry.first;
        const bool has = start >= read.start && start - read.start + count <= read.quantity;
        if (has && (!newest || entry.second.t > newest->second.t)) newest = &entry;
    }
    if (!newest) return std::nullopt;
    const auto& [read, answer] = *newest;
    Found found{.function = read.function, .start = read.start, .quantity = read.quantity, .t = answer.t};
    for (std::size_t i = 0; i < count; ++i)
        found.items.push_back(
            item_of(answer.bytes, wire::is_bit_area(area), std::size_t{start} - read.start + i));
    return found;
}

}  // namespace takt::web
