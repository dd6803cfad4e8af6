// The slave and its peers on the loopback interface: throughput with one client and many, the cost of idle
// connections, and the service of a good client while others misbehave.
//
// The servers run on the second processor, one at a time, in turns; clients and attackers on the first. Echo:
// a bare epoll loop that sends, for each request, as many bytes as the answer has: what the machine itself
// costs. usage: takt_bench_slave [--seconds N] [--idle N] [--only speed|idle|others|line] [--json]
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "attacks.hpp"
#include "line.hpp"
#include "load.hpp"
#include "report.hpp"
#include "servers.hpp"

namespace {

using namespace bench;
using namespace std::chrono_literals;

struct Options {
    std::chrono::milliseconds length = 3s;
    std::size_t idle = 10'000;
    std::string only;
    bool json = false;
    [[nodiscard]] bool wants(const char* part) const { return only.empty() || only == part; }
};

struct Pattern {
    const char* name;
    Exchange exchange;
    std::size_t connections;
    std::size_t window;
};

void note(const Load& load, Row& row, Kind kind) {
    row.wrong[static_cast<std::size_t>(kind)] = load.wrong;
    row.unanswered[static_cast<std::size_t>(kind)] = load.unanswered;
}

/// Every server for `length` in all, in short turns, so that other work of the machine affects all of them.
std::array<Load, kKinds.size()> flood_in_turns(const Pattern& pattern, std::chrono::milliseconds length) {
    constexpr int kTurns = 10;
    std::deque<ServerProcess> servers;
    for (const Kind kind : kKinds) servers.emplace_back(kind, pattern.exchange.sizes());
    std::array<Load, kKinds.size()> loads;
    for (int turn = 0; turn <= kTurns; ++turn)
        for (const Kind kind : kKinds) {
            const auto i = static_cast<std::size_t>(kind);
            const bool warms_up = turn == 0;
            const Load load = flood(servers[i].port(), pattern.exchange, pattern.connections, pattern.window,
                                    warms_up ? 200ms : length / kTurns, kind != Kind::echo);
            if (!warms_up) loads[i].add(load);
        }
    return loads;
}

void measure_speed(const Options& options, Report& report) {
    const std::vector<Pattern> patterns{{"1 connection, 1 request", read_registers(7, 1), 1, 1},
                                        {"64 connections x 8", read_registers(7, 1), 64, 8},
                                        {"8 connections x 8", read_registers(7, 1), 8, 8},
                                        {"8 x 8, FC3 x 125", read_registers(7, 125), 8, 8},
                                        {"8 x 8, FC16 x 123", write_registers(7, 123), 8, 8}};
    for (const auto& pattern : patterns) {
        Row rate{pattern.name, "requests/s"};
        Row median{pattern.name, "median, us"};
        Row tail{pattern.name, "p99, us"};
        const auto loads = flood_in_turns(pattern, options.length);
        for (const Kind kind : kKinds) {
            const Load& load = loads[static_cast<std::size_t>(kind)];
            rate.set(kind, load.requests_per_s);
            note(load, rate, kind);
            median.set(kind, load.quantile_us(0.5));
            tail.set(kind, load.quantile_us(0.99));
        }
        report.add(rate);
        if (pattern.connections * pattern.window > 1) continue;
        report.add(median);
        report.add(tail);
    }
}

void measure_idle(const Options& options, Report& report) {
    const std::string name = fmt::format("{} idle connections", options.idle);
    Row memory{name, "bytes each"};
    Row quiet{"none idle", "median, us"};
    Row busy{name, "median, us"};
    const Exchange exchange = read_registers(7, 1);
    for (const Kind kind : {Kind::takt, Kind::echo}) {
        const ServerProcess server(kind, exchange.sizes());
        const bool checked = kind != Kind::echo;
        quiet.set(kind, flood(server.port(), exchange, 1, 1, options.length, checked).quantile_us(0.5));
        const std::size_t before = server.resident();
        std::vector<int> connections;
        while (connections.size() < options.idle) {
            const int fd = connect_to(server.port());
            if (fd < 0) break;
            connections.push_back(fd);
        }
        const Load load = flood(server.port(), exchange, 1, 1, options.length, checked);
        busy.set(kind, load.quantile_us(0.5));
        note(load, busy, kind);
        memory.set(kind,
                   static_cast<double>(server.resident() - before) / static_cast<double>(connections.size()));
        if (connections.size() < options.idle)
            std::fprintf(stderr, "%zu connections only: the limit of descriptors\n", connections.size());
        for (const int fd : connections) ::close(fd);
    }
    for (const Row& row : {memory, quiet, busy}) report.add(row);
}

void measure_others(const Options& options, Report& report) {
    constexpr std::size_t kPerSecond = 500;
    const Exchange exchange = read_registers(7, 1);
    const auto measure = [&](const Attack* attack) {
        const std::string name = attack ? std::string(attack->name) : "quiet";
        Row half{name, "p50, us"};
        Row most{name, "p99, us"};
        Row nearly_all{name, "p99.9, us"};
        for (const Kind kind : kKinds) {
            const ServerProcess server(kind, exchange.sizes());
            std::optional<Attackers> attackers;
            if (attack) attackers.emplace(*attack, server.port());
            std::this_thread::sleep_for(200ms);
            const Load load = paced(server.port(), exchange, kPerSecond, options.length, kind != Kind::echo);
            half.set(kind, load.quantile_us(0.5));
            most.set(kind, load.quantile_us(0.99));
            nearly_all.set(kind, load.quantile_us(0.999));
            note(load, nearly_all, kind);
        }
        for (const Row& row : {half, most, nearly_all}) report.add(row);
    };
    measure(nullptr);
    for (const Attack& attack : attacks()) measure(&attack);
}

void measure_line(const Options& options, Report& report) {
    const auto [takt, echo] = measure_pty(options.length);
    Row beyond{"RTU over a pty", "median, us"};
    beyond.set(Kind::takt, takt.quantile_us(0.5));
    beyond.set(Kind::echo, echo.quantile_us(0.5));
    note(takt, beyond, Kind::takt);
    report.add(beyond);
    Row tail{"RTU over a pty", "p99, us"};
    tail.set(Kind::takt, takt.quantile_us(0.99));
    tail.set(Kind::echo, echo.quantile_us(0.99));
    report.add(tail);
}

int usage() {
    std::fprintf(
        stderr,
        "usage: takt_bench_slave [--seconds N] [--idle N] [--only speed|idle|others|line] [--json]\n");
    return 2;
}

}  // namespace

int main(int count, char** arguments) {
    Options options;
    for (int i = 1; i < count; ++i) {
        const std::string argument = arguments[i];
        const char* value = i + 1 < count ? arguments[i + 1] : nullptr;
        if (argument == "--json") {
            options.json = true;
            continue;
        }
        if (!value) return usage();
        ++i;
        if (argument == "--seconds")
            options.length = std::chrono::seconds(std::clamp(std::atoi(value), 1, 600));
        else if (argument == "--idle")
            options.idle = static_cast<std::size_t>(std::clamp(std::atoi(value), 1, 20'000));
        else if (argument == "--only")
            options.only = value;
        else
            return usage();
    }
    constexpr std::size_t kOwnDescriptors = 64;
    options.idle = std::min(options.idle, raise_descriptors() - kOwnDescriptors);
    pin_to(0);
    Report report(options.json);
    if (options.wants("speed")) measure_speed(options, report);
    if (options.wants("idle")) measure_idle(options, report);
    if (options.wants("others")) measure_others(options, report);
    if (options.wants("line")) measure_line(options, report);
    return report.end();
}
