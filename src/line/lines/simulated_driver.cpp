#include <utility>

#include "takt/line/driver.hpp"
#include "takt/sim/simulated_line.hpp"

namespace takt::line {
namespace {

class SimulatedDriver final : public Driver {
public:
    SimulatedDriver(Loop& loop, sim::SimulatedLine& line, std::string name, const DriverOptions& options)
        : line_(line),
          name_(std::move(name)),
          options_(options),
          timer_(loop, [this](Instant t) { wake(t); }) {
        timer_.set(now());
    }

    void poke() override {
        if (up_) advance(now());
    }
    bool up() const override { return up_; }
    const std::string& name() const override { return name_; }
    DriverCounters counters() const override { return counters_; }

private:
    void wake(Instant t) {
        if (!std::exchange(up_, true)) {
            ++counters_.links;
            if (options_.on_link) options_.on_link(t, true, std::nullopt);
            line_.start(t);
        }
        advance(t);
    }

    void advance(Instant t) {
        line_.advance(t);
        timer_.set(line_.next_wakeup());
    }

    sim::SimulatedLine& line_;
    std::string name_;
    DriverOptions options_;
    DriverCounters counters_;
    bool up_ = false;
    Timer timer_;
};

}  // namespace

std::unique_ptr<Driver> run_simulated(Loop& loop, sim::SimulatedLine& line, std::string name,
                                      const DriverOptions& options) {
    return std::make_unique<SimulatedDriver>(loop, line, std::move(name), options);
}

}  // namespace takt::line
