// The same device polled by several masters (issue: "How fast"): a libmodbus program that reads variable by
// variable, one that reads the best blocks a person would write down, and takt with the plan it makes itself.
// On a serial line whose characters take their time (see line.hpp) at 19200 and 115200 bit/s, and over TCP.
// libmodbus does not keep the silence of t3.5 before a request; so on serial lines it polls its blocks once
// more, waiting for that silence as exactly as takt does. That is the row to compare with.
//
// A round: every variable once. Idle: what the line is silent beyond t3.5, from the end of an answer to the
// next request; the turnaround is the device's and not in it. Below zero: the master does not keep t3.5.
// Processor: user and system time of the master, a request.
#include <fmt/format.h>
#include <modbus/modbus.h>
#include <sched.h>
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "line.hpp"
#include "takt/line/driver.hpp"
#include "takt/line/real_line.hpp"
#include "takt/plan/plan.hpp"
#include "takt/poll/master.hpp"

namespace {

using namespace takt;
using namespace std::chrono_literals;

constexpr std::size_t kMasterProcessor = 0;
constexpr int kDeviceProcessor = 1;

struct Block {
    wire::Function function;
    int start;
    int count;
};
constexpr auto kHolding = wire::Function::read_holding_registers;
constexpr auto kInput = wire::Function::read_input_registers;

/// A meter as there are many: values side by side, floats behind a gap, a few registers far away, and inputs.
std::vector<Block> variables() {
    std::vector<Block> all;
    for (int i = 0; i < 10; ++i) all.push_back({kHolding, i, 1});
    for (int i = 0; i < 6; ++i) all.push_back({kHolding, 16 + 2 * i, 2});
    for (int i = 0; i < 4; ++i) all.push_back({kHolding, 400 + i, 1});
    for (int i = 0; i < 4; ++i) all.push_back({kInput, i, 1});
    return all;
}

/// As takt waits: asleep, and spinning at the end (docs/decisions/0005).
void wait_until(Instant t) {
    constexpr Duration kSpin = 80us;
    const auto wake = (t - kSpin).time_since_epoch();
    const timespec at{static_cast<time_t>(wake / 1s), static_cast<long>((wake % 1s).count())};
    ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr);
    while (line::now() < t) {}
}

/// Over the gap of six registers too: twelve characters are less than a request.
std::vector<Block> best_blocks() {
    return {{kHolding, 0, 28}, {kHolding, 400, 4}, {kInput, 0, 4}};
}

struct Row {
    std::string line;
    std::string master;
    double requests_a_round = 0;
    double rounds_a_second = 0;
    double processor_us = 0;  // a request
    std::uint64_t requests = 0;
    std::uint64_t disturbed = 0;
    std::vector<Duration> idle;
    bool right = true;  // all answers were as expected

    [[nodiscard]] double idle_ms(double quantile) const {
        if (idle.empty()) return 0;
        const auto last = static_cast<double>(idle.size() - 1);
        return static_cast<double>(idle[static_cast<std::size_t>(quantile * last + 0.5)].count()) / 1e6;
    }
};

double processor_seconds() {
    rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    return static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
           static_cast<double>(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec) / 1e6;
}

/// Times one master at work on a far end.
class Measurement {
public:
    explicit Measurement(const bench::FarEnd& far)
        : far_(far), requests_(far.requests()), processor_(processor_seconds()), start_(line::now()) {}

    void finish(Row& row, double requests_a_round) const {
        const double time = static_cast<double>((line::now() - start_).count()) / 1e9;
        row.requests = far_.requests() - requests_;
        const auto requests = static_cast<double>(row.requests);
        row.requests_a_round = requests_a_round;
        row.rounds_a_second = requests / requests_a_round / time;
        row.processor_us = (processor_seconds() - processor_) / requests * 1e6;
        row.disturbed = far_.disturbed();
        row.idle = far_.idle();
    }

private:
    const bench::FarEnd& far_;
    std::uint64_t requests_;
    double processor_;
    Instant start_;
};

