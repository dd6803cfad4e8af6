#include "measure.hpp"

#include <fmt/format.h>
#include <malloc.h>
#include <sys/resource.h>

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "takt/line/connect_gate.hpp"
#include "takt/line/driver.hpp"
#include "takt/plan/plan.hpp"
#include "takt/poll/master.hpp"

namespace takt::bench {
namespace {

using namespace std::chrono_literals;

constexpr Duration kPeriod = 1s;
constexpr Duration kSettle = 3s;  // from the last connection to the measurement

double seconds(Duration duration) {
    return static_cast<double>(duration.count()) / 1e9;
}

double processor_seconds(int who) {
    rusage usage{};
    ::getrusage(who, &usage);
    const auto all = [](const timeval& a, const timeval& b) {
        return static_cast<double>(a.tv_sec + b.tv_sec) + static_cast<double>(a.tv_usec + b.tv_usec) / 1e6;
    };
    return all(usage.ru_utime, usage.ru_stime);
}

std::size_t heap() {
    const auto info = ::mallinfo2();
    return info.uordblks + info.hblkhd;
}

model::Project make_project(const Scale& scale, std::uint16_t port) {
    model::Project project;
    project.lines.resize(scale.devices);
    for (std::size_t i = 0; i < scale.devices; ++i) {
        auto& line = project.lines[i];
        line.name = fmt::format("L{}", i);
        line.transport = model::Transport::tcp;
        line.framing = wire::Framing::tcp;
        line.port = device_address(i);
        line.tcp_port = port;
        auto& device = line.devices.emplace_back();
        device.name = fmt::format("D{}", i);
        device.poll_period = kPeriod;
        device.response_timeout = 500ms;
        auto& variable = device.variables.emplace_back();
        variable.name = fmt::format("V{}", i);
        variable.read = wire::Function::read_holding_registers;
        variable.period = kPeriod;
    }
    return project;
}

/// Between a driver and its poller: when requests are due, and when they go.
class Clocked final : public Engine {
public:
    Clocked(Engine& engine, ScaleMeasured& measured, const bool& measuring)
        : engine_(engine), measured_(measured), measuring_(measuring) {}

    void on_link(Instant t, bool up) override {
        epoch_ = t;
        engine_.on_link(t, up);
    }
    void on_bytes(Instant t, Bytes bytes) override { engine_.on_bytes(t, bytes); }
    void on_tick(Instant t) override { engine_.on_tick(t); }
    Bytes transmit(Instant t) override {
        const Bytes bytes = engine_.transmit(t);
        if (!bytes.empty() && measuring_) {
            ++measured_.sent;
            measured_.lateness.record((t - epoch_) % kPeriod);
        }
        return bytes;
    }
    Instant next_wakeup() const override { return engine_.next_wakeup(); }

private:
    Engine& engine_;
    ScaleMeasured& measured_;
    const bool& measuring_;
    Instant epoch_;
};

class Bench {
public:
    Bench(const Scale& scale, Field& field) : scale_(scale), field_(field) {}

    std::optional<ScaleMeasured> run() {
        const auto before = heap();
        project_ = make_project(scale_, field_.port());
        plan_ = plan::make_plan(project_);
        const auto described = heap();
        {
            const value::Store values(value::slot_infos(project_), 1);
            valued_ = heap() - described;
        }
        const auto begin = heap();
        loop_ = std::move(line::Loop::create()).value();
        gate_ = std::make_unique<line::ConnectGate>(*loop_);
        master_ = std::make_unique<poll::Master>(project_, plan_);
        const auto mastered = heap();
        connect();
        const Instant start = line::now();
        if (!wait_for_links()) return std::nullopt;
        measured_.connected_s = seconds(line::now() - start);
        loop_->run_until([] { return false; }, kSettle);
        constexpr std::size_t kRing = value::Store::kDefaultEvents * sizeof(value::Event);
        const auto per_device = [&](std::size_t bytes) {
            return static_cast<double>(bytes) / static_cast<double>(scale_.devices);
        };
        measured_.project_bytes = per_device(described - before);
        measured_.value_bytes = per_device(valued_);
        measured_.poller_bytes = per_device(mastered - begin - valued_ - kRing);
        measured_.connection_bytes = per_device(heap() - mastered - engines_.size() * sizeof(Clocked));
        measure();
        const Instant dropped = line::now();
        const auto connections = field_.connections() + scale_.devices;
        field_.drop_all();
        loop_->run_until([&] { return field_.connections() >= connections; }, 30s);
        if (!wait_for_links()) return std::nullopt;
        measured_.reconnected_s = seconds(line::now() - dropped);
        return measured_;
    }

private:
    void connect() {
        line::DriverOptions options;
        options.gate = gate_.get();
        for (std::size_t i = 0; i < scale_.devices; ++i) {
            engines_.push_back(std::make_unique<Clocked>(master_->line(i), measured_, measuring_));
            options.must_reconnect = [this, i] { return master_->line(i).must_reconnect(); };
            drivers_.push_back(line::open_line(*loop_, project_.lines[i], *engines_.back(), options).value());
        }
    }

    // Examining all lines after each event would be the linear scan that this design avoids.
    bool wait_for_links() {
        for (int tries = 0; tries < 3000; ++tries) {
            loop_->run_until([] { return false; }, 10ms);
            if (std::ranges::all_of(drivers_, [](const auto& driver) { return driver->up(); })) return true;
        }
        return false;
    }

    [[nodiscard]] std::uint64_t count(auto what) const {
        std::uint64_t sum = 0;
        for (std::size_t i = 0; i < scale_.devices; ++i) sum += what(master_->line(i).request(0));
        return sum;
    }

    void measure() {
        const auto skipped = [](const poll::RequestStatistics& request) { return request.skipped; };
        const auto answered = [](const poll::RequestStatistics& request) {
            return request.counters.answered;
        };
        const auto missed_before = count(skipped);
        const auto answered_before = count(answered);
        const double used = processor_seconds(RUSAGE_SELF);
        const Instant start = line::now();
        measuring_ = true;
        loop_->run_until([] { return false; }, scale_.time);
        measuring_ = false;
        measured_.time_s = seconds(line::now() - start);
        measured_.processor = (processor_seconds(RUSAGE_SELF) - used) / measured_.time_s;
        measured_.missed = count(skipped) - missed_before;
        measured_.answered = count(answered) - answered_before;
    }

    const Scale& scale_;
    Field& field_;
    model::Project project_;
    plan::Plan plan_;
    std::size_t valued_ = 0;
    ScaleMeasured measured_;
    bool measuring_ = false;
    std::unique_ptr<line::Loop> loop_;
    std::unique_ptr<line::ConnectGate> gate_;
    std::unique_ptr<poll::Master> master_;
    std::vector<std::unique_ptr<Clocked>> engines_;
    std::vector<std::unique_ptr<line::Driver>> drivers_;
};

}  // namespace

std::optional<ScaleMeasured> measure_scale(const Scale& scale, Field& field) {
    return Bench(scale, field).run();
}

}  // namespace takt::bench
