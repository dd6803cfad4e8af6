// What a transaction costs on a line with many requests: the choice of the next request, its start and its
// end.
//
// One RTU line in virtual time with 10 to 100,000 requests. Its devices answer at once. The time is processor
// time of the poller per transaction, with encoding and decoding; what varies with the number of requests is
// the choice. Memory that no longer fits into the caches costs time too.
//
// Kinds: reads with three periods, at about 80 % of what the line can carry; reads without a period, all of
// which are always due; requests that also write on change, a value set for each hundredth transaction; reads
// of up to 240 devices; reads of which one in a hundred is not answered, so that late responses are awaited.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <string_view>
#include <vector>

#include "takt/plan/plan.hpp"
#include "takt/poll/master.hpp"
#include "takt/wire/frame.hpp"

namespace {

using namespace takt;
using namespace std::chrono_literals;

constexpr wire::CharacterFormat kFormat{115200, 8, wire::Parity::none, 1};
constexpr Duration kSlot = 6ms;  // a transaction takes about 5 ms
constexpr std::size_t kRegisters = 50'000;
constexpr std::size_t kMostDevices = 240;
constexpr std::size_t kLeastTransactions = 20'000;
constexpr std::size_t kTransactionsPerWrite = 100;
constexpr int kRepetitions = 3;
constexpr double kLongest = 1e9;  // nanoseconds
constexpr int kStepsPerLook = 32;

struct Kind {
    const char* name;
    bool periodic = true;
    bool writes = false;
    std::size_t devices = 1;     // at least; each has at most kRegisters requests
    std::size_t unanswered = 0;  // each one of so many
};

constexpr Kind kKinds[] = {
    {.name = "periods"},
    {.name = "always due", .periodic = false},
    {.name = "also written", .writes = true},
    {.name = "240 devices", .devices = kMostDevices},
    {.name = "1 % unanswered", .unanswered = 100},
};

// Periods of one, two and four units, such that all requests take 6 ms each.
Duration period_of(std::size_t request, std::size_t count) {
    const Duration unit = kSlot * static_cast<std::int64_t>(count) * 7 / 12;
    return unit * (1 << request % 3);
}

model::Project make_project(const Kind& kind, std::size_t count) {
    model::Project project;
    auto& line = project.lines.emplace_back();
    line.name = "line";
    line.format = kFormat;
    const std::size_t devices =
        std::max(std::min(kind.devices, count), (count + kRegisters - 1) / kRegisters);
    line.devices.resize(devices);
    for (std::size_t d = 0; d < devices; ++d) {
        auto& device = line.devices[d];
        device.name = fmt::format("D{}", d);
        device.address = UnitId{static_cast<std::uint8_t>(d + 1)};
        device.response_timeout = 20ms;
    }
    for (std::size_t i = 0; i < count; ++i) {
        auto& variable = line.devices[i % devices].variables.emplace_back();
        variable.name = fmt::format("V{}", i);
        variable.register_number = static_cast<std::uint16_t>(i / devices);
        variable.read = wire::Function::read_holding_registers;
        variable.period = kind.periodic ? period_of(i, count) : Duration::zero();
        if (!kind.writes) continue;
        variable.write = wire::Function::write_single_register;
        variable.write_on_change = true;
    }
    return project;
}

double processor_ns() {
    timespec time{};
    ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) * 1e9 + static_cast<double>(time.tv_nsec);
}

/// A line whose devices answer reads with zeroes and repeat writes.
class Line {
public:
    Line(const Kind& kind, std::size_t count)
        : kind_(kind),
          count_(count),
          project_(make_project(kind, count)),
          plan_(plan::make_plan(project_)),
          master_(project_, plan_) {
        master_.line(0).on_link(now_, true);
    }

    /// Runs until so many transactions or so many nanoseconds of processor time have passed.
    /// @returns nanoseconds per transaction
    double run(std::size_t transactions, double longest = kLongest) {
        const std::size_t before = sent_;
        const double start = processor_ns();
        double taken = 0;
        while (sent_ - before < transactions && taken < longest) {
            for (int i = 0; i < kStepsPerLook; ++i) step();
            taken = processor_ns() - start;
        }
        return taken / static_cast<double>(sent_ - before);
    }

private:
    void step() {
        auto& line = master_.line(0);
        const Bytes sent = line.transmit(now_);
        if (sent.empty()) {
            now_ = std::max(now_, line.next_wakeup());
            return line.on_tick(now_);
        }
        ++sent_;
        if (kind_.unanswered == 0 || sent_ % kind_.unanswered != 0) answer(sent);
        if (kind_.writes && sent_ % kTransactionsPerWrite == 0) set_next();
    }

