// `takt serve` beside a blocking echo of as many bytes, over loopback at 1 kHz: each measured in blocks that
// alternate, idle and beside a load on the other processor, with and without --spin.
#include <fmt/format.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <exception>
#include <optional>
#include <string>
#include <thread>

#include "../arguments.hpp"
#include "../working_folder.hpp"
#include "paired.hpp"
#include "peers.hpp"
#include "takt/client/background_load.hpp"
#include "takt/os/realtime.hpp"

namespace takt::bench {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr auto kPace = 1ms;
constexpr std::size_t kBlock = 200;    // exchanges
constexpr auto kSettle = 10ms;         // before a block, so that a peer that spins has stopped
constexpr std::size_t kResponse = 11;  // bytes: one register
constexpr auto kSpin = std::chrono::microseconds(50);
constexpr int kPriority = 49;

const std::vector<std::uint8_t> kRequest{0, 1, 0, 0, 0, 6, 1, 3, 0, 0, 0, 1};

struct Condition {
    std::string name;
    bool load = false;
    bool spin = false;
};

struct Measured {
    Blocks takt;
    Blocks echo;
};

std::vector<double> block_of(const Peer& peer, std::size_t expected) {
    std::vector<double> times;
    times.reserve(kBlock);
    auto due = Clock::now() + kSettle;
    for (std::size_t i = 0; i < kBlock; ++i, due += kPace) {
        std::this_thread::sleep_until(due);
        times.push_back(std::chrono::duration<double, std::micro>(peer.exchange(kRequest, expected)).count());
    }
    return times;
}

/// On a thread of its own, on the processor beside that of the peers. The order changes from pair to pair.
Measured measure(const Condition& condition, std::size_t pairs) {
    const int peer_cpu = std::thread::hardware_concurrency() > 1 ? 1 : 0;
    const Peer echo = Peer::echo({.cpu = peer_cpu});
    const Peer takt =
        Peer::takt({.cpu = peer_cpu, .spin = condition.spin ? std::optional(kSpin) : std::nullopt});
    std::optional<client::BackgroundLoad> load;
    if (condition.load) load.emplace(1);
    Measured measured;
    std::exception_ptr failure;
    std::thread([&] {
        try {
            (void)os::become_realtime({.priority = kPriority, .cpu = 0});
            (void)block_of(takt, kResponse);  // warms both up
            (void)block_of(echo, kRequest.size());
            for (std::size_t pair = 0; pair < pairs; ++pair) {
                check_interrupted();
                const bool takt_first = pair % 2 == 0;
                if (takt_first) measured.takt.push_back(block_of(takt, kResponse));
                measured.echo.push_back(block_of(echo, kRequest.size()));
                if (!takt_first) measured.takt.push_back(block_of(takt, kResponse));
            }
        } catch (...) {
            failure = std::current_exception();
        }
    }).join();
    if (failure) std::rethrow_exception(failure);
    return measured;
}

void print_row(const Condition& condition, const Measured& measured) {
    const auto cell = [](const Ratio& ratio) {
        return fmt::format("{:.3f} [{:.3f}, {:.3f}]", ratio.value, ratio.low, ratio.high);
    };
    fmt::print("{:<12} {:>9} {:>9.1f} {:>9.1f} {:>9.1f} {:>9.1f} {:>9.1f} {:>9.1f} {:>23} {:>23}\n",
               condition.name, measured.takt.size() * kBlock, percentile(measured.echo, 50),
               percentile(measured.takt, 50), percentile(measured.echo, 99.9),
               percentile(measured.takt, 99.9), greatest(measured.echo), greatest(measured.takt),
               cell(ratio(measured.takt, measured.echo, 50)),
               cell(ratio(measured.takt, measured.echo, 99.9)));
    std::fflush(stdout);
}

std::string object_of(const Condition& condition, const Measured& measured) {
    const auto times = [](const Blocks& blocks) {
        return fmt::format("{{\"p50_us\":{:.2f},\"p99.9_us\":{:.2f},\"max_us\":{:.2f}}}",
                           percentile(blocks, 50), percentile(blocks, 99.9), greatest(blocks));
    };
    const auto interval = [](const Ratio& ratio) {
        return fmt::format("{{\"ratio\":{:.4f},\"low\":{:.4f},\"high\":{:.4f}}}", ratio.value, ratio.low,
                           ratio.high);
    };
    return fmt::format(
        "{{\"condition\":\"{}\",\"exchanges\":{},\"echo\":{},\"takt\":{},\"p50\":{},\"p99.9\":{}}}",
        condition.name, measured.takt.size() * kBlock, times(measured.echo), times(measured.takt),
        interval(ratio(measured.takt, measured.echo, 50)),
        interval(ratio(measured.takt, measured.echo, 99.9)));
}

/// Threads that this one starts run beside the peers, on processor 0.
void stay_on_first_processor() {
    cpu_set_t first;
    CPU_ZERO(&first);
    CPU_SET(0, &first);
    (void)::sched_setaffinity(0, sizeof first, &first);
}

int run(const Arguments& arguments) {
    const bool json = arguments.json();
    const auto seconds = arguments.number<std::size_t>("--seconds", 60, 1, 86'400);  // of each condition
    stay_on_first_processor();
    const std::size_t pairs = std::max<std::size_t>(2, seconds * 1000 / (2 * kBlock));
    if (!json)
        fmt::print(
            "{:<12} {:>9} {:>19} {:>19} {:>19} {:>23} {:>23}\n{:<12} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} "
            "{:>9} {:>23} {:>23}\n",
            "", "", "median, us", "p99.9, us", "max, us", "median", "p99.9", "condition", "exchanges", "echo",
            "takt", "echo", "takt", "echo", "takt", "takt / echo [95 %]", "takt / echo [95 %]");
    std::string objects;
    for (const Condition& condition : {Condition{"idle"}, Condition{"load", true},
                                       Condition{"spin", false, true}, Condition{"spin, load", true, true}}) {
        const auto measured = measure(condition, pairs);
        if (!json) print_row(condition, measured);
        objects += (objects.empty() ? "" : ",") + object_of(condition, measured);
    }
    if (json) fmt::print("{{\"exchange\":[{}]}}\n", objects);
    return 0;
}

}  // namespace
}  // namespace takt::bench

int main(int count, char** arguments) {
    return takt::bench::run_benchmark(count, arguments, {{"--seconds", "S"}}, takt::bench::run);
}
