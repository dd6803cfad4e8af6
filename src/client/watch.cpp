#include "takt/client/watch.hpp"

#include <set>
#include <string_view>
#include <tuple>
#include <utility>

#include "takt/line/target.hpp"
#include "takt/model/byte_order.hpp"

namespace takt::client {
namespace {

model::Variable variable_of(const WatchSpec& spec, const WatchedRange& range, std::uint32_t address) {
    const auto area = range.area;
    auto layout = spec.layout;
    layout.type = range.type.value_or(layout.type);
    layout.order = range.order.value_or(layout.order);
    model::Variable variable;
    variable.name = spec.name(area, address);
    if (range.type) variable.name += " " + std::string(name(*range.type));
    if (range.order)
        variable.name.append(" ").append(
            model::byte_order_name(model::byte_order_text(layout.order, layout.type)));
    variable.area = area;
    variable.read = wire::read_function(area);
    variable.period = spec.period;
    variable.order = layout.order;
    if (is_bit_area(area)) {
        variable.type = DataType::boolean;
        variable.register_number = static_cast<std::uint16_t>(address / 16);
        variable.bit = static_cast<std::uint8_t>(address % 16);
        return variable;
    }
    variable.type = layout.type;
    variable.register_number = static_cast<std::uint16_t>(address);
    variable.registers = static_cast<std::uint16_t>(layout.register_count());
    return variable;
}

}  // namespace

Result<model::Project> watch_project(const Options& options, const WatchSpec& spec) {
    TAKT_TRY(const auto target, line::parse_target(options.target));
    model::Project project;
    project.lines.push_back(target.as_line());
    auto& device = project.lines[0].devices.emplace_back();
    device.name = "unit " + std::to_string(options.unit);
    device.address = UnitId{options.unit};
    device.poll_period = spec.period;
    device.response_timeout = options.timeout;
    device.group_requests = true;
    device.registers_per_request = 125;
    device.strategy = model::Strategy::optimal;
    std::set<std::tuple<wire::Area, std::uint32_t, DataType, std::string_view>> known;
    for (const auto& range : spec.ranges) {
        std::uint32_t address = range.start;
        for (std::uint32_t i = 0; i < range.count; ++i) {
            const auto variable = variable_of(spec, range, address);
            if (address + variable.items() > 65536)
                return fail(Code::out_of_range, "START", range.start, 0, 65535);
            if (device.variables.size() == kMaxWatched)
                return fail(Code::too_long, "COUNT", range.count, kMaxWatched);
            const auto order = model::byte_order_text(variable.order, variable.type);
            if (known.emplace(range.area, address, variable.type, order).second)
                device.variables.push_back(variable);
            address += variable.items();
        }
    }
    return project;
}

Result<std::vector<value::Value>> read_variables(Client& client, const plan::Request& request,
                                                 std::span<const model::Variable> variables) {
    TAKT_TRY(const auto response,
             client.ask(wire::ReadRequest{*request.read, DataAddress{request.start}, request.quantity}));
    std::vector<value::Value> values;
    for (const auto index : request.variables) {
        const auto& variable = variables[index];
        const std::size_t offset = std::size_t{variable.start()} - request.start;
        if (const auto bits = response.bits(); !bits.empty()) {
            values.emplace_back(bits[offset]);
            continue;
        }
        std::vector<std::uint16_t> registers(variable.registers);
        response.registers().subview(offset, variable.registers).copy_to(registers);
        const value::Layout layout{
            .type = variable.type, .order = variable.order, .registers = variable.registers};
        TAKT_TRY(auto value, value::decode(layout, registers));
        values.push_back(std::move(value));
    }
    return values;
}

}  // namespace takt::client
