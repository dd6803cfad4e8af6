#include "bus.hpp"

#include <algorithm>
#include <utility>

#include "sim/faults/line_faults.hpp"

namespace takt::gatewaysim {

using namespace std::chrono_literals;

/// Between a line and the program that runs, if one does.
class Bus::Port final : public Engine, public sim::DeviceObserver {
public:
    Port(Bus& bus, std::size_t line) : bus_(bus), line_(line) {}

    void on_link(Instant t, bool up) override {
        if (bus_.owner_) bus_.owner_->on_link(t, line_, up);
    }
    void on_bytes(Instant t, Bytes bytes) override {
        ++bus_.frames_;
        if (bus_.owner_) bus_.owner_->engine(line_).on_bytes(t, bytes);
    }
    void on_tick(Instant t) override {
        if (bus_.owner_) bus_.owner_->engine(line_).on_tick(t);
    }
    Bytes transmit(Instant t) override {
        if (!bus_.owner_) return {};
        const Bytes bytes = bus_.owner_->engine(line_).transmit(t);
        if (!bytes.empty()) sent_at_ = t;
        return bytes;
    }
    [[nodiscard]] Instant next_wakeup() const override {
        return bus_.owner_ ? bus_.owner_->engine(line_).next_wakeup() : kNever;
    }

    void on_read(const sim::DeviceItems& /*items*/) override {}
    // Two registers, the low one first.
    void on_write(const sim::DeviceItems& items) override {
        for (std::size_t i = 0; i + 1 < items.values.size(); i += 2)
            bus_.written_(items.values[i] | std::uint32_t{items.values[i + 1]} << 16U, sent_at_);
    }
    void on_change(const sim::DeviceItems& /*items*/) override {}

private:
    Bus& bus_;
    std::size_t line_;
    Instant sent_at_{};
};

Bus::Bus(const Scenario& scenario, Written written)
    : field_(scenario.seed, scenario.fast_step), written_(std::move(written)) {
    const auto lines = scenario.configuration->project().lines.size();
    for (std::size_t i = 0; i < lines; ++i) add_line(scenario, i);
}

Bus::~Bus() = default;

void Bus::add_line(const Scenario& scenario, std::size_t index) {
    const auto& line = scenario.configuration->project().lines[index];
    ports_.push_back(std::make_unique<Port>(*this, index));
    sim::FaultPlan faults;
    faults.seed = sim::Random(scenario.seed).fork(0xFA + index).next();
    faults.rates = scenario.line_faults;
    faults.merciless = false;
    faults.dead = {1s, 10s};
    faults.unplugged = {100ms, 8s};
    faults.quiet_from = scenario.quiet_from;
    sim::SimulatedLine::Options options;
    options.devices.source = &field_;
    options.faults = sim::faults_of(faults);
    options.device_observer = ports_.back().get();
    options.must_reconnect = [this, index] { return owner_ != nullptr && owner_->must_reconnect(index); };
    lines_.push_back(std::make_unique<sim::SimulatedLine>(line, *ports_.back(), options));
}

void Bus::start(Instant t, LineOwner& owner) {
    owner_ = &owner;
    for (auto& line : lines_) line->start(t);
}

void Bus::stop(Instant t) {
    owner_ = nullptr;
    for (auto& line : lines_) line->stop(t);
}

Instant Bus::next_wakeup() const {
    Instant next = kNever;
    for (const auto& line : lines_) next = std::min(next, line->next_wakeup());
    return next;
}

void Bus::advance(Instant t) {
    for (auto& line : lines_)
        if (line->next_wakeup() <= t) line->advance(t);
}

void Bus::poke(std::size_t line, Instant t) {
    lines_[line]->advance(t);
}

}  // namespace takt::gatewaysim
