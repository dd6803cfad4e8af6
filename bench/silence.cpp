// The silence before a request as the other end of the line sees it.
//
// A real master (engine, event loop, serial driver) polls one register over a pseudo-terminal. The other
// end of it is held by a thread that plays device and line: it gives each character of the response at the
// moment its stop bit would be over, and waits for the next request. Silence: from the last character of the
// response to the first of the next request. It must never be below t3.5, and on an unloaded machine not more
// than 0.5 ms above it (median and p99).
//
// A line does not stutter, a thread does: where a character came late by more than its own length, what
// follows has no meaning and is counted as disturbed. The thread asks for real-time priority, which it gets
// where it may.
#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <pty.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "takt/bus/transaction_engine.hpp"
#include "takt/line/driver.hpp"
#include "takt/line/real_line.hpp"
#include "takt/wire/frame.hpp"
#include "takt/wire/line_timing.hpp"

namespace {

using namespace takt;
using namespace std::chrono_literals;

const wire::Pdu kRequest{0x03, 0x00, 0x00, 0x00, 0x01};
const wire::Pdu kResponse{0x03, 0x02, 0x12, 0x34};

/// Asks again as soon as it was answered.
class Asking final : public Engine {
public:
    explicit Asking(const bus::LineConfig& config) : bus_(config) {}

    void on_link(Instant t, bool up) override {
        bus_.on_link(t, up);
        next(t);
    }
    void on_bytes(Instant t, Bytes bytes) override {
        bus_.on_bytes(t, bytes);
        next(t);
    }
    void on_tick(Instant t) override {
        bus_.on_tick(t);
        next(t);
    }
    Bytes transmit(Instant t) override { return bus_.transmit(t); }
    Instant next_wakeup() const override { return bus_.next_wakeup(); }

    [[nodiscard]] std::size_t failed() const { return failed_; }

private:
    void next(Instant t) {
        while (const auto outcome = bus_.take_outcome())
            failed_ += outcome->status == bus::Status::ok ? 0u : 1u;
        if (!bus_.can_submit() || !bus_.idle()) return;
        bus::Transaction transaction;
        transaction.unit = UnitId{16};
        transaction.request = kRequest;
        if (!bus_.submit(t, transaction)) ++failed_;
    }

    bus::TransactionEngine bus_;
    std::size_t failed_ = 0;
};

// Sleeps, and spins at the end only: the kernel needs the processor to hand on what was written.
void wait_until(Instant t) {
    constexpr Duration kSpin = 100us;
    const auto wake = (t - kSpin).time_since_epoch();
    const timespec at{static_cast<time_t>(wake / 1s), static_cast<long>((wake % 1s).count())};
    ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr);
    while (line::now() < t) {}
}

struct Measured {
    wire::CharacterFormat format;
    std::vector<Duration> silences;  // ascending
    std::size_t disturbed = 0;
    std::size_t failed = 0;

    [[nodiscard]] double excess_us(double quantile) const {
        const auto last = static_cast<double>(silences.size() - 1);
        const auto silence = silences[static_cast<std::size_t>(quantile * last + 0.5)];
        return static_cast<double>((silence - wire::t3_5(format)).count()) / 1000;
    }
};

/// The device and the line, with the clock of the line's other end.
class OtherEnd {
public:
    OtherEnd(int fd, const wire::CharacterFormat& format) : fd_(fd), format_(format) {}

    void measure(std::size_t samples, const std::atomic<bool>& give_up, Measured& measured) {
        const sched_param priority{.sched_priority = 10};
        ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &priority);
        const auto response = wire::encode_frame(wire::Framing::rtu, UnitId{16}, 0, kResponse.span());
        const auto request_length = wire::frame_length(wire::Framing::rtu, kRequest.size());
        std::optional<Instant> response_end;
        while (measured.silences.size() < samples && !give_up) {
            const auto first = receive(request_length, give_up);
            if (response_end) measured.silences.push_back(first - *response_end);
            const Instant request_end = first + wire::transmission_time(format_, request_length);
            response_end = respond(request_end + wire::t3_5(format_), response.span());
            if (!response_end) ++measured.disturbed;
        }
    }

