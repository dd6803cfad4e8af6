#include "online/demo_plant.hpp"

#include <optional>

#include "takt/publish/wall_clock.hpp"
#include "takt/sim/devices.hpp"
#include "takt/store/history.hpp"
#include "takt/value/project_slots.hpp"

namespace takt::app {
namespace {

using namespace std::chrono_literals;

constexpr Duration kPast = 1h;
constexpr Duration kStep = 2s;

std::optional<value::Value> read(sim::Device& device, const model::Variable& variable, Instant t) {
    const auto items = device.content(t, variable.area, variable.start(), variable.items());
    if (!items) return std::nullopt;
    if (wire::is_bit_area(variable.area)) return value::Value(items->front() != 0);
    const auto decoded = value::decode(value::layout_of(variable), *items);
    return decoded ? std::optional(*decoded) : std::nullopt;
}

/// A sample with each change, as an output takes them.
Result<void> append_past(store::History& history, const model::Device& of, const model::Variable& variable,
                         sim::Device& device, Instant now) {
    TAKT_TRY(const auto series, history.series({.name = variable.name,
                                                .device = of.name,
                                                .type = variable.type,
                                                .scaled = variable.scaled(),
                                                .unit = variable.unit}));
    std::optional<value::Value> before;
    for (Instant t = now - kPast; t < now; t += kStep) {
        const auto value = read(device, variable, t);
        if (!value || (before && value::same(*value, *before))) continue;
        before = value;
        history.append(series, {.time_ns = publish::system_wall_ns(t), .previous_ns = {}, .value = *value});
    }
    return {};
}

}  // namespace

Result<void> write_demo_past(const std::string& database, const model::Line& line, DemoPlant& plant,
                             Instant now) {
    TAKT_TRY(const auto opened, store::History::open(database));
    sim::Devices devices(line);
    for (const auto& device : line.devices) {
        auto* const simulated = devices.find(device.address);
        simulated->set_model(&plant);
        for (const auto& variable : device.variables)
            if (plant.value(variable.name, now))
                TAKT_CHECK(append_past(*opened.history, device, variable, *simulated, now));
    }
    return opened.history->commit(publish::system_wall_ns(now));
}

}  // namespace takt::app