/// @param silence  kept before each request
void poll_with_libmodbus(modbus_t* bus, const std::vector<Block>& blocks, Duration silence, Duration time,
                         const bench::FarEnd& far, Row& row) {
    ::modbus_set_slave(bus, 1);
    if (::modbus_connect(bus) != 0) {
        row.right = false;
        return;
    }
    const Measurement measurement(far);
    Instant answered = line::now();
    const Instant end = answered + time;
    std::uint16_t registers[125];
    while (line::now() < end)
        for (const auto& block : blocks) {
            if (silence > Duration::zero()) wait_until(answered + silence);
            const int got = block.function == kInput
                                ? ::modbus_read_input_registers(bus, block.start, block.count, registers)
                                : ::modbus_read_registers(bus, block.start, block.count, registers);
            answered = line::now();
            row.right = row.right && got == block.count && registers[0] == block.start;
        }
    measurement.finish(row, static_cast<double>(blocks.size()));
    ::modbus_close(bus);
}

model::Project make_project(const model::Line& line, int in_flight) {
    model::Project project;
    project.lines.push_back(line);
    auto& device = project.lines[0].devices.emplace_back();
    device.name = "Meter";
    device.group_requests = true;
    device.registers_per_request = 125;
    device.strategy = model::Strategy::optimal;
    device.gaps = model::Gaps::always;
    device.poll_period = Duration::zero();
    device.response_timeout = 1s;
    device.in_flight = static_cast<std::uint16_t>(in_flight);
    for (const auto& block : variables()) {
        auto& variable = device.variables.emplace_back();
        variable.name = fmt::format("{}{}", block.function == kInput ? 'i' : 'h', block.start);
        variable.type = block.count == 2 ? DataType::uint32 : DataType::uint16;
        variable.area = block.function == kInput ? wire::Area::input_register : wire::Area::holding_register;
        variable.register_number = static_cast<std::uint16_t>(block.start);
        variable.registers = static_cast<std::uint16_t>(block.count);
        variable.read = block.function;
    }
    return project;
}

void poll_with_takt(const model::Line& line, int in_flight, Duration time, const bench::FarEnd& far,
                    Row& row) {
    const model::Project project = make_project(line, in_flight);
    const plan::Plan plan = plan::make_plan(project);
    poll::Master::Options options;
    options.line_bus.emplace_back(
        line::fit_to_real_line(poll::line_config(project, project.lines[0]), project.lines[0]));
    poll::Master master(project, plan, options);
    const auto loop = std::move(line::Loop::create()).value();
    const auto driver = line::open_line(*loop, project.lines[0], master.line(0)).value();
    loop->run_until([&] { return driver->up(); }, 5s);
    const Measurement measurement(far);
    loop->run_until([] { return false; }, time);
    measurement.finish(row, static_cast<double>(plan.lines[0].requests.size()));
    for (std::uint32_t id = 0; id < master.store().size(); ++id)
        row.right = row.right && master.store()[value::SlotId{id}].quality == value::Quality::good;
    row.right = row.right && master.line(0).statistics(line::now()).counters.timeouts == 0;
}

std::vector<Row> measure_serial(std::uint32_t baud, Duration time) {
    const wire::CharacterFormat format{baud, 8, wire::Parity::even, 1};
    std::vector<Row> rows;
    const auto begin = [&](const char* master) -> Row& {
        rows.push_back({.line = fmt::format("{} 8E1", baud), .master = master});
        return rows.back();
    };
    struct Way {
        const char* name;
        std::vector<Block> blocks;
        Duration silence;
    };
    const std::array ways{Way{"libmodbus, one by one", variables(), {}},
                          Way{"libmodbus, blocks", best_blocks(), {}},
                          Way{"libmodbus, blocks, t3.5", best_blocks(), wire::t3_5(format)}};
    for (const auto& way : ways) {
        const bench::FarEnd far(format, kDeviceProcessor);
        modbus_t* bus = ::modbus_new_rtu(far.path().c_str(), static_cast<int>(baud), 'E', 8, 1);
        poll_with_libmodbus(bus, way.blocks, way.silence, time, far, begin(way.name));
        ::modbus_free(bus);
    }
    const bench::FarEnd far(format, kDeviceProcessor);
    model::Line line;
    line.port = far.path();
    line.format = format;
    poll_with_takt(line, 1, time, far, begin("takt"));
    return rows;
}

