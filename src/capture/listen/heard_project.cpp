#include "takt/capture/heard_project.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <string>

#include "takt/capture/frame_finder.hpp"
#include "takt/model/project.hpp"

namespace takt::capture {
namespace {

using namespace std::chrono_literals;

constexpr std::uint16_t kMostRegisters = 125;
constexpr Duration kLongestTimeout = 65535ms;
constexpr Duration kLongestPeriod = 24h;
constexpr std::array kAreaWords{"coil", "discrete", "input", "holding"};  // in the order of wire::Area

/// What is known of an item.
struct Item {
    std::optional<Duration> period;  // of the fastest poll that reads it; zero: read once
    std::optional<wire::Function> write;
};
using Items = std::map<std::uint16_t, Item>;

/// The items of a device by area.
struct DeviceItems {
    explicit DeviceItems(int stretch_by) : stretch(stretch_by) {}
    int stretch;
    std::array<Items, 4> areas;
    std::map<Duration, std::uint64_t> requests_by_period;
    std::uint16_t longest_read = 0;
    bool has_mask_write = false;
    bool has_read_write = false;

    void add(const Poll& poll);
    void add_combined(const Poll& poll);
    [[nodiscard]] Duration usual_period() const;
    /// Keeps that many items. @returns the number of items that it removes
    std::size_t keep(std::size_t most);
};

void DeviceItems::add(const Poll& poll) {
    const auto& row = wire::properties(wire::Function{poll.key.function});
    const bool refused = poll.normal == 0 && poll.exceptions > 0;
    if (row.most_items == 0 || poll.key.quantity == 0 || refused) return;
    const auto measured = poll.period().median;
    const auto period = measured > Duration::zero()
                            ? nice_period(std::min(measured, kLongestPeriod) * stretch)
                            : Duration::zero();
    if (!row.only_writes_items()) {
        if (!row.counts_bits()) longest_read = std::max(longest_read, poll.key.quantity);
        if (period > Duration::zero()) requests_by_period[period] += poll.requests;
    }
    if (poll.normal > 0) add_combined(poll);
    for (std::uint32_t i = 0; i < poll.key.quantity && poll.key.start + i <= 0xFFFF; ++i) {
        auto& item =
            areas[static_cast<std::size_t>(row.area)][static_cast<std::uint16_t>(poll.key.start + i)];
        if (row.only_writes_items()) {
            if (row.function != wire::Function::mask_write_register) item.write = row.function;
        } else if (!item.period || *item.period == Duration::zero()) {
            item.period = period;
        } else if (period > Duration::zero()) {
            item.period = std::min(*item.period, period);
        }
    }
}

// A project names no function of its own for what 0x16 and 0x17 write.
void DeviceItems::add_combined(const Poll& poll) {
    auto& registers = areas[static_cast<std::size_t>(wire::Area::holding_register)];
    const auto add_written = [&](std::uint32_t start, std::uint32_t count, wire::Function function) {
        for (std::uint32_t number = start; number < start + count && number <= 0xFFFF; ++number) {
            auto& write = registers[static_cast<std::uint16_t>(number)].write;
            if (!write) write = function;
        }
    };
    const auto function = wire::Function{poll.key.function};
    if (function == wire::Function::mask_write_register) {
        has_mask_write = true;
        add_written(poll.key.start, 1, wire::Function::write_single_register);
    }
    if (function == wire::Function::read_write_multiple_registers) {
        has_read_write = true;
        add_written(poll.written_start, poll.written_quantity, wire::Function::write_multiple_registers);
    }
}

Duration DeviceItems::usual_period() const {
    const auto most =
        std::ranges::max_element(requests_by_period, {}, [](const auto& entry) { return entry.second; });
    return most == requests_by_period.end() ? Duration(1s) : most->first;
}

std::size_t DeviceItems::keep(std::size_t most) {
    std::size_t removed = 0;
    for (auto& items : areas) {
        std::erase_if(items, [&](const auto& entry) {
            if (!entry.second.period && !entry.second.write) return true;
            if (most == 0) {
                ++removed;
                return true;
            }
            --most;
            return false;
        });
    }
    return removed;
}

std::vector<model::ItemRange> ranges_of(const Items& items) {
    std::vector<model::ItemRange> ranges;
    for (const auto& [number, item] : items) {
        if (!item.period) continue;
        if (!ranges.empty() && ranges.back().last + 1 == number)
            ranges.back().last = number;
        else
            ranges.push_back({number, number});
    }
    return ranges;
}

model::Variable variable_of(std::uint8_t unit, wire::Area area, std::uint16_t number, const Item& item,
                            Duration usual) {
    constexpr std::uint16_t kBitsOfRegister = 16;
    const bool bits = wire::is_bit_area(area);
    model::Variable variable;
    variable.name = "unit" + std::to_string(unit) + "_" + kAreaWords[static_cast<std::size_t>(area)] + "_" +
                    std::to_string(number);
    variable.area = area;
    if (item.period) variable.read = wire::read_function(area);
    variable.write = item.write;
    variable.type = bits ? DataType::boolean : DataType::uint16;
    variable.register_number = bits ? static_cast<std::uint16_t>(number / kBitsOfRegister) : number;
    if (bits) variable.bit = static_cast<std::uint8_t>(number % kBitsOfRegister);
    variable.period = item.period.value_or(usual);
    if (variable.period == Duration::zero()) variable.period = usual;
    return variable;
}

/// It makes variables that are only written.
bool is_written(const Poll& poll) {
    const auto& row = wire::properties(wire::Function{poll.key.function});
    return row.most_items != 0 && row.only_writes_items() &&
           row.function != wire::Function::mask_write_register;
}

model::Device device_of(std::uint8_t unit, const HeardDevice& heard, int stretch, std::size_t most_variables,
                        std::size_t& left_out) {
    DeviceItems items(stretch);
    for (const auto& poll : heard.polls)
        if (unit != kBroadcast.value || is_written(poll)) items.add(poll);
    left_out = items.keep(most_variables);
    model::Device device;
    device.name = "unit " + std::to_string(unit);
    device.address = UnitId{unit};
    const auto defaults = model::device_defaults(model::Profile::generic);
    device.response_timeout = defaults.response_timeout;
    device.group_requests = defaults.group_requests;
    const auto longest = heard.times.max();
    if (heard.times.count() >= model::MeasuredTimes::kEnough)
        device.turnaround = std::chrono::ceil<std::chrono::milliseconds>(longest + longest / 5);
    if (longest >= device.response_timeout / 2)
        device.response_timeout =
            std::min<Duration>(std::chrono::ceil<std::chrono::milliseconds>(3 * longest), kLongestTimeout);
    device.poll_period = items.usual_period();
    device.fc22 = items.has_mask_write;
    device.fc23 = items.has_read_write;
    if (items.longest_read > device.registers_per_request) {
        device.registers_per_request = std::min(items.longest_read, kMostRegisters);
        device.registers_per_request_set = true;
    }
    for (std::size_t area = 0; area < items.areas.size(); ++area) {
        device.readable[area] = ranges_of(items.areas[area]);
        for (const auto& [number, item] : items.areas[area])
            device.variables.push_back(
                variable_of(unit, static_cast<wire::Area>(area), number, item, device.poll_period));
    }
    return device;
}

bool was_asked(std::uint8_t unit, const HeardDevice& heard) {
    return unit == kBroadcast.value ? std::ranges::any_of(heard.polls, is_written) : heard.requests > 0;
}

}  // namespace

std::size_t heard_devices(const LineStatistics& statistics) {
    return static_cast<std::size_t>(std::ranges::count_if(statistics.devices(), [](const auto& entry) {
        return was_asked(entry.first, entry.second) && entry.first <= kLastUnit;
    }));
}

// Two significant digits, where they are at most 3 % away; whole seconds from 10 s on.
Duration nice_period(Duration measured) {
    const auto exact = std::clamp<Duration>(measured, 1ms, kLongestPeriod);
    if (exact >= 10s) return std::chrono::round<std::chrono::seconds>(exact);
    Duration::rep step = 1;
    while (exact.count() / step >= 100) step *= 10;
    const Duration nice((exact.count() + step / 2) / step * step);
    const bool near = std::chrono::abs(nice - exact) * 100 <= exact * 3;
    return near && nice % 1ms == Duration::zero()
               ? nice
               : Duration(std::chrono::round<std::chrono::milliseconds>(exact));
}

HeardProject heard_project(const LineStatistics& statistics, const model::Line& connection, int stretch,
                           std::size_t most_variables) {
    HeardProject project{.line = connection};
    project.line.name = "line 1";
    project.line.devices.clear();
    for (const auto& [unit, heard] : statistics.devices()) {
        if (!was_asked(unit, heard)) continue;
        if (unit > kLastUnit) {
            project.other_units.push_back(unit);
            continue;
        }
        std::size_t left_out = 0;
        project.line.devices.push_back(device_of(unit, heard, stretch, most_variables, left_out));
        project.left_out.push_back(left_out);
    }
    return project;
}

}  // namespace takt::capture
