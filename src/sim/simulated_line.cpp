#include "takt/sim/simulated_line.hpp"

#include "takt/sim/byte_stream.hpp"
#include "takt/sim/serial_bus.hpp"

namespace takt::sim {

SimulatedLine::SimulatedLine(const model::Line& line, Engine& master, const Options& options)
    : devices_(line, options.devices) {
    if (line.is_serial()) {
        // A slow device does not hear further requests while it works, and so answers late as a real one
        // does.
        const serve::SerialConfig config{.framing = line.framing,
                                         .format = line.format,
                                         .finish_first = true,
                                         .peer = std::string_view(line.name)};
        slave_ = std::make_unique<serve::SerialSlave>(config, devices_);
        auto bus = std::make_unique<SerialBus>(line.format, SerialBus::Options{options.chunk});
        bus->attach(master);
        bus->attach(*slave_);
        wire_ = std::move(bus);
        return;
    }
    const serve::TcpConfig config{
        .framing = line.framing, .idle_deadline = {}, .peer = std::string_view(line.name)};
    connection_ = std::make_unique<serve::TcpConnection>(config, devices_);
    wire_ = std::make_unique<ByteStream>(master, *connection_, ByteStream::Options{});
}

const serve::Counters& SimulatedLine::counters() const {
    return slave_ ? slave_->counters() : connection_->counters();
}

}  // namespace takt::sim
