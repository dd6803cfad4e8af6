// How long planning takes.
//
// Strategy optimal on made-up register maps of 10^3 to 10^6 variables, spread over lines and devices: runs of
// registers of mixed types with gaps between them, dense bits, and registers that may not share requests; and
// a project as large as owen-kc1 allows, with three periods and its guarantees. One line for each: kind,
// variables, seconds (the fastest of several), nanoseconds per variable, requests.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "takt/plan/guarantee.hpp"
#include "takt/plan/plan.hpp"

namespace {

using namespace takt;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kVariablesPerDevice = 10'000;
constexpr std::size_t kDevicesPerLine = 10;
constexpr int kRepetitions = 3;

model::Variable variable(std::size_t number, wire::Function function, wire::Area area) {
    model::Variable made;
    made.name = "variable_" + std::to_string(number);
    made.read = function;
    made.area = area;
    made.period = 100ms;
    return made;
}

model::Variable in_register(std::size_t number, std::uint32_t place, DataType type) {
    auto made = variable(number, wire::Function::read_holding_registers, wire::Area::holding_register);
    made.type = type;
    made.register_number = static_cast<std::uint16_t>(place);
    made.registers = static_cast<std::uint16_t>(register_count(type));
    return made;
}

using Random = std::mt19937;
/// Puts the variables of one device there.
using Fill = std::function<void(model::Device&, std::size_t count, Random&)>;

void runs_with_gaps(model::Device& device, std::size_t count, Random& random) {
    constexpr DataType kTypes[] = {DataType::int16, DataType::float32, DataType::int16, DataType::uint32};
    std::uint32_t place = 0;
    for (std::size_t i = 0; i < count; ++i) {
        if (random() % 16 == 0) place += static_cast<std::uint32_t>(random() % 40);
        device.variables.push_back(in_register(i, place, kTypes[random() % std::size(kTypes)]));
        place += device.variables.back().registers;
    }
}

void dense_bits(model::Device& device, std::size_t count, Random&) {
    for (std::size_t i = 0; i < count; ++i) {
        auto made = variable(i, wire::Function::read_coils, wire::Area::coil);
        made.type = DataType::boolean;
        made.register_number = static_cast<std::uint16_t>(i / 16);
        made.bit = static_cast<std::uint8_t>(i % 16);
        device.variables.push_back(std::move(made));
    }
}

// Every second register, and the one between may not be read: as many requests as variables.
void islands(model::Device& device, std::size_t count, Random&) {
    device.gaps = model::Gaps::never;
    for (std::size_t i = 0; i < count; ++i)
        device.variables.push_back(in_register(i, static_cast<std::uint32_t>(2 * i), DataType::int16));
}

model::Project project(std::size_t count, const Fill& fill) {
    Random random(1);
    model::Project made;
    for (std::size_t placed = 0; placed < count; placed += kVariablesPerDevice) {
        if (made.lines.empty() || made.lines.back().devices.size() == kDevicesPerLine) {
            made.lines.emplace_back();
            made.lines.back().name = "line_" + std::to_string(made.lines.size());
            made.lines.back().format = {115200, 8, wire::Parity::none, 1};
        }
        auto& devices = made.lines.back().devices;
        auto& device = devices.emplace_back();
        device.name = "device_" + std::to_string(devices.size());
        device.address = UnitId{static_cast<std::uint8_t>(devices.size())};
        device.group_requests = true;
        device.strategy = model::Strategy::optimal;
        device.gaps = model::Gaps::always;
        fill(device, std::min(kVariablesPerDevice, count - placed), random);
        std::shuffle(device.variables.begin(), device.variables.end(), random);
    }
    return made;
}

struct Result {
    std::string kind;
    std::size_t variables = 0;
    double seconds = 0;
    std::size_t requests = 0;
};

// 32 devices on one line, periods that all come round after a second.
model::Project three_periods() {
    constexpr std::size_t kDevices = 32, kVariables = 1024 / kDevices;
    constexpr Duration kPeriods[] = {100ms, 500ms, 1000ms};
    Random random(1);
    model::Project made;
    made.lines.emplace_back().format = {115200, 8, wire::Parity::none, 1};
    for (std::size_t i = 0; i < kDevices; ++i) {
        auto& device = made.lines.back().devices.emplace_back();
        device.address = UnitId{static_cast<std::uint8_t>(i + 1)};
        device.group_requests = true;
        device.strategy = model::Strategy::optimal;
        device.gaps = model::Gaps::always;
        device.turnaround = 1ms;
        runs_with_gaps(device, kVariables, random);
        for (auto& v : device.variables) v.period = kPeriods[random() % std::size(kPeriods)];
    }
    return made;
}

Result measure(std::string kind, const model::Project& made, std::size_t count, bool with_guarantees) {
    Result result{std::move(kind), count, 1e9, 0};
    for (int i = 0; i < kRepetitions; ++i) {
        const auto start = Clock::now();
        const plan::Plan planned = plan::make_plan(made);
        if (with_guarantees && plan::guarantee(made, planned).size() != made.lines.size()) std::abort();
        const std::chrono::duration<double> taken = Clock::now() - start;
        result.seconds = std::min(result.seconds, taken.count());
        result.requests = 0;
        for (const auto& line : planned.lines) result.requests += line.requests.size();
    }
    return result;
}

std::vector<Result> measured() {
    const std::pair<const char*, Fill> kinds[] = {
        {"registers with gaps", runs_with_gaps}, {"dense bits", dense_bits}, {"one request each", islands}};
    std::vector<Result> results;
    for (const auto& [kind, fill] : kinds)
        for (std::size_t count = 1'000; count <= 1'000'000; count *= 10)
            results.push_back(measure(kind, project(count, fill), count, false));
    results.push_back(measure("three periods, proved", three_periods(), 1024, true));
    return results;
}

double per_variable(const Result& result) {
    return result.seconds * 1e9 / static_cast<double>(result.variables);
}

void print_table(const std::vector<Result>& results) {
    fmt::print("{:<24}{:>10}{:>12}{:>14}{:>10}\n", "kind", "variables", "seconds", "ns/variable", "requests");
    for (const Result& r : results)
        fmt::print("{:<24}{:>10}{:>12.6f}{:>14.0f}{:>10}\n", r.kind, r.variables, r.seconds, per_variable(r),
                   r.requests);
}

void print_json(const std::vector<Result>& results) {
    std::string rows;
    for (const Result& r : results)
        rows += fmt::format(
            R"({}{{"kind":"{}","variables":{},"seconds":{:.6f},"ns_per_variable":{:.1f},"requests":{}}})",
            rows.empty() ? "" : ",", r.kind, r.variables, r.seconds, per_variable(r), r.requests);
    fmt::print("{{\"planner\":[{}]}}\n", rows);
}

}  // namespace

int main(int count, char** arguments) {
    const auto results = measured();
    if (count > 1 && std::strcmp(arguments[1], "--json") == 0)
        print_json(results);
    else
        print_table(results);
}
