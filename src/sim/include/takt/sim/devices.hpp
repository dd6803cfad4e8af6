// All simulated slaves of one line.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "takt/model/project.hpp"
#include "takt/serve/server.hpp"
#include "takt/sim/device.hpp"

namespace takt::sim {

/// The devices of a line behind one responder: what a serve::SerialSlave on the line's port, or the
/// serve::TcpConnections of its listener, answer from. With it `takt serve` is the devices of a project on
/// real lines. One owner, one thread: that of the engines.
class Devices final : public serve::Responder {
public:
    struct Options {
        bool moving = true;
        /// Of devices whose turnaround the project does not tell; on lines that are not serial each answers
        /// after its device's round_trip instead.
        Duration unknown_turnaround = std::chrono::milliseconds(5);
        /// Every device answers at once (serial: after t3.5), whatever the project tells: for real lines.
        bool prompt = false;
        const ValueSource* source = nullptr;  ///< see Device::set_source()
    };

    explicit Devices(const model::Line& line) : Devices(line, Options{}) {}
    Devices(const model::Line& line, const Options& options);

    /// One blank device.
    Devices(UnitId unit, Fill fill);

    [[nodiscard]] std::size_t size() const { return devices_.size(); }
    /// In the order of the project's line.
    [[nodiscard]] Device& operator[](std::size_t index) { return *devices_[index]; }
    [[nodiscard]] const Device& operator[](std::size_t index) const { return *devices_[index]; }
    /// Of every device; see Device::set_observer().
    void set_observer(DeviceObserver* observer);
    /// nullptr: there is none.
    [[nodiscard]] Device* find(UnitId unit);
    /// What answers for the device of that address; its banks may be laid out otherwise, and it may be
    /// extended. Valid as long as no device is added. nullptr: there is none.
    [[nodiscard]] serve::Unit* unit(UnitId unit);
    /// The same of all devices.
    [[nodiscard]] std::span<serve::Unit> units() { return units_; }

    [[nodiscard]] bool serves(UnitId unit) const override { return server_.serves(unit); }
    void heard(serve::LineEvent event) override { server_.heard(event); }
    [[nodiscard]] serve::Answer handle(const serve::Context& context, Bytes pdu) override;

private:
    void add(std::unique_ptr<Device> device);
    void tell_read(const serve::Context& context, const Device& device, Bytes request, Bytes answer);

    std::vector<std::unique_ptr<Device>> devices_;
    std::vector<serve::Unit> units_;
    std::vector<std::uint16_t> told_;  // values on their way to the observer
    serve::Server server_{{}};
};

}  // namespace takt::sim
