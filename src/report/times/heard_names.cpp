#include "takt/report/times/heard_names.hpp"

#include <algorithm>
#include <optional>

#include "takt/value/codec.hpp"
#include "takt/value/project_slots.hpp"
#include "takt/value/text.hpp"
#include "takt/wire/prepared_request.hpp"
#include "takt/wire/request_view.hpp"

namespace takt::report {
namespace {

/// The items that an exchange transfers, with their values: either bits or registers.
struct Items {
    wire::Area area = wire::Area::holding_register;
    std::uint16_t start = 0;
    wire::BitView bits;
    wire::RegisterView registers;
};

bool is_single_coil(wire::Function function) {
    return function == wire::Function::write_single_coil;
}

std::optional<Items> written_items(const wire::RequestView& request) {
    const auto access = request.accesses()[0];
    const auto function = request.function();
    if (function == wire::Function::mask_write_register) return std::nullopt;
    Items items{.area = access.area, .start = access.start};
    const auto values = request.values();
    // The value of a single coil is 0xFF00 or 0.
    if (is_single_coil(function))
        items.bits = wire::BitView(values, 1);
    else if (wire::is_bit_area(access.area))
        items.bits = wire::BitView(values, access.count);
    else
        items.registers = wire::RegisterView(values);
    return items;
}

std::optional<Items> items_of(const capture::Exchange& exchange, const wire::PreparedRequest& request) {
    const wire::RequestView view(request.pdu());
    if (!view.well_formed() || view.accesses().empty()) return std::nullopt;
    const auto& row = wire::properties(view.function());
    if (row.only_writes_items()) return written_items(view);
    if (!row.returns_items()) return std::nullopt;
    const auto response = wire::decode_response(request.shape(), request.pdu(), exchange.response);
    if (!response) return std::nullopt;
    const auto access = view.accesses()[0];
    return Items{.area = access.area,
                 .start = access.start,
                 .bits = response->bits(),
                 .registers = response->registers()};
}

std::optional<value::Value> value_of(const model::Variable& variable, const Items& items) {
    if (variable.area != items.area || variable.start() < items.start) return std::nullopt;
    const std::size_t first = variable.start() - items.start;
    if (wire::is_bit_area(items.area)) {
        if (first >= items.bits.size()) return std::nullopt;
        return value::Value(items.bits[first]);
    }
    if (first + variable.registers > items.registers.size()) return std::nullopt;
    std::vector<std::uint16_t> registers(variable.registers);
    items.registers.subview(first, registers.size()).copy_to(registers);
    const auto decoded = value::decode(value::layout_of(variable), registers);
    if (!decoded) return std::nullopt;
    return *decoded;
}

}  // namespace

HeardNames::HeardNames(const model::Project& project, const std::string& port, const std::string& name) {
    int best = 0;
    for (const auto& line : project.lines) {
        if (line.framing == wire::Framing::tcp) continue;
        const bool named = !name.empty() && line.name == name;
        const bool serial = line.transport == model::Transport::serial;
        const int fit = named ? 4 : line.port == port ? 3 : serial ? 2 : 1;
        if (fit <= best) continue;
        best = fit;
        line_ = &line;
    }
}

const model::Device* HeardNames::device(std::uint8_t unit) const {
    if (line_ == nullptr) return nullptr;
    const auto found =
        std::ranges::find(line_->devices, unit, [](const auto& device) { return device.address.value; });
    return found != line_->devices.end() ? &*found : nullptr;
}

std::vector<NamedValue> HeardNames::values(const capture::Exchange& exchange) const {
    std::vector<NamedValue> values;
    const auto* const found = device(exchange.request.unit);
    if (found == nullptr || exchange.outcome != capture::Outcome::answered) return values;
    const wire::PreparedRequest request(exchange.request.pdu.span());
    const auto items = items_of(exchange, request);
    if (!items) return values;
    for (const auto& variable : found->variables) {
        const auto value = value_of(variable, *items);
        if (!value) continue;
        auto text = value::format(variable.type, variable.scaled(), *value);
        if (!variable.unit.empty()) text += " " + variable.unit;
        values.push_back({&variable, std::move(text)});
        if (values.size() == kMost) break;
    }
    return values;
}

}  // namespace takt::report
