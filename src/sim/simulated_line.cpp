#include "takt/sim/simulated_line.hpp"

#include "byte_stream.hpp"
#include "serial_bus.hpp"
#include "serial_faults.hpp"
#include "stream_faults.hpp"

namespace takt::sim {

SimulatedLine::SimulatedLine(const model::Line& line, Engine& master, const Options& options)
    : devices_(line, options.devices) {
    devices_.set_observer(options.device_observer);
    if (line.is_serial())
        make_bus(line, master, options);
    else
        make_stream(line, master, options);
    wire_->set_disturber(faults_.get());
}

SimulatedLine::~SimulatedLine() = default;

void SimulatedLine::make_bus(const model::Line& line, Engine& master, const Options& options) {
    auto bus = std::make_unique<SerialBus>(line.format, SerialBus::Options{options.chunk});
    serve::Responder* responder = &devices_;
    if (options.faults) {
        auto faults = std::make_unique<SerialFaults>(line, devices_, *options.faults, options.fault_observer);
        faults->work_on(*bus);
        responder = faults.get();
        faults_ = std::move(faults);
    }
    // A slow device does not receive while it works, so its answers are late as those of a real one.
    const serve::SerialConfig config{.framing = line.framing,
                                     .format = line.format,
                                     .finish_first = true,
                                     .peer = std::string_view(line.name)};
    slave_ = std::make_unique<serve::SerialSlave>(config, *responder);
    bus->attach(master, options.receives_echo);
    bus->attach(*slave_, false, false);  // the adapter is the master's
    wire_ = std::move(bus);
}

void SimulatedLine::make_stream(const model::Line& line, Engine& master, const Options& options) {
    const serve::TcpConfig config{
        .framing = line.framing, .idle_deadline = {}, .peer = std::string_view(line.name)};
    serve::Responder* responder = &devices_;
    std::unique_ptr<StreamFaults> faults;
    if (options.faults || options.must_reconnect) {
        faults = std::make_unique<StreamFaults>(line, devices_, options.faults.value_or(FaultPlan{}),
                                                options.fault_observer);
        responder = faults.get();
    }
    connection_ = std::make_unique<serve::TcpConnection>(config, *responder);
    auto stream = std::make_unique<ByteStream>(master, *connection_,
                                               ByteStream::Options{.must_reconnect = options.must_reconnect});
    if (faults) faults->work_on(*stream);
    faults_ = std::move(faults);
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

const FaultCounts& SimulatedLine::faults() const {
    static constexpr FaultCounts kNone;
    return faults_ ? faults_->counts() : kNone;
}

const serve::Counters& SimulatedLine::counters() const {
    return slave_ ? slave_->counters() : connection_->counters();
}

}  // namespace takt::sim
