#include "takt/sim/simulated_line.hpp"

#include "takt/sim/byte_stream.hpp"
#include "takt/sim/serial_bus.hpp"

namespace takt::sim {

SimulatedLine::SimulatedLine(const model::Line& line, Engine& master, const Options& options)
    : devices_(line, options.devices) {
    devices_.set_observer(options.device_observer);
    if (options.faults) faults_.emplace(line, devices_, *options.faults, options.fault_observer);
    serve::Responder& responder = faults_ ? static_cast<serve::Responder&>(*faults_) : devices_;
    if (line.is_serial()) {
        // A slow device does not hear further requests while it works, and so answers late as a real one
        // does.
        const serve::SerialConfig config{.framing = line.framing,
                                         .format = line.format,
                                         .finish_first = true,
                                         .peer = std::string_view(line.name)};
        slave_ = std::make_unique<serve::SerialSlave>(config, responder);
        auto bus = std::make_unique<SerialBus>(line.format, SerialBus::Options{options.chunk});
        bus->attach(master, options.hears_echo);
        bus->attach(*slave_);
        wire_ = std::move(bus);
        return;
    }
    const serve::TcpConfig config{
        .framing = line.framing, .idle_deadline = {}, .peer = std::string_view(line.name)};
    connection_ = std::make_unique<serve::TcpConnection>(config, responder);
    wire_ = std::make_unique<ByteStream>(master, *connection_, ByteStream::Options{});
}

const FaultCounts& SimulatedLine::faults() const {
    static constexpr FaultCounts kNone;
    return faults_ ? faults_->counts() : kNone;
}

const serve::Counters& SimulatedLine::counters() const {
    return slave_ ? slave_->counters() : connection_->counters();
}

}  // namespace takt::sim