std::vector<Row> measure_tcp(Duration time) {
    std::vector<Row> rows;
    for (const bool blocks : {false, true}) {
        const bench::FarEnd far(kDeviceProcessor);
        modbus_t* bus = ::modbus_new_tcp("127.0.0.1", far.port());
        rows.push_back({.line = "TCP", .master = blocks ? "libmodbus, blocks" : "libmodbus, one by one"});
        poll_with_libmodbus(bus, blocks ? best_blocks() : variables(), {}, time, far, rows.back());
        ::modbus_free(bus);
    }
    for (const int in_flight : {1, 4}) {
        const bench::FarEnd far(kDeviceProcessor);
        model::Line line;
        line.transport = model::Transport::tcp;
        line.framing = wire::Framing::tcp;
        line.port = "127.0.0.1";
        line.tcp_port = far.port();
        rows.push_back({.line = "TCP", .master = in_flight == 1 ? "takt" : "takt, 4 in flight"});
        poll_with_takt(line, in_flight, time, far, rows.back());
    }
    return rows;
}

/// Rounds a second, compared with the row that keeps t3.5 where there is one; else with the blocks.
double to_fair_blocks(const Row& row, const std::vector<Row>& rows) {
    const bool kept = rows[2].master.ends_with("t3.5");
    return row.rounds_a_second / rows[kept ? 2 : 1].rounds_a_second;
}

void print(const std::vector<Row>& rows) {
    for (const auto& row : rows)
        fmt::print("{:10} {:24} {:9.0f} {:9.1f} {:7.2f} {:7.2f} {:7.2f} {:9.3f} {:9.3f} {:8.1f} {:9}{}\n",
                   row.line, row.master, row.requests_a_round, row.rounds_a_second,
                   row.rounds_a_second / rows[0].rounds_a_second,
                   row.rounds_a_second / rows[1].rounds_a_second, to_fair_blocks(row, rows), row.idle_ms(0.5),
                   row.idle_ms(0.99), row.processor_us, row.disturbed, row.right ? "" : "  wrong answers");
    std::fflush(stdout);
}

nlohmann::json to_json(const Row& row, const std::vector<Row>& rows) {
    return {
        {"line", row.line},
        {"master", row.master},
        {"requests_a_round", row.requests_a_round},
        {"rounds_a_second", row.rounds_a_second},
        {"to_one_by_one", row.rounds_a_second / rows[0].rounds_a_second},
        {"to_blocks", row.rounds_a_second / rows[1].rounds_a_second},
        {"to_fair_blocks", to_fair_blocks(row, rows)},
        {"idle_ms", {{"samples", row.idle.size()}, {"median", row.idle_ms(0.5)}, {"p99", row.idle_ms(0.99)}}},
        {"processor_us", row.processor_us},
        {"requests", row.requests},
        {"disturbed", row.disturbed},
        {"right", row.right}};
}

}  // namespace

int main(int count, char** arguments) {
    Duration time = 10s;
    bool json = false;
    for (int i = 1; i < count; ++i) {
        if (std::strcmp(arguments[i], "--json") == 0) {
            json = true;
        } else if (std::strcmp(arguments[i], "--seconds") == 0 && i + 1 < count) {
            time = std::clamp<long>(std::strtol(arguments[++i], nullptr, 10), 1, 3600) * Duration(1s);
        } else {
            std::fprintf(stderr, "usage: takt_bench_master [--seconds S] [--json]\n");
            return 2;
        }
    }
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET(kMasterProcessor, &set);
    ::sched_setaffinity(0, sizeof set, &set);
    if (!json)
        fmt::print(
            "24 variables; idle beyond t3.5 in ms; processor in us a request\n{:10} {:24} {:>9} {:>9} "
            "{:>7} {:>7} {:>7} {:>9} {:>9} {:>8} {:>9}\n",
            "line", "master", "req/round", "rounds/s", "to one", "to blk", "to fair", "idle p50", "idle p99",
            "cpu us", "disturbed");
    auto all = nlohmann::json::array();
    bool right = true;
    for (const std::uint32_t baud : {19200U, 115200U, 0U}) {
        const auto rows = baud == 0 ? measure_tcp(time) : measure_serial(baud, time);
        for (const auto& row : rows) {
            all.push_back(to_json(row, rows));
            right = right && row.right;
        }
        if (!json) print(rows);
    }
    if (json) fmt::print("{}\n", nlohmann::json{{"master", all}}.dump());
    return right ? 0 : 1;
}
