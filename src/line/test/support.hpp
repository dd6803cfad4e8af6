// Shared by the tests of this module: an engine to be scripted and a pseudo-terminal whose other end the
// test holds.
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <pty.h>
#include <sys/eventfd.h>
#include <termios.h>
#include <unistd.h>

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "takt/base/engine.hpp"
#include "takt/line/driver.hpp"
#include "takt/line/loop.hpp"
#include "takt/os/descriptor.hpp"

namespace takt::line {

using namespace std::chrono_literals;

// For waits on a condition: long enough for a loaded machine; a passing test never waits for it.
inline constexpr Duration kDeadline = 20s;

inline std::unique_ptr<Loop> make_loop() {
    return std::move(Loop::create()).value();
}

/// Runs the loop until `done`, asked at least each millisecond: for ends that the test holds outside the
/// loop.
inline bool run_until(Loop& loop, const std::function<bool()>& done) {
    Timer* self = nullptr;
    Timer poll(loop, [&](Instant t) { self->set(t + 1ms); });
    self = &poll;
    poll.set(now());
    return loop.run_until(done, kDeadline);
}

/// Sends what `output` holds, one string a transmit(); keeps what arrives; answers each arrival with
/// `reply`.
class ScriptEngine final : public Engine {
public:
    void on_link(Instant, bool is_up) override { links.push_back(is_up); }
    void on_bytes(Instant, Bytes bytes) override {
        input.append(bytes.begin(), bytes.end());
        if (reply) output.push_back(reply(std::string(bytes.begin(), bytes.end())));
    }
    void on_tick(Instant t) override {
        ticks.push_back(t);
        input_at_tick = input;
        wakeup = kNever;
    }
    Bytes transmit(Instant) override {
        if (output.empty()) return {};
        sending = std::move(output.front());
        output.erase(output.begin());
        return {reinterpret_cast<const std::uint8_t*>(sending.data()), sending.size()};
    }
    Instant next_wakeup() const override { return wakeup; }
    std::optional<Error> rejection() const override { return reason; }

    [[nodiscard]] bool up() const { return !links.empty() && links.back(); }

    std::vector<bool> links;
    std::optional<Error> reason;
    std::string input;
    std::vector<std::string> output;
    std::string sending;
    std::function<std::string(std::string)> reply;
    std::vector<Instant> ticks;
    std::string input_at_tick;
    Instant wakeup = kNever;
};

/// Blocks the loop within its descriptor events until the engine's wake-up is due. `send` runs meanwhile: the
/// loop learns of its bytes after the timer.
inline void send_while_stopped(Loop& loop, ScriptEngine& engine, Driver& driver,
                               const std::function<void()>& send) {
    const os::Descriptor other(::eventfd(1, EFD_CLOEXEC));
    Watch stop(loop, other.get(), [&] {
        engine.wakeup = now() + 1ms;
        driver.poke();
        send();
        std::this_thread::sleep_for(20ms);
    });
    stop.want_read();
    ASSERT_TRUE(loop.run_until([&] { return !engine.ticks.empty(); }, kDeadline));
}

/// A pseudo-terminal: the program opens `path`, the test holds the other end.
struct Pty {
    Pty() {
        int master_fd = -1;
        int slave_fd = -1;
        char name[128] = {};
        EXPECT_EQ(::openpty(&master_fd, &slave_fd, name, nullptr, nullptr), 0);
        master.reset(master_fd);
        slave.reset(slave_fd);
        path = name;
        EXPECT_EQ(::fcntl(master_fd, F_SETFL, O_NONBLOCK), 0);
    }
    /// The output of the program since the last call; empty: none.
    std::string read() const {
        char buffer[4096];
        const ssize_t got = ::read(master.get(), buffer, sizeof buffer);
        return got > 0 ? std::string(buffer, static_cast<std::size_t>(got)) : std::string();
    }
    void write(const std::string& bytes) const {
        EXPECT_EQ(::write(master.get(), bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
    }

    os::Descriptor master;
    os::Descriptor slave;  // keeps the terminal as it is until `path` is opened
    std::string path;
};

/// Reads the other end of a pty until `wanted` bytes are there.
inline std::string read_until(Loop& loop, const Pty& pty, std::size_t wanted) {
    std::string got;
    run_until(loop, [&] { return (got += pty.read()).size() >= wanted; });
    return got;
}

}  // namespace takt::line