private:
    Instant receive(std::size_t length, const std::atomic<bool>& give_up) const {
        Instant first = kNever;
        std::uint8_t buffer[wire::kMaxRtuFrame];
        for (std::size_t got = 0; got < length && !give_up;) {
            pollfd waiting{fd_, POLLIN, 0};
            if (::poll(&waiting, 1, 100) != 1) continue;
            const ssize_t count = ::read(fd_, buffer, sizeof buffer);
            if (count <= 0) continue;
            if (got == 0) first = line::now();
            got += static_cast<std::size_t>(count);
        }
        return first;
    }

    // The end of the response; nothing when it stuttered.
    std::optional<Instant> respond(Instant start, Bytes response) const {
        bool stuttered = false;
        for (std::size_t i = 0; i < response.size(); ++i) {
            const Instant due = start + wire::transmission_time(format_, i + 1);
            wait_until(due);
            if (::write(fd_, &response[i], 1) != 1) std::abort();
            stuttered = stuttered || line::now() > due + wire::transmission_time(format_, 1);
        }
        const Instant end = line::now();
        return stuttered ? std::nullopt : std::optional(end);
    }

    int fd_;
    wire::CharacterFormat format_;
};

Measured measure(const wire::CharacterFormat& format, std::size_t samples) {
    int other_end = -1;
    int own_end = -1;
    char path[128] = {};
    if (::openpty(&other_end, &own_end, path, nullptr, nullptr) != 0) std::abort();
    ::fcntl(other_end, F_SETFL, O_NONBLOCK);

    const auto loop = std::move(line::Loop::create()).value();
    model::Line serial;
    serial.port = path;
    serial.format = format;
    bus::LineConfig config;
    config.format = format;
    Asking engine(line::fit_to_real_line(config, serial));
    const auto driver = std::move(line::open_line(*loop, serial, engine)).value();

    Measured measured{format, {}, 0, 0};
    std::atomic<bool> give_up = false;
    std::thread other([&] {
        OtherEnd(other_end, format).measure(samples, give_up, measured);
        loop->stop();
    });
    line::Timer limit(*loop, [&](Instant) { give_up = true; });
    limit.set(line::now() + 60s);
    loop->run();
    other.join();
    ::close(other_end);
    ::close(own_end);
    measured.failed = engine.failed();
    std::ranges::sort(measured.silences);
    return measured;
}

void print_table_row(const Measured& measured) {
    const double t3_5_us = static_cast<double>(wire::t3_5(measured.format).count()) / 1000;
    std::printf("%8u %9.1f %8zu %9zu %7zu %9.1f %9.1f %9.1f %9.1f\n", measured.format.baud, t3_5_us,
                measured.silences.size(), measured.disturbed, measured.failed, measured.excess_us(0),
                measured.excess_us(0.5), measured.excess_us(0.99), measured.excess_us(1));
}

void print_json(const Measured& measured, bool first) {
    const double t3_5_us = static_cast<double>(wire::t3_5(measured.format).count()) / 1000;
    std::printf(
        "%s{\"baud\":%u,\"t3_5_us\":%.1f,\"samples\":%zu,\"disturbed\":%zu,\"failed\":%zu,\"excess_us\":"
        "{\"min\":%.1f,\"median\":%.1f,\"p99\":%.1f,\"max\":%.1f}}",
        first ? "" : ",", measured.format.baud, t3_5_us, measured.silences.size(), measured.disturbed,
        measured.failed, measured.excess_us(0), measured.excess_us(0.5), measured.excess_us(0.99),
        measured.excess_us(1));
}

}  // namespace

int main(int count, char** arguments) {
    std::size_t samples = 500;
    bool json = false;
    for (int i = 1; i < count; ++i) {
        if (std::strcmp(arguments[i], "--json") == 0) {
            json = true;
        } else if (std::strcmp(arguments[i], "--samples") == 0 && i + 1 < count) {
            samples = std::clamp<std::size_t>(std::strtoul(arguments[++i], nullptr, 10), 1, 1'000'000);
        } else {
            std::fprintf(stderr, "usage: takt_bench_silence [--samples N] [--json]\n");
            return 2;
        }
    }
    if (json)
        std::printf("{\"silence\":[");
    else
        std::printf(
            "silence before a request beyond t3.5, in microseconds, seen by the other end\n%8s %9s %8s %9s "
            "%7s %9s %9s %9s %9s\n",
            "baud", "t3.5", "samples", "disturbed", "failed", "min", "median", "p99", "max");
    bool first = true;
    bool kept = true;
    for (const std::uint32_t baud : {9600u, 19200u, 115200u}) {
        const Measured measured = measure({baud, 8, wire::Parity::even, 1}, samples);
        if (measured.silences.empty()) {
            std::fprintf(stderr, "%u bit/s: nothing was measured\n", baud);
            return 1;
        }
        if (json)
            print_json(measured, std::exchange(first, false));
        else
            print_table_row(measured);
        std::fflush(stdout);
        kept = kept && measured.excess_us(0) >= 0;
    }
    if (json) std::printf("]}\n");
    if (!kept) std::fprintf(stderr, "a silence was shorter than t3.5\n");
    return kept ? 0 : 1;
}
