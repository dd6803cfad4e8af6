#include "takt/client/watch.hpp"

#include <set>
#include <utility>

#include "takt/line/target.hpp"

namespace takt::client {
namespace {

model::Variable variable_of(const WatchSpec& spec, wire::Area area, std::uint32_t address) {
    model::Variable variable;
    variable.name = spec.name(area, address);
    variable.area = area;
    variable.read = wire::read_function(area);
    variable.period = spec.period;
    variable.order = spec.layout.order;
    if (is_bit_area(area)) {
        variable.type = DataType::boolean;
        variable.register_number = static_cast<std::uint16_t>(address / 16);
        variable.bit = static_cast<std::uint8_t>(address % 16);
        return variable;
    }
    variable.type = spec.layout.type;
    variable.register_number = static_cast<std::uint16_t>(address);
    variable.registers = static_cast<std::uint16_t>(spec.layout.register_count());
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
    std::set<std::pair<wire::Area, std::uint32_t>> named;
    for (const auto& range : spec.ranges) {
        std::uint32_t address = range.start;
        for (std::uint32_t i = 0; i < range.count; ++i) {
            const auto variable = variable_of(spec, range.area, address);
            if (address + variable.items() > 65536)
                return fail(Code::out_of_range, "START", range.start, 0, 65535);
            if (device.variables.size() == kMaxWatched)
                return fail(Code::too_long, "COUNT", range.count, kMaxWatched);
            if (named.emplace(range.area, address).second) device.variables.push_back(variable);
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
