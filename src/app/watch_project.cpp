#include "watch_project.hpp"

#include <fmt/format.h>

#include <set>
#include <utility>

#include "takt/line/target.hpp"
#include "takt/report/formatting.hpp"
#include "takt/value/codec.hpp"

namespace takt::app {
namespace {

constexpr std::size_t kMaxWatched = 4096;

model::Variable variable_of(const ReadOptions& options, wire::Area area, std::uint32_t address) {
    model::Variable variable;
    variable.name = fmt::format("{} {}", report::area_word(area), address);
    variable.area = area;
    variable.read = wire::read_function(area);
    variable.period = *options.watch;
    variable.order = options.order;
    if (is_bit_area(area)) {
        variable.type = DataType::boolean;
        variable.register_number = static_cast<std::uint16_t>(address / 16);
        variable.bit = static_cast<std::uint8_t>(address % 16);
        return variable;
    }
    const value::Layout layout{.type = options.type,
                               .order = options.order,
                               .registers = options.string_registers,
                               .bit = {},
                               .scale = 1,
                               .offset = 0};
    variable.type = options.type;
    variable.register_number = static_cast<std::uint16_t>(address);
    variable.registers = static_cast<std::uint16_t>(layout.register_count());
    return variable;
}

}  // namespace

Result<model::Project> watch_project(const ReadOptions& options) {
    TAKT_TRY(const auto target, line::parse_target(options.target));
    model::Project project;
    project.lines.push_back(target.as_line());
    auto& device = project.lines[0].devices.emplace_back();
    device.name = fmt::format("unit {}", options.unit);
    device.address = UnitId{options.unit};
    device.poll_period = *options.watch;
    device.response_timeout = options.timeout;
    device.group_requests = true;
    device.registers_per_request = 125;
    device.strategy = model::Strategy::optimal;
    auto ranges = options.also;
    ranges.insert(ranges.begin(), {options.area, options.start, options.count});
    std::set<std::pair<wire::Area, std::uint32_t>> named;
    for (const auto& range : ranges) {
        std::uint32_t address = range.start;
        for (std::uint32_t i = 0; i < range.count; ++i) {
            const auto variable = variable_of(options, range.area, address);
            if (std::uint32_t{address} + variable.items() > 65536)
                return fail(Code::out_of_range, "START", range.start, 0, 65535);
            if (device.variables.size() == kMaxWatched)
                return fail(Code::too_long, "COUNT", range.count, kMaxWatched);
            if (named.emplace(range.area, address).second) device.variables.push_back(variable);
            address += variable.items();
        }
    }
    return project;
}

}  // namespace takt::app
