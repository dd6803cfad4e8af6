// Opens the port, runs the pump and the direction switch, and reopens the port after an error with a
// back-off.
#include <utility>

#include "loop/pump.hpp"
#include "network/backoff.hpp"
#include "serial/direction_switch.hpp"
#include "takt/line/driver.hpp"

namespace takt::line {
namespace {

class SerialDriver final : public Driver {
public:
    SerialDriver(Loop& loop, const SerialSettings& settings, Engine& engine, const DriverOptions& options)
        : loop_(loop),
          settings_(settings),
          engine_(engine),
          options_(options),
          direction_(settings.format),
          reopen_(loop, [this](Instant) { try_open(); }),
          receive_(loop, [this](Instant t) { try_receive(t); }) {}

    // The first link-up is reported from the loop, never from the constructor: the caller has no driver yet.
    void begin(std::unique_ptr<SerialPort> port) {
        port_ = std::move(port);
        reopen_.set(now());
    }

    void poke() override {
        if (pump_) pump_->poke();
    }
    bool up() const override { return pump_ != nullptr; }
    const std::string& name() const override { return settings_.path; }

    DriverCounters counters() const override {
        DriverCounters all = counters_;
        if (pump_) add(all, *pump_, *port_);
        return all;
    }

private:
    static void add(DriverCounters& sum, const Pump& pump, const SerialPort& port) {
        sum.bytes_read += pump.counters().bytes_read;
        sum.bytes_written += pump.counters().bytes_written;
        sum.serial.faulty_characters += port.counters().faulty_characters;
        sum.serial.breaks += port.counters().breaks;
    }

    void try_open() {
        if (!port_) {
            auto port = SerialPort::open(settings_);
            if (!port) return failed(port.error());
            port_ = std::move(*port);
        }
        PumpOptions pumping;
        pumping.punctual = true;
        pumping.finished = options_.must_reconnect;
        if (port_->rs485() == model::Rs485::rts)
            pumping.written = [this](Instant t, std::size_t bytes) { sent(t, bytes); };
        pump_ = std::make_unique<Pump>(loop_, *port_, engine_, std::move(pumping),
                                       [this](Instant t, const std::optional<Error>& why) { lost(t, why); });
        ++counters_.links;
        notify_latency(port_->latency());
        notify(now(), true, std::nullopt);
        pump_->start();
    }

    void failed(const Error& why) {
        ++counters_.failed_attempts;
        const Instant t = now();
        reopen_.set(t + backoff_.next());
        notify(t, false, why);
    }

    void lost(Instant t, const std::optional<Error>& why) {
        if (pump_->counters().bytes_read > 0) backoff_.reset();
        add(counters_, *pump_, *port_);
        pump_.reset();
        port_.reset();
        receive_.set(kNever);
        direction_ = DirectionSwitch(settings_.format);
        reopen_.set(t + backoff_.next());
        notify(t, false, why);
    }

    void sent(Instant t, std::size_t bytes) {
        direction_.sent(t, bytes);
        receive_.set(direction_.next_check());
    }

    void try_receive(Instant t) {
        if (direction_.release(t, port_->transmitter_empty())) port_->set_sending(false);
        receive_.set(direction_.next_check());
    }

    void notify(Instant t, bool up, const std::optional<Error>& why) {
        if (options_.on_link) options_.on_link(t, up, why);
    }

    void notify_latency(const std::optional<SerialLatency>& latency) {
        const bool is_news = latency != std::exchange(latency_, latency);
        if (latency && is_news && options_.on_latency) options_.on_latency(*latency);
    }

    Loop& loop_;
    SerialSettings settings_;
    Engine& engine_;
    DriverOptions options_;
    DirectionSwitch direction_;
    Backoff backoff_;
    DriverCounters counters_;
    std::optional<SerialLatency> latency_;  // of the last open port
    std::unique_ptr<SerialPort> port_;
    std::unique_ptr<Pump> pump_;
    Timer reopen_;
    Timer receive_;
};

// Errors that a later attempt cannot change.
bool is_final(const Error& error) {
    return error.code == Code::unsupported || error.code == Code::out_of_range;
}

}  // namespace

Result<std::unique_ptr<Driver>> open_serial(Loop& loop, const SerialSettings& settings, Engine& engine,
                                            const DriverOptions& options) {
    auto port = SerialPort::open(settings);
    if (!port && (!options.wait_for_port || is_final(port.error()))) return std::unexpected(port.error());
    auto driver = std::make_unique<SerialDriver>(loop, settings, engine, options);
    driver->begin(port ? std::move(*port) : nullptr);
    return driver;
}

}  // namespace takt::line
