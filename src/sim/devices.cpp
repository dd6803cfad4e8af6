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

serve::Unit* Devices::unit(UnitId unit) {
    const auto found = std::ranges::find(units_, unit, &serve::Unit::id);
    return found == units_.end() ? nullptr : &*found;
}

serve::Answer Devices::handle(const serve::Context& context, const wire::RequestView& request) {
    if (context.broadcast) return server_.handle(context, request);
    const serve::Unit* unit = server_.addressed(context.unit);
    const Device* device = unit ? find(unit->id) : nullptr;
    if (device && device->behaviour.dead) return {};
    serve::Answer answer = server_.handle(context, request);
    if (!device) return answer;
    answer.delay = device->behaviour.turnaround;
    if (device->observer() && answer.kind == serve::Answer::Kind::response)
        tell_read(context, *device, request, answer.pdu.span());
    return answer;
}

void Devices::set_observer(DeviceObserver* observer) {
    for (const auto& device : devices_) device->set_observer(observer);
}

// Notes the values of the answer itself. The banks may hold other values before or after it.
void Devices::tell_read(const serve::Context& context, const Device& device, const wire::RequestView& request,
                        Bytes answer) {
    const wire::Function function = request.function();
    if (!wire::properties(function).returns_items() || answer[0] != static_cast<std::uint8_t>(function))
        return;
    const wire::ItemAccess& read = request.accesses().front();
    const Bytes data = answer.subspan(2);
    reported_.clear();
    for (std::size_t i = 0; i < read.count; ++i)
        reported_.push_back(static_cast<std::uint16_t>(
            wire::is_bit_area(read.area) ? data[i / 8] >> (i % 8) & 1 : data[2 * i] << 8 | data[2 * i + 1]));
    device.observer()->on_read({context.time, device.address(), read.area, read.start, reported_, false});
}

}  // namespace takt::sim
