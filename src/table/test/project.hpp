// Projects to make tables of.
#pragma once

#include <string>

#include "takt/bus/transaction.hpp"
#include "takt/model/project.hpp"
#include "takt/plan/plan.hpp"
#include "takt/table/build.hpp"

namespace takt::table::test {

using namespace std::chrono_literals;
using wire::Function;

inline model::Variable variable(std::string name, DataType type, std::uint16_t number,
                                std::optional<Function> read, std::optional<Function> write = {}) {
    model::Variable result;
    result.name = std::move(name);
    result.type = type;
    result.register_number = number;
    result.registers = static_cast<std::uint16_t>(register_count(type));
    result.read = read;
    result.write = write;
    result.period = 100ms;
    return result;
}

inline model::Device device(std::string name, std::uint8_t address) {
    model::Device result;
    result.poll_period = result.response_timeout = std::chrono::milliseconds(100);
    result.name = std::move(name);
    result.address = UnitId{address};
    result.group_requests = true;
    result.strategy = model::Strategy::classic;
    result.registers_per_request = 16;
    return result;
}

inline model::Project project(std::vector<model::Device> devices) {
    model::Line line;
    line.name = "rs485-1";
    line.port = "/dev/ttyUSB0";
    line.format = {115200, 8, wire::Parity::none, 1};
    line.devices = std::move(devices);
    model::Project result;
    result.lines.push_back(std::move(line));
    return result;
}

inline model::Local local(std::string name, DataType type = DataType::boolean) {
    model::Local result;
    result.name = std::move(name);
    result.type = type;
    return result;
}

/// The settings a poller would have for each line, near enough for a test of the format.
inline BuildOptions options(const model::Project& project) {
    BuildOptions result;
    for (const auto& line : project.lines)
        result.lines.push_back({.framing = line.framing,
                                .format = line.format,
                                .frame_gap = line.frame_gap,
                                .request_gap = line.request_gap,
                                .margin = project.timeout_margin});
    return result;
}

inline Result<Image> image_of(const model::Project& project) {
    return build(project, plan::make_plan(project), options(project));
}

}  // namespace takt::table::test
