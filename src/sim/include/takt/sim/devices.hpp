// All simulated devices of one line.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "takt/model/project.hpp"
#include "takt/serve/server.hpp"
#include "takt/sim/device.hpp"

namespace takt::sim {

/// The devices of a line behind one responder, for a serve::SerialSlave or for serve::TcpConnections. `takt
/// serve` uses it to put the devices of a project on real lines. One owner, one thread: that of the engines.
class Devices final : public serve::Responder {
public:
    struct Options {
        bool moving = true;
        /// Turnaround of devices for which the project has none. On other than serial lines the device's
        /// round_trip is used instead.
        Duration unknown_turnaround = std::chrono::milliseconds(5);
        /// Every device answers at once (serial: after t3.5) and ignores the delays of the project; for real
        /// lines.
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
    /// The serving unit of that address. Its banks and extensions may be changed. Valid until a device is
    /// added. nullptr: none.
    [[nodiscard]] serve::Unit* unit(UnitId unit);
    /// The same of all devices.
    [[nodiscard]] std::span<serve::Unit> units() { return units_; }

    [[nodiscard]] bool serves(UnitId unit) const override { return server_.serves(unit); }
    void on_line_event(serve::LineEvent event) override { server_.on_line_event(event); }
    [[nodiscard]] serve::Answer handle(const serve::Context& context,
                                       const wire::RequestView& request) override;

private:
    void add(std::unique_ptr<Device> device);
    void tell_read(const serve::Context& context, const Device& device, const wire::RequestView& request,
                   Bytes answer);

    std::vector<std::unique_ptr<Device>> devices_;
    std::vector<serve::Unit> units_;
    std::vector<std::uint16_t> reported_;  // values on their way to the observer
    serve::Server server_{{}};
};

}  // namespace takt::sim
