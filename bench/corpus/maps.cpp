#include "maps.hpp"

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

namespace corpus {
namespace {

using namespace takt;
using namespace std::chrono_literals;

constexpr std::uint32_t kMostRegisters = 125;
constexpr wire::Area kAreas[] = {wire::Area::coil, wire::Area::discrete_input, wire::Area::holding_register,
                                 wire::Area::input_register};  // of functions 1 to 4

std::optional<Value> value_of(const nlohmann::json& json) {
    if (!json["fc"].is_number() || !json["address"].is_number()) return {};
    Value value{.function = json["fc"]};
    const auto address = json["address"].get<std::int64_t>();
    value.items = value.is_bit() ? 1 : json["count"].get<std::uint32_t>();
    if (value.function < 1 || value.function > 4 || address < 0 || address + value.items > 65536 ||
        value.items == 0 || value.items > kMostRegisters)
        return {};
    value.start = static_cast<std::uint32_t>(address);
    value.written = json["write_fc"].is_number() && (value.function == 1 || value.function == 3);
    if (json["poll_ms"].is_number())
        value.period = std::chrono::milliseconds(json["poll_ms"].get<std::int64_t>());
    return value;
}

Map map_of(const nlohmann::json& json) {
    Map map{.name = json["device"]};
    if (json["max_regs"].is_number()) map.most_registers = json["max_regs"].get<std::uint32_t>();
    for (const auto& variable : json["variables"]) {
        const auto value = value_of(variable);
        if (!value || value->items > map.most_registers.value_or(kMostRegisters)) continue;
        map.has_periods = map.has_periods || value->period > 0ms;
        map.values.push_back(*value);
    }
    for (auto& value : map.values)  // unsaid: as often as the rarest
        if (map.has_periods && value.period == 0ms)
            value.period = std::ranges::max(map.values, {}, &Value::period).period;
    return map;
}

DataType type_of(std::uint32_t registers) {
    switch (registers) {
        case 1: return DataType::uint16;
        case 2: return DataType::uint32;
        case 4: return DataType::uint64;
        default: return DataType::string;
    }
}

model::Variable variable_of(const Value& value, std::size_t index) {
    model::Variable made;
    made.name = "v" + std::to_string(index);
    made.area = kAreas[value.function - 1];
    made.read = static_cast<wire::Function>(value.function);
    made.period = value.period > 0ms ? value.period : 1s;
    if (value.is_bit()) {
        made.type = DataType::boolean;
        made.register_number = static_cast<std::uint16_t>(value.start / 16);
        made.bit = static_cast<std::uint8_t>(value.start % 16);
        if (value.written) made.write = wire::Function::write_multiple_coils;
    } else {
        made.type = type_of(value.items);
        made.register_number = static_cast<std::uint16_t>(value.start);
        made.registers = static_cast<std::uint16_t>(value.items);
        if (value.written) made.write = wire::Function::write_multiple_registers;
    }
    made.write_on_change = value.written;
    return made;
}

/// A run of neighbours in one area, as a device's manual lists them.
void add_run(std::vector<Value>& values, std::mt19937_64& random, int function, std::uint32_t& at) {
    const auto pick = [&random](std::uint32_t least, std::uint32_t most) {
        return std::uniform_int_distribution<std::uint32_t>(least, most)(random);
    };
    static constexpr std::uint32_t kSizes[] = {1, 1, 1, 2, 2, 4, 8};
    static constexpr std::uint32_t kHoles[] = {1, 2, 4, 9, 20, 45, 110, 400};
    const std::uint32_t size = function <= 2 ? 1 : kSizes[pick(0, 6)];
    const bool written = (function == 1 || function == 3) && pick(0, 4) == 0;
    for (std::uint32_t count = pick(1, 14); count > 0 && at + size < 65536; --count, at += size)
        values.push_back({.function = function, .start = at, .items = size, .written = written});
    at += pick(1, kHoles[pick(0, 7)]);
}

}  // namespace

std::vector<Map> load(const std::string& path) {
    std::ifstream file(path);
    std::vector<Map> maps;
    for (std::string line; std::getline(file, line);) {
        if (line.empty()) continue;
        maps.push_back(map_of(nlohmann::json::parse(line)));
        if (maps.back().values.empty()) maps.pop_back();
    }
    return maps;
}

std::vector<Map> made_up(std::size_t count, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::vector<Map> maps;
    for (std::size_t i = 0; i < count; ++i) {
        Map map{.name = "made up " + std::to_string(i + 1)};
        for (const int function : {1, 2, 3, 4}) {
            std::uint32_t at = std::uniform_int_distribution<std::uint32_t>(0, 2000)(random);
            const auto runs = std::uniform_int_distribution<int>(function <= 2 ? 0 : 1, 9)(random);
            for (int run = 0; run < runs; ++run) add_run(map.values, random, function, at);
        }
        std::ranges::shuffle(map.values, random);
        maps.push_back(std::move(map));
    }
    return maps;
}

std::vector<Map> with_periods(std::vector<Map> maps, const std::vector<Duration>& periods,
                              std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::uniform_int_distribution<std::size_t> pick(0, periods.size() - 1);
    for (auto& map : maps) {
        map.has_periods = true;
        for (auto& value : map.values) value.period = periods[pick(random)];
    }
    return maps;
}

takt::model::Project project_of(const Map& map, const Bus& bus, takt::model::Gaps gaps) {
    model::Project project;
    model::Line line;
    line.name = "line";
    line.framing = bus.framing;
    line.transport = bus.framing == wire::Framing::tcp ? model::Transport::tcp : model::Transport::serial;
    const std::uint8_t bits = bus.framing == wire::Framing::ascii ? 7 : 8;
    line.format = {bus.baud, bits, wire::Parity::even, 1};
    model::Device device;
    device.name = "device";
    device.poll_period = 1s;
    device.turnaround = bus.turnaround;
    device.round_trip = bus.turnaround;
    device.group_requests = true;
    device.strategy = model::Strategy::optimal;
    device.gaps = gaps;
    device.registers_per_request = static_cast<std::uint16_t>(map.most_registers.value_or(kMostRegisters));
    device.registers_per_request_set = map.most_registers.has_value();
    for (std::size_t i = 0; i < map.values.size(); ++i)
        device.variables.push_back(variable_of(map.values[i], i));
    line.devices.push_back(std::move(device));
    project.lines.push_back(std::move(line));
    return project;
}

}  // namespace corpus
