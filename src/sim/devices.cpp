#include "takt/sim/devices.hpp"

#include <algorithm>
#include <array>

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

serve::Answer Devices::handle(const serve::Context& context, Bytes pdu) {
    if (context.broadcast) return server_.handle(context, pdu);
    const serve::Unit* unit = server_.addressed(context.unit);
    const Device* device = unit ? find(unit->id) : nullptr;
    if (device && device->behaviour.dead) return {};
    serve::Answer answer = server_.handle(context, pdu);
    if (!device) return answer;
    answer.delay = device->behaviour.turnaround;
    if (device->observer() && answer.kind == serve::Answer::Kind::response)
        tell_read(context, *device, pdu, answer.pdu.span());
    return answer;
}

void Devices::set_observer(DeviceObserver* observer) {
    for (const auto& device : devices_) device->set_observer(observer);
}

// Notes the values of the answer itself. The banks may hold other values before or after it.
void Devices::tell_read(const serve::Context& context, const Device& device, Bytes request, Bytes answer) {
    const auto word = [](Bytes bytes, std::size_t at) {
        return static_cast<std::uint16_t>(bytes[at] << 8 | bytes[at + 1]);
    };
    constexpr std::uint8_t kReadWrite = 0x17;
    const std::uint8_t function = request[0];
    if (!wire::properties(wire::Function{function}).returns_items || answer[0] != function) return;
    constexpr std::array kAreas{wire::Area::coil, wire::Area::discrete_input, wire::Area::holding_register,
                                wire::Area::input_register};
    const wire::Area area =
        function == kReadWrite ? wire::Area::holding_register : kAreas[std::size_t{function} - 1];
    const std::uint16_t quantity = word(request, 3);
    const Bytes data = answer.subspan(2);
    reported_.clear();
    for (std::size_t i = 0; i < quantity; ++i)
        reported_.push_back(wire::is_bit_area(area) ? static_cast<std::uint16_t>(data[i / 8] >> (i % 8) & 1)
                                                    : word(data, 2 * i));
    device.observer()->on_read({context.time, device.address(), area, word(request, 1), reported_, false});
}

}  // namespace takt::sim
