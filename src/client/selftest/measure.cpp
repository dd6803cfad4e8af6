#include "takt/client/measure.hpp"

#include <algorithm>
#include <optional>
#include <thread>

#include "selftest/echo.hpp"
#include "selftest/wake_up.hpp"

namespace takt::client {
namespace {

constexpr Duration kPace = std::chrono::milliseconds(1);
constexpr Duration kProgressPace = std::chrono::milliseconds(100);

bool stopped(const MeasureOptions& options) {
    return options.stop != nullptr && *options.stop;
}

void run(line::Loop& loop, const MeasureOptions& options) {
    const Instant start = line::now();
    line::Timer* again = nullptr;
    line::Timer watch(loop, [&](Instant t) {
        if (stopped(options)) return loop.stop();
        if (options.progress) options.progress(t - start);
        again->set(t + kProgressPace);
    });
    again = &watch;
    watch.set(start);
    loop.run_until([] { return false; }, options.time);
}

Result<void> exchange(line::Loop& loop, Result<Link> made, const MeasureOptions& options,
                      LatencyStatistics& statistics) {
    TAKT_TRY(auto link, std::move(made));
    std::optional<EchoPeer> peer;
    try {
        peer.emplace(link.far.get(), options.begin_peer);
    } catch (const std::system_error& error) {
        return no_thread(error);
    }
    {
        const Exchange measured(loop, link.near.get(), kPace, statistics);
        run(loop, options);
    }
    link.near.reset();  // ends the peer
    return {};
}

Result<void> measure_here(Subject subject, const MeasureOptions& options, LatencyStatistics& statistics) {
    TAKT_TRY(const auto loop, line::Loop::create());
    if (options.begin_thread) options.begin_thread(*loop);
    switch (subject) {
        case Subject::wake_up: {
            const WakeUp measured(*loop, kPace, statistics);
            run(*loop, options);
            return {};
        }
        case Subject::loopback: return exchange(*loop, loopback_link(), options, statistics);
        case Subject::pty: return exchange(*loop, pty_link(), options, statistics);
    }
    return {};
}

Duration rounded_up(Duration time) {
    constexpr Duration kStep = std::chrono::microseconds(100);
    return (time + kStep - Duration(1)) / kStep * kStep;
}

}  // namespace

std::unexpected<Error> no_thread(const std::system_error& error) {
    return fail(Code::io_failed, "thread", error.code().value());
}

Result<LatencyStatistics> measure(Subject subject, const MeasureOptions& options) {
    LatencyStatistics statistics;
    Result<void> done;
    try {
        std::thread([&] { done = measure_here(subject, options, statistics); }).join();
    } catch (const std::system_error& error) {
        return no_thread(error);
    }
    TAKT_CHECK(done);
    return statistics;
}

HostBudget budget_of(const LatencyStatistics& wake_up, const LatencyStatistics& loopback,
                     const LatencyStatistics& pty) {
    return {.jitter = rounded_up(wake_up.max()), .overhead = rounded_up(std::max(loopback.max(), pty.max()))};
}

}  // namespace takt::client
