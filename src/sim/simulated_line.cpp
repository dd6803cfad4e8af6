#include "takt/sim/simulated_line.hpp"

#include "byte_stream.hpp"
#include "serial_bus.hpp"

namespace takt::sim {

SimulatedLine::SimulatedLine(const model::Line& line, Engine& master, const Options& options)
    : devices_(line, options.devices) {
    devices_.set_observer(options.device_observer);
    serve::Responder* responder = &devices_;
    if (options.faults) {
        faults_ = options.faults(line, devices_);
        responder = faults_.get();
    }
    if (line.is_serial())
        make_bus(line, master, *responder, options);
    else
        make_stream(line, master, *responder, options);
    wire_->set_disturber(faults_.get());
}

SimulatedLine::~SimulatedLine() = default;

void SimulatedLine::make_bus(const model::Line& line, Engine& master, serve::Responder& responder,
                             const Options& options) {
    auto bus = std::make_unique<SerialBus>(line.format, SerialBus::Options{options.chunk});
    if (faults_) faults_->work_on(*bus);
    // A slow device does not receive while it works, so its answers are late as those of a real one.
    const serve::SerialConfig config{.framing = line.framing,
                                     .format = line.format,
                                     .finish_first = true,
                                     .peer = std::string_view(line.name)};
    slave_ = std::make_unique<serve::SerialSlave>(config, responder);
    bus->attach(master, options.receives_echo);
    bus->attach(*slave_, false, false);  // the adapter is the master's
    wire_ = std::move(bus);
}

void SimulatedLine::make_stream(const model::Line& line, Engine& master, serve::Responder& responder,
                                const Options& options) {
    const serve::TcpConfig config{
        .framing = line.framing, .idle_deadline = {}, .peer = std::string_view(line.name)};
    connection_ = std::make_unique<serve::TcpConnection>(config, responder);
    auto stream = std::make_unique<ByteStream>(master, *connection_,
                                               ByteStream::Options{.must_reconnect = options.must_reconnect});
    if (faults_) faults_->work_on(*stream);
    wire_ = std::move(stream);
}

void SimulatedLine::start(Instant t) {
    if (faults_) faults_->run(t, true);
    wire_->set_link(t, true);
}

void SimulatedLine::stop(Instant t) {
    if (faults_) faults_->run(t, false);
    wire_->set_link(t, false);
}

const serve::Counters& SimulatedLine::counters() const {
    return slave_ ? slave_->counters() : connection_->counters();
}

}  // namespace takt::sim
