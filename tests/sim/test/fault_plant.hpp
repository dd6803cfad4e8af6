// Three devices on a line of any kind, and plans with one kind of fault.
#pragma once

#include <array>
#include <string>

#include "sim/faults/faults.hpp"
#include "takt/model/project.hpp"

namespace takt::sim {

using namespace std::chrono_literals;

enum class Medium { rtu, ascii, rtu_over_tcp, tcp };
inline constexpr std::array kMedia{Medium::rtu, Medium::ascii, Medium::rtu_over_tcp, Medium::tcp};

inline model::Device device(std::uint8_t address) {
    model::Device result;
    result.name = "d" + std::to_string(address);
    result.address = UnitId{address};
    result.poll_period = 100ms;
    result.response_timeout = 60ms;
    result.strategy = model::Strategy::classic;
    result.group_requests = true;
    result.backoff = model::Backoff{500ms, 2s};
    for (std::uint16_t i = 0; i < 6; ++i) {
        model::Variable variable;
        variable.name = result.name + ".v" + std::to_string(i);
        variable.type = DataType::uint16;
        variable.register_number = static_cast<std::uint16_t>(i < 3 ? i : 100 + i);
        variable.read = wire::Function::read_holding_registers;
        variable.write = wire::Function::write_single_register;
        variable.period = 100ms;
        result.variables.push_back(std::move(variable));
    }
    return result;
}

inline model::Project project(Medium medium) {
    model::Line line;
    line.name = "line";
    const bool serial = medium == Medium::rtu || medium == Medium::ascii;
    line.transport = serial ? model::Transport::simulated : model::Transport::tcp;
    line.framing = medium == Medium::ascii ? wire::Framing::ascii
                   : medium == Medium::tcp ? wire::Framing::tcp
                                           : wire::Framing::rtu;
    line.format = {115200, 8, wire::Parity::none, 1};
    for (std::uint8_t i = 1; i <= 3; ++i) line.devices.push_back(device(i));
    model::Project result;
    result.lines.push_back(std::move(line));
    return result;
}

inline FaultPlan only(FaultKind kind) {
    FaultPlan plan;
    if (kind == FaultKind::connect_refused) {
        plan.rates.every(FaultKind::tcp_reset, 1s).set(kind, 500'000);
    } else if (kind == FaultKind::close_when_idle) {
        plan.rates.every(kind, 20ms);
    } else if (kind == FaultKind::close_on_request) {
        plan.rates.set(kind, 400'000);
    } else if (is_timed(kind)) {
        plan.rates.every(kind, 2s);
        plan.dead = plan.reboot = plan.unplugged = plan.half_open = plan.jump = {200ms, 2s};
        plan.babble = {5ms, 300ms};
    } else {
        plan.rates.set(kind, 100'000);
    }
    return plan;
}

}  // namespace takt::sim
