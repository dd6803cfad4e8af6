#include "devices/command_preview.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "takt/plan/plan.hpp"
#include "takt/value/codec.hpp"
#include "takt/wire/frame.hpp"
#include "takt/wire/frame_words.hpp"
#include "takt/wire/pdu.hpp"

namespace takt::web {
namespace {

/// The items of one request, to be filled by its variables.
class Preview {
public:
    Preview(const host::Snapshot& snapshot, const value::VariableIndex& index)
        : snapshot_(snapshot),
          index_(index),
          line_(snapshot.configuration->project().lines[index.line]),
          device_(line_.devices[index.device]),
          variable_(device_.variables[index.variable]) {}

    Result<CommandPreview> make(const value::Value& value) {
        if (!variable_.write) return fail(Code::not_writable, variable_.name);
        if (variable_.area == wire::Area::coil) return coil(value);
        TAKT_TRY(const auto encoded, value::encode(value::layout_of(variable_), value));
        result_.rounded = encoded.rounded;
        TAKT_TRY(result_.written, value::decode(value::layout_of(variable_), encoded.registers));
        if (variable_.bit) return bit(encoded.registers[0] != 0);
        return registers(encoded);
    }

private:
    /// The group of the variable; nullptr: it is written alone.
    [[nodiscard]] const plan::Request* group() const {
        const auto& plan = snapshot_.lines.at(index_.line).plan;
        if (!variable_.write_on_change || !plan) return nullptr;
        const auto found = std::ranges::find_if(plan->requests, [&](const plan::Request& request) {
            return request.device == index_.device && request.write_on_change && request.write &&
                   std::ranges::find(request.variables, index_.variable) != request.variables.end();
        });
        return found == plan->requests.end() ? nullptr : &*found;
    }

    /// What another member of the group would be written with; nothing: it is not known.
    [[nodiscard]] const value::Value* value_of(std::size_t member) const {
        const auto slot = snapshot_.configuration->slots().variable({index_.line, index_.device, member});
        const auto& its = snapshot_.values.at(slot.value);
        if (!value::is_empty(its.wanted)) return &its.wanted;
        return value::is_empty(its.value) ? nullptr : &its.value;
    }

    Result<CommandPreview> coil(const value::Value& value) {
        TAKT_TRY(result_.written, value::convert(DataType::boolean, false, value));
        const bool on = std::get<bool>(result_.written);
        const auto function = plan::command_function(device_, variable_);
        if (function == wire::Function::write_single_coil)
            return add(wire::WriteSingleCoilRequest{DataAddress{variable_.start()}, on}, function, 1);
        wire::WriteMultipleCoilsRequest request{.start = DataAddress{variable_.start()}};
        request.values.push_back(on);
        return add(request, function, 1);
    }

    Result<CommandPreview> bit(bool on) {
        const auto mask = value::register_mask(value::layout_of(variable_));
        const auto set = on ? mask : std::uint16_t{0};
        const DataAddress address{variable_.start()};
        if (device_.fc22)
            return add(wire::MaskWriteRegisterRequest{address, static_cast<std::uint16_t>(~mask), set},
                       wire::Function::mask_write_register, 1);
        TAKT_TRY(result_, add(wire::ReadRequest{wire::Function::read_holding_registers, address, 1},
                              wire::Function::read_holding_registers, 1));
        return write_registers(variable_.start(), {set}, plan::command_function(device_, variable_));
    }

    Result<CommandPreview> registers(const value::Encoded& encoded) {
        const auto* const all = group();
        if (!all)
            return write_registers(variable_.start(), {encoded.registers.begin(), encoded.registers.end()},
                                   plan::command_function(device_, variable_));
        std::vector<std::uint16_t> words(all->quantity);
        for (const auto member : all->variables) {
            const auto& its = device_.variables[member];
            const auto* const value = value_of(member);
            auto part = std::optional(encoded);
            if (member != index_.variable) {
                const auto other = value ? value::encode(value::layout_of(its), *value)
                                         : Result<value::Encoded>(fail(Code::not_found, its.name));
                part = other ? std::optional(*other) : std::nullopt;
            }
            if (part) put(words, all->start, its.start(), *part);
        }
        return write_registers(all->start, words, *all->write);
    }

    static void put(std::vector<std::uint16_t>& words, std::size_t start, std::size_t at,
                    const value::Encoded& part) {
        for (std::size_t i = 0; i < part.registers.size(); ++i)
            if (at + i >= start && at + i - start < words.size()) words[at + i - start] = part.registers[i];
    }

    Result<CommandPreview> write_registers(std::uint16_t start, const std::vector<std::uint16_t>& words,
                                           wire::Function function) {
        const DataAddress address{start};
        if (function == wire::Function::write_single_register && words.size() == 1)
            return add(wire::WriteSingleRegisterRequest{address, words[0]}, function, 1);
        wire::WriteMultipleRegistersRequest request{.start = address};
        for (const auto word : words)
            if (request.values.size() < request.values.capacity()) request.values.push_back(word);
        return add(request, wire::Function::write_multiple_registers, words.size());
    }

    Result<CommandPreview> add(const wire::Request& request, wire::Function function, std::size_t items) {
        TAKT_TRY(const auto pdu, wire::encode(request));
        const auto frame = wire::encode_frame(line_.framing, device_.address, 1, pdu);
        const auto response = wire::frame_length(line_.framing, wire::response_pdu_length(function, items));
        result_.frames.push_back({.raw = {frame.begin(), frame.end()},
                                  .words = wire::describe_request(device_.address, pdu),
                                  .bus_time = plan::bus_time(line_, device_, frame.size(), response,
                                                             plan::estimated_turnaround(device_))});
        return result_;
    }

    const host::Snapshot& snapshot_;
    value::VariableIndex index_;
    const model::Line& line_;
    const model::Device& device_;
    const model::Variable& variable_;
    CommandPreview result_;
};

}  // namespace

Result<CommandPreview> preview(const host::Snapshot& snapshot, value::SlotId slot,
                               const value::Value& value) {
    const auto owner = snapshot.configuration->slots().owner(slot);
    if (const auto* const index = std::get_if<value::VariableIndex>(&owner))
        return Preview(snapshot, *index).make(value);
    return CommandPreview{.written = value};
}

}  // namespace takt::web
