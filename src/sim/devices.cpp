#include "takt/sim/devices.hpp"

#include <algorithm>

namespace takt::sim {

Devices::Devices(const model::Line& line, const Options& options) {
    for (const model::Device& device : line.devices) {
        auto simulated = std::make_unique<Device>(device, options.moving);
        if (!options.prompt)
            simulated->behaviour.turnaround =
                line.is_serial() ? device.turnaround.value_or(options.unknown_turnaround) : device.round_trip;
        simulated->set_source(options.source);
        add(std::move(simulated));
    }
}

Devices::Devices(UnitId unit, Fill fill) {
    add(std::make_unique<Device>(unit, fill));
}

void Devices::add(std::unique_ptr<Device> device) {
    units_.push_back(device->unit());
    devices_.push_back(std::move(device));
    server_ = serve::Server(units_);
}

Device* Devices::find(UnitId unit) {
    const auto found = std::ranges::find(devices_, unit, &Device::address);
    return found == devices_.end() ? nullptr : found->get();
}

serve::Answer Devices::handle(const serve::Context& context, Bytes pdu) {
    if (context.broadcast) return server_.handle(context, pdu);
    const serve::Unit* unit = server_.addressed(context.unit);
    const Device* device = unit ? find(unit->id) : nullptr;
    if (device && device->behaviour.dead) return {};
    serve::Answer answer = server_.handle(context, pdu);
    if (device) answer.delay = device->behaviour.turnaround;
    return answer;
}

}  // namespace takt::sim
