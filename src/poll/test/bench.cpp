#include "bench.hpp"

#include <algorithm>

#include "encode_response.hpp"

namespace takt::poll::test {
namespace {

constexpr wire::CharacterFormat kFormat{115200, 8, wire::Parity::none, 1};

std::uint16_t start_of(const wire::Request& request) {
    if (const auto* read = std::get_if<wire::ReadRequest>(&request)) return read->start.value;
    if (const auto* coil = std::get_if<wire::WriteSingleCoilRequest>(&request)) return coil->address.value;
    if (const auto* single = std::get_if<wire::WriteSingleRegisterRequest>(&request))
        return single->address.value;
    if (const auto* coils = std::get_if<wire::WriteMultipleCoilsRequest>(&request)) return coils->start.value;
    if (const auto* mask = std::get_if<wire::MaskWriteRegisterRequest>(&request)) return mask->address.value;
    if (const auto* both = std::get_if<wire::ReadWriteMultipleRegistersRequest>(&request))
        return both->read_start.value;
    return std::get<wire::WriteMultipleRegistersRequest>(request).start.value;
}

wire::Response read_bits(Player& player, const wire::ReadRequest& read) {
    wire::ReadBitsResponse response{.function = read.function};
    for (unsigned i = 0; i < read.quantity; ++i)
        response.values.push_back(player.coils[static_cast<std::uint16_t>(read.start.value + i)]);
    return response;
}

wire::ReadRegistersResponse read_registers(Player& player, const wire::ReadRequest& read) {
    wire::ReadRegistersResponse response{.function = read.function};
    for (unsigned i = 0; i < read.quantity; ++i)
        response.values.push_back(player.registers[static_cast<std::uint16_t>(read.start.value + i)]);
    return response;
}

}  // namespace

std::optional<wire::Response> Player::answer(const wire::Request& request) {
    const std::uint16_t start = start_of(request);
    if (silent_to && silent_to(request)) return std::nullopt;
    if (dead || std::count(silent_about.begin(), silent_about.end(), start) > 0) return std::nullopt;
    const auto refused = refuses.find(start);
    if (exception || refused != refuses.end())
        return wire::ExceptionResponse{wire::function_of(request),
                                       wire::ExceptionCode{exception ? *exception : refused->second}};
    if (const auto* read = std::get_if<wire::ReadRequest>(&request)) {
        const auto touches = [read](const model::ItemRange& items) {
            return read->start.value <= items.last && items.first < read->start.value + read->quantity;
        };
        if (std::ranges::any_of(chokes_on, touches)) return std::nullopt;
        if (std::ranges::any_of(lacks, touches) || read->quantity > most_items ||
            (refuses_now && refuses_now()))
            return wire::ExceptionResponse{read->function, wire::ExceptionCode{refusal}};
    }
    if (const auto* read = std::get_if<wire::ReadRequest>(&request))
        return wire::counts_bits(read->function) ? read_bits(*this, *read) : read_registers(*this, *read);
    std::optional<wire::Response> response;
    if (const auto* coil = std::get_if<wire::WriteSingleCoilRequest>(&request)) {
        coils[start] = coil->on;
        response = wire::WriteSingleCoilResponse{coil->address, coil->on};
    } else if (const auto* single = std::get_if<wire::WriteSingleRegisterRequest>(&request)) {
        registers[start] = keeps ? keeps(single->value) : single->value;
        response = wire::WriteSingleRegisterResponse{single->address, single->value};
    } else if (const auto* many = std::get_if<wire::WriteMultipleRegistersRequest>(&request)) {
        for (std::size_t i = 0; i < many->values.size(); ++i)
            registers[static_cast<std::uint16_t>(start + i)] =
                keeps ? keeps(many->values[i]) : many->values[i];
        response = wire::WriteMultipleResponse{Function::write_multiple_registers, many->start,
                                               static_cast<std::uint16_t>(many->values.size())};
    } else if (const auto* bits = std::get_if<wire::WriteMultipleCoilsRequest>(&request)) {
        for (std::size_t i = 0; i < bits->values.size(); ++i)
            coils[static_cast<std::uint16_t>(start + i)] = bits->values[i];
        response = wire::WriteMultipleResponse{Function::write_multiple_coils, bits->start,
                                               static_cast<std::uint16_t>(bits->values.size())};
    } else if (const auto* mask = std::get_if<wire::MaskWriteRegisterRequest>(&request)) {
        auto& old = registers[start];
        old = static_cast<std::uint16_t>((old & mask->and_mask) | (mask->or_mask & ~mask->and_mask));
        response = wire::MaskWriteRegisterResponse{mask->address, mask->and_mask, mask->or_mask};
    } else if (const auto* both = std::get_if<wire::ReadWriteMultipleRegistersRequest>(&request)) {
        for (std::size_t i = 0; i < both->values.size(); ++i)
            registers[static_cast<std::uint16_t>(both->write_start.value + i)] = both->values[i];
        auto answer =
            read_registers(*this, {Function::read_holding_registers, both->read_start, both->read_quantity});
        answer.function = Function::read_write_multiple_registers;
        response = answer;
    }
    if (ignores_writes) return std::nullopt;
    return response;
}

Bench::Bench(model::Project described) : Bench(described, plan::make_plan(described)) {}

Bench::Bench(model::Project described, plan::Plan planned)
    : project(std::move(described)), plan(std::move(planned)), master(project, plan, options()) {
    for (const auto& device : project.lines[0].devices) players[device.address.value];
    link(true);
}

Master::Options Bench::options() {
    Master::Options made;
    made.observer = &observed;
    return made;
}

void Bench::link(bool up) {
    coming_.clear();
    master.line(0).on_link(now, up);
    collect();
}

const value::Slot& Bench::slot(const std::string& name) const {
    return master.store()[*master.store().find(name)];
}

Result<bool> Bench::set(const std::string& name, const value::Value& value) {
    return master.set(now, id(name), value);
}

Result<bool> Bench::write(value::CommandId command, const std::string& name, const value::Value& value,
                          Duration expires) {
    return master.write(now, {command, id(name), value, now + expires});
}

std::vector<Sent> Bench::news() {
    const std::vector<Sent> news(sent.begin() + static_cast<std::ptrdiff_t>(seen_), sent.end());
    seen_ = sent.size();
    return news;
}

void Bench::transmit() {
    auto& line = master.line(0);
    for (Bytes bytes = line.transmit(now); !bytes.empty(); bytes = line.transmit(now)) {
        const Bytes pdu = bytes.subspan(1, bytes.size() - 3);
        const auto request = wire::decode_request(pdu).value();
        sent.push_back({now, bytes[0], pdu[0], start_of(request), hex(bytes)});
        if (const auto* read = std::get_if<wire::ReadRequest>(&request))
            sent.back().quantity = read->quantity;
        auto& player = players[bytes[0]];
        const auto response = player.answer(request);
        if (!response) continue;
        const auto frame =
            wire::encode_frame(wire::Framing::rtu, UnitId{player.answers_as.value_or(bytes[0])}, 0,
                               wire::encode(*response).value().span());
        const Duration length = wire::transmission_time(kFormat, bytes.size() + frame.size());
        std::vector<std::uint8_t> arriving = player.noise;
        arriving.insert(arriving.end(), frame.begin(), frame.end());
        coming_.emplace(now + length + player.turnaround, std::move(arriving));
    }
}

void Bench::deliver() {
    const auto next = coming_.begin();
    master.line(0).on_bytes(now, next->second);
    coming_.erase(next);
}

void Bench::collect() {
    while (auto outcome = master.take_outcome()) outcomes.push_back(*outcome);
    while (auto outcome = master.line(0).take_relayed()) relayed.push_back(*outcome);
    if (after_each) after_each();
}

void Bench::run_until(Duration end) {
    for (;;) {
        transmit();
        collect();
        const Instant wakeup = std::max(now, master.line(0).next_wakeup());
        const Instant arrival = coming_.empty() ? kNever : coming_.begin()->first;
        if (std::min(wakeup, arrival) > at(end)) break;
        now = std::min(wakeup, arrival);
        if (arrival <= wakeup)
            deliver();
        else
            master.line(0).on_tick(now);
        collect();
    }
    now = at(end);
}

}  // namespace takt::poll::test
