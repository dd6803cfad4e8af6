// The simulated devices of a program that serves a project, by the names of the project.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "takt/base/result.hpp"
#include "takt/model/project.hpp"
#include "takt/sim/answer_faults.hpp"
#include "takt/sim/device.hpp"
#include "takt/value/value.hpp"

namespace takt::console {

/// Finds devices and variables, and reads and sets their values. The thread of the engines only.
class ServedDevices {
public:
    /// @param line     lives as long as this, and so does `device`, which is made of line.devices[index]
    void add(const model::Line& line, std::size_t index, sim::Device& device);

    /// The scope of faults of a device, else of a variable. `LINE/DEVICE` names a device whose name is on
    /// several lines.
    /// @returns not_found (name); syntax (name, the full names) where several devices have it
    [[nodiscard]] Result<sim::FaultScope> scope_of(const std::string& name) const;

    /// Sets a variable from its text; it no longer moves. A bit of a register stops the whole register.
    /// @returns not_found (name), and what value::parse() and value::encode() return
    [[nodiscard]] Result<void> set(Instant t, const std::string& name, const std::string& value);

    struct Reading {
        const model::Variable* variable;
        value::Value value;
    };
    /// The value that a master would read. @returns not_found (name)
    [[nodiscard]] Result<Reading> get(Instant t, const std::string& name) const;

    /// There is no device: the units are others.
    [[nodiscard]] bool empty() const { return devices_.empty(); }

private:
    struct Served {
        const model::Line* line;
        const model::Device* config;
        sim::Device* device;
    };
    struct Found {
        const Served* served;
        const model::Variable* variable;
    };

    [[nodiscard]] Result<Found> find(const std::string& name) const;

    std::vector<Served> devices_;
};

}  // namespace takt::console
