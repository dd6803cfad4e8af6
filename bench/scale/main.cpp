// Many TCP devices on one thread (issue: "TCP at scale"): the engine of `takt run` with one connection to
// each of 5 000 devices, one request a second each. The devices are real sockets on loopback addresses, in
// another process on the other core.
//
// Missed: releases that passed while an earlier one waited. Lateness: from the moment a request is due to the
// moment its bytes are handed to the socket. Processor: user and system time of the master's process. Memory:
// what the heap holds for a line with its device, its request and its connection, beside the project's
// description and the values; what the kernel holds for a socket is not in it. At the end all connections are
// reset at once, and the time until all are there again is taken.
//
// With --program the same project is run by `takt run`, its output to a file.
#include <fmt/format.h>
#include <malloc.h>
#include <sys/resource.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "field.hpp"
#include "program.hpp"
#include "takt/line/connect_gate.hpp"
#include "takt/line/descriptors.hpp"
#include "takt/line/driver.hpp"
#include "takt/plan/plan.hpp"
#include "takt/poll/master.hpp"
#include "takt/timing/latency_statistics.hpp"

namespace {

using namespace takt;
using namespace std::chrono_literals;

constexpr int kOwnProcessor = 0;
constexpr int kFieldProcessor = 1;
constexpr Duration kPeriod = 1s;
constexpr Duration kSettle = 3s;  // from the last connection to the measurement

struct Settings {
    std::size_t devices = 5000;
    Duration time = 60s;
    std::string program;
    bool json = false;
};

struct Measured {
    double connected_s = 0;
    double reconnected_s = 0;
    double time_s = 0;
    double processor = 0;  // part of one core
    std::uint64_t sent = 0;
    std::uint64_t answered = 0;
    std::uint64_t missed = 0;
    timing::LatencyStatistics lateness;
    double project_bytes = 0;  // a device, in each
    double value_bytes = 0;
    double poller_bytes = 0;
    double connection_bytes = 0;
};

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

model::Project make_project(const Settings& settings, std::uint16_t port) {
    model::Project project;
    project.lines.resize(settings.devices);
    for (std::size_t i = 0; i < settings.devices; ++i) {
        auto& line = project.lines[i];
        line.name = fmt::format("L{}", i);
        line.transport = model::Transport::tcp;
        line.framing = wire::Framing::tcp;
        line.port = bench::device_address(i);
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
    Clocked(Engine& engine, Measured& measured, const bool& measuring)
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
    Measured& measured_;
    const bool& measuring_;
    Instant epoch_;
};

class Bench {
public:
    Bench(const Settings& settings, bench::Field& field) : settings_(settings), field_(field) {}

    std::optional<Measured> run() {
        const auto before = heap();
        project_ = make_project(settings_, field_.port());
        plan_ = plan::make_plan(project_);
        const auto described = heap();
        {
            const value::Store values(poll::slot_infos(project_), 1);
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
            return static_cast<double>(bytes) / static_cast<double>(settings_.devices);
        };
        measured_.project_bytes = per_device(described - before);
        measured_.value_bytes = per_device(valued_);
        measured_.poller_bytes = per_device(mastered - begin - valued_ - kRing);
        measured_.connection_bytes = per_device(heap() - mastered - engines_.size() * sizeof(Clocked));
        measure();
        const Instant dropped = line::now();
        const auto connections = field_.connections() + settings_.devices;
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
        for (std::size_t i = 0; i < settings_.devices; ++i) {
            engines_.push_back(std::make_unique<Clocked>(master_->line(i), measured_, measuring_));
            options.must_reconnect = [this, i] { return master_->line(i).must_reconnect(); };
            drivers_.push_back(line::open_line(*loop_, project_.lines[i], *engines_.back(), options).value());
        }
    }

    // Looking at all of them after each event would be the scan this is about.
    bool wait_for_links() {
        for (int tries = 0; tries < 3000; ++tries) {
            loop_->run_until([] { return false; }, 10ms);
            if (std::ranges::all_of(drivers_, [](const auto& driver) { return driver->up(); })) return true;
        }
        return false;
    }

    [[nodiscard]] std::uint64_t count(auto what) const {
        std::uint64_t sum = 0;
        for (std::size_t i = 0; i < settings_.devices; ++i) sum += what(master_->line(i).request(0));
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
        loop_->run_until([] { return false; }, settings_.time);
        measuring_ = false;
        measured_.time_s = seconds(line::now() - start);
        measured_.processor = (processor_seconds(RUSAGE_SELF) - used) / measured_.time_s;
        measured_.missed = count(skipped) - missed_before;
        measured_.answered = count(answered) - answered_before;
    }

    const Settings& settings_;
    bench::Field& field_;
    model::Project project_;
    plan::Plan plan_;
    std::size_t valued_ = 0;
    Measured measured_;
    bool measuring_ = false;
    std::unique_ptr<line::Loop> loop_;
    std::unique_ptr<line::ConnectGate> gate_;
    std::unique_ptr<poll::Master> master_;
    std::vector<std::unique_ptr<Clocked>> engines_;
    std::vector<std::unique_ptr<line::Driver>> drivers_;
};

double ms(Duration duration) {
    return static_cast<double>(duration.count()) / 1e6;
}

void print(const Settings& settings, const Measured& m) {
    fmt::print("{} devices, one connection and one request a second each, for {:.0f} s\n", settings.devices,
               m.time_s);
    fmt::print("connected in {:.2f} s; all reset at once: again in {:.2f} s\n", m.connected_s,
               m.reconnected_s);
    fmt::print("requests {}, answered {}, missed periods {}\n", m.sent, m.answered, m.missed);
    fmt::print("lateness ms: p50 {:.3f}, p99 {:.3f}, max {:.3f}\n", ms(m.lateness.percentile(50)),
               ms(m.lateness.percentile(99)), ms(m.lateness.max()));
    fmt::print("processor: {:.1f} % of one core, {:.1f} us a request\n", m.processor * 100,
               m.processor * m.time_s / static_cast<double>(m.sent) * 1e6);
    fmt::print(
        "memory a device: {:.0f} bytes, {:.0f} of them for the connection; beside it the project's {:.0f} "
        "and "
        "the value's {:.0f}\n",
        m.poller_bytes + m.connection_bytes, m.connection_bytes, m.project_bytes, m.value_bytes);
}

void print(const bench::ProgramMeasured& m) {
    fmt::print(
        "takt run: {:.1f} s, {:.1f} % of one core, start included; requests {}, answered {}, missed {}, "
        "overruns {}; peak {} KiB\n",
        m.seconds, m.processor * 100, m.sent, m.answered, m.missed, m.overruns, m.peak_kib);
}

nlohmann::json to_json(const Settings& settings, const Measured& m) {
    return {{"devices", settings.devices},
            {"seconds", m.time_s},
            {"connected_s", m.connected_s},
            {"reconnected_s", m.reconnected_s},
            {"sent", m.sent},
            {"answered", m.answered},
            {"missed", m.missed},
            {"lateness_ms",
             {{"p50", ms(m.lateness.percentile(50))},
              {"p99", ms(m.lateness.percentile(99))},
              {"max", ms(m.lateness.max())}}},
            {"processor", m.processor},
            {"bytes",
             {{"device", m.poller_bytes + m.connection_bytes},
              {"connection", m.connection_bytes},
              {"project", m.project_bytes},
              {"value", m.value_bytes}}}};
}

nlohmann::json to_json(const bench::ProgramMeasured& m) {
    return {{"seconds", m.seconds},   {"processor", m.processor}, {"sent", m.sent},
            {"answered", m.answered}, {"missed", m.missed},       {"overruns", m.overruns},
            {"peak_kib", m.peak_kib}};
}

std::optional<Settings> parse(int count, char** arguments) {
    Settings settings;
    for (int i = 1; i < count; ++i) {
        const std::string_view argument = arguments[i];
        const bool more = i + 1 < count;
        if (argument == "--json")
            settings.json = true;
        else if (argument == "--devices" && more)
            settings.devices = std::clamp<std::size_t>(std::strtoul(arguments[++i], nullptr, 10), 1, 60000);
        else if (argument == "--seconds" && more)
            settings.time =
                std::clamp<long>(std::strtol(arguments[++i], nullptr, 10), 1, 86400) * Duration(1s);
        else if (argument == "--program" && more)
            settings.program = arguments[++i];
        else
            return std::nullopt;
    }
    return settings;
}

}  // namespace

int main(int count, char** arguments) {
    const auto settings = parse(count, arguments);
    if (!settings) {
        std::fprintf(stderr,
                     "usage: takt_bench_scale [--devices N] [--seconds S] [--program TAKT] [--json]\n");
        return 2;
    }
    bench::Field field(settings->devices, kFieldProcessor);
    const auto allowed = line::raise_descriptor_limit();
    if (!field.ok() || allowed < settings->devices + 32) {
        std::fprintf(stderr, "%zu devices need %zu descriptors in the field's process; %zu are allowed\n",
                     settings->devices, 2 * settings->devices + 16, allowed);
        return 1;
    }
    if (!settings->program.empty()) {
        const auto measured = bench::run_program(settings->program, settings->devices, settings->time,
                                                 field.port(), kOwnProcessor);
        if (!measured) {
            std::fprintf(stderr, "%s: %s\n", settings->program.c_str(), measured.error().c_str());
            return 1;
        }
        if (settings->json)
            fmt::print("{}\n", nlohmann::json{{"program", to_json(*measured)}}.dump());
        else
            print(*measured);
        return measured->missed == 0 ? 0 : 1;
    }
    bench::pin_to_processor(kOwnProcessor);
    Bench bench(*settings, field);
    const auto measured = bench.run();
    if (!measured) {
        std::fprintf(stderr, "not all devices could be connected to\n");
        return 1;
    }
    if (settings->json)
        fmt::print("{}\n", nlohmann::json{{"scale", to_json(*settings, *measured)}}.dump());
    else
        print(*settings, *measured);
    return measured->missed == 0 ? 0 : 1;
}
