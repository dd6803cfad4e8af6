// Small projects for the tests of this module: one line, one device unless stated otherwise.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "takt/model/project.hpp"
#include "takt/plan/plan.hpp"

namespace takt::plan::test {

using namespace std::chrono_literals;

/// A variable as a test writes it: `real(4).read(3).write(0x10).on_change()`.
struct Item : model::Variable {
    Item read(int code) const {
        Item made = *this;
        made.model::Variable::read = static_cast<wire::Function>(code);
        made.area = code == 1   ? wire::Area::coil
                    : code == 2 ? wire::Area::discrete_input
                    : code == 4 ? wire::Area::input_register
                                : wire::Area::holding_register;
        return made;
    }
    Item write(int code) const {
        Item made = *this;
        made.model::Variable::write = static_cast<wire::Function>(code);
        made.area = code == 0x05 || code == 0x0F ? wire::Area::coil : wire::Area::holding_register;
        return made;
    }
    Item on_change() const {
        Item made = *this;
        made.write_on_change = true;
        return made;
    }
    Item read_on(model::LocalIndex trigger) const {
        Item made = *this;
        made.read_trigger = trigger;
        return made;
    }
    Item write_on(model::LocalIndex trigger) const {
        Item made = *this;
        made.write_trigger = trigger;
        return made;
    }
    Item reports_to(model::LocalIndex local) const {
        Item made = *this;
        made.status = local;
        return made;
    }
    Item every(Duration time) const {
        Item made = *this;
        made.period = time;
        return made;
    }
    Item unused() const {
        Item made = *this;
        made.used = false;
        return made;
    }
    Item named(std::string text) const {
        Item made = *this;
        made.name = std::move(text);
        return made;
    }
};

inline Item item(DataType type, int register_number, int string_registers = 1) {
    Item made;
    made.type = type;
    made.register_number = static_cast<std::uint16_t>(register_number);
    made.registers = static_cast<std::uint16_t>(register_count(type, string_registers));
    made.period = 100ms;
    return made;
}

inline Item int16(int register_number) {
    return item(DataType::int16, register_number);
}
inline Item int32(int register_number) {
    return item(DataType::int32, register_number);
}
inline Item real(int register_number) {
    return item(DataType::float32, register_number);
}
inline Item boolean(int register_number, int bit) {
    Item made = item(DataType::boolean, register_number);
    made.bit = static_cast<std::uint8_t>(bit);
    return made;
}

/// `count` items like `first`, one after the other without gaps.
inline std::vector<Item> row(int count, const Item& first) {
    std::vector<Item> items;
    for (int i = 0; i < count; ++i) {
        Item next = first;
        next.register_number = static_cast<std::uint16_t>(first.register_number + i * first.registers);
        items.push_back(next);
    }
    return items;
}

struct Settings {
    std::uint16_t registers_per_request = 16;
    wire::Framing framing = wire::Framing::rtu;
    model::Profile profile = model::Profile::generic;
    model::Strategy strategy = model::Strategy::classic;
};

inline model::Device device(int address, const Settings& settings, const std::vector<Item>& items) {
    model::Device made;
    made.name = "Device" + std::to_string(address);
    made.address = UnitId{static_cast<std::uint8_t>(address)};
    made.group_requests = settings.strategy != model::Strategy::single;
    made.registers_per_request = settings.registers_per_request;
    made.strategy = settings.strategy;
    for (const Item& item : items) {
        made.variables.push_back(item);
        auto& name = made.variables.back().name;
        if (name.empty()) name = "v" + std::to_string(made.variables.size());
    }
    return made;
}

/// A line at 115200 bit/s 8N1 (ASCII 7E1; TCP with that framing) with unit 16.
inline model::Project project(const Settings& settings, const std::vector<Item>& items) {
    model::Project made;
    made.profile = settings.profile;
    model::Line line;
    line.name = "line";
    line.framing = settings.framing;
    line.transport =
        settings.framing == wire::Framing::tcp ? model::Transport::tcp : model::Transport::serial;
    line.format = {115200, 8, wire::Parity::none, 1};
    if (settings.framing == wire::Framing::ascii) line.format = {115200, 7, wire::Parity::even, 1};
    line.devices.push_back(device(16, settings, items));
    made.lines.push_back(std::move(line));
    return made;
}

inline LinePlan plan_of(const Settings& settings, const std::vector<Item>& items) {
    return make_plan(project(settings, items)).lines.at(0);
}

}  // namespace takt::plan::test