    void answer(Bytes request) {
        const UnitId unit{request[0]};
        Bytes pdu = request.subspan(1, request.size() - 3);
        std::array<std::uint8_t, wire::kMaxPdu> zeroes{0x03};
        if (pdu[0] == zeroes[0]) {
            zeroes[1] = static_cast<std::uint8_t>(2 * pdu[4]);
            pdu = Bytes(zeroes).first(2 + std::size_t{zeroes[1]});
        }
        const auto frame = wire::encode_frame(wire::Framing::rtu, unit, 0, pdu);
        now_ += wire::transmission_time(kFormat, request.size() + frame.size()) + 2ms;
        master_.line(0).on_bytes(now_, frame.span());
    }

    void set_next() {
        const std::size_t devices = project_.lines[0].devices.size();
        const std::size_t variable = set_++ * 7919 % count_;
        const auto slot = master_.slots().variable({0, variable % devices, variable / devices});
        if (!master_.set(now_, slot, value::Value(static_cast<std::int64_t>(set_ % 1000 + 1)))) std::abort();
    }

    const Kind& kind_;
    std::size_t count_;
    model::Project project_;
    plan::Plan plan_;
    poll::Master master_;
    Instant now_{1s};
    std::size_t sent_ = 0;
    std::size_t set_ = 0;
};

struct Row {
    std::size_t requests = 0;
    std::vector<double> ns;  // by kind
};

double measure(const Kind& kind, std::size_t count) {
    Line line(kind, count);
    line.run(2 * std::max(count, kLeastTransactions));
    double least = 1e18;
    for (int i = 0; i < kRepetitions; ++i) least = std::min(least, line.run(kLeastTransactions));
    return least;
}

void print_heading() {
    fmt::print("ns per transaction\n{:>10}", "requests");
    for (const auto& kind : kKinds) fmt::print("{:>16}", kind.name);
    fmt::print("\n");
}

void print(const Row& row) {
    fmt::print("{:>10}", row.requests);
    for (const double ns : row.ns) fmt::print("{:>16.0f}", ns);
    fmt::print("\n");
    std::fflush(stdout);
}

void print_json(const std::vector<Row>& rows) {
    std::string objects;
    for (const auto& row : rows)
        for (std::size_t k = 0; k < row.ns.size(); ++k)
            objects += fmt::format(R"({}{{"kind":"{}","requests":{},"ns":{:.1f}}})",
                                   objects.empty() ? "" : ",", kKinds[k].name, row.requests, row.ns[k]);
    fmt::print("{{\"choice\":[{}]}}\n", objects);
}

struct Settings {
    std::size_t least = 10;
    std::size_t most = 100'000;
    std::size_t transactions = 0;  // exactly so many, and nothing is measured
    bool json = false;
};

bool parse(int count, char** arguments, Settings& settings) {
    for (int i = 1; i < count; ++i) {
        const std::string_view argument = arguments[i];
        if (argument == "--json") {
            settings.json = true;
            continue;
        }
        if (i + 1 >= count) return false;
        const std::size_t number =
            std::clamp<std::size_t>(std::strtoul(arguments[++i], nullptr, 10), 1, 1'000'000);
        if (argument == "--requests")
            settings.least = settings.most = number;
        else if (argument == "--transactions")
            settings.transactions = number;
        else
            return false;
    }
    return true;
}

}  // namespace

int main(int count, char** arguments) {
    Settings settings;
    if (!parse(count, arguments, settings)) {
        std::fprintf(stderr,
                     "usage: takt_bench_choice [--requests N] [--json]\n"
                     "       takt_bench_choice [--requests N] --transactions N   (for bench/instructions)\n");
        return 2;
    }
    if (settings.transactions > 0) {
        Line(kKinds[0], settings.least).run(settings.transactions, 1e18);
        return 0;
    }
    if (!settings.json) print_heading();
    std::vector<Row> rows;
    for (std::size_t requests = settings.least; requests <= settings.most; requests *= 10) {
        rows.push_back({requests, {}});
        for (const auto& kind : kKinds) rows.back().ns.push_back(measure(kind, requests));
        if (!settings.json) print(rows.back());
    }
    if (settings.json) print_json(rows);
}
