#include "line.hpp"

#include <poll.h>
#include <pty.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>

#include <functional>
#include <thread>

#include "takt/line/driver.hpp"
#include "takt/line/target.hpp"
#include "takt/serve/serial_slave.hpp"
#include "takt/sim/devices.hpp"
#include "takt/wire/frame.hpp"

namespace bench {
namespace {

using namespace takt;
using namespace std::chrono_literals;

constexpr wire::CharacterFormat kFormat{115200, 8, wire::Parity::even, 1};
constexpr std::size_t kAnswer = 7;

struct Terminal {
    int own = -1;
    int other = -1;
    char path[128] = {};
    Terminal() {
        if (::openpty(&own, &other, path, nullptr, nullptr) != 0) std::abort();
        termios raw{};
        ::tcgetattr(other, &raw);
        ::cfmakeraw(&raw);
        ::tcsetattr(other, TCSANOW, &raw);
    }
    ~Terminal() {
        ::close(own);
        ::close(other);
    }
    Terminal(const Terminal&) = delete;
    Terminal& operator=(const Terminal&) = delete;
};

void serve_takt(const char* path) {
    const auto loop = std::move(line::Loop::create()).value();
    sim::Devices devices(UnitId{1}, sim::Fill::ramp);
    serve::SerialConfig config;
    config.format = kFormat;
    config.untimed = true;
    serve::SerialSlave slave(config, devices);
    const auto target = line::parse_target("rtu://" + std::string(path) + "?baud=115200&parity=even").value();
    const auto driver = line::open_line(*loop, target.as_line(), slave);
    loop->run();
}

void serve_echo(int fd, std::size_t request, std::size_t response) {
    std::vector<char> buffer(wire::kMaxRtuFrame);
    for (std::size_t received = 0;;) {
        pollfd waiting{fd, POLLIN, 0};
        if (::poll(&waiting, 1, -1) != 1) continue;
        const ssize_t got = ::read(fd, buffer.data(), buffer.size());
        if (got <= 0) return;
        received += static_cast<std::size_t>(got);
        if (received < request) continue;
        received -= request;
        if (::write(fd, buffer.data(), response) < 0) return;
    }
}

Load ask(int fd, Bytes request, std::chrono::milliseconds length, Duration silence) {
    Load load;
    const auto end = Clock::now() + length;
    std::vector<char> buffer(wire::kMaxRtuFrame);
    while (Clock::now() < end) {
        const auto begin = Clock::now();
        if (::write(fd, request.data(), request.size()) < 0) break;
        std::size_t got = 0;
        while (got < kAnswer) {
            pollfd waiting{fd, POLLIN, 0};
            constexpr int kPatience = 1000;
            if (::poll(&waiting, 1, kPatience) != 1) break;
            const ssize_t count = ::read(fd, buffer.data(), buffer.size());
            got += static_cast<std::size_t>(std::max<ssize_t>(count, 0));
        }
        const auto taken = Clock::now() - begin - silence;
        if (got == kAnswer) {
            ++load.answered;
            load.latencies_us.push_back(std::chrono::duration<double, std::micro>(taken).count());
        } else {
            ++load.unanswered;
        }
        std::this_thread::sleep_for(5ms);  // the silence between an answer and the next request
    }
    std::ranges::sort(load.latencies_us);
    return load;
}

Load measure(std::chrono::milliseconds length, Duration silence,
             const std::function<void(Terminal&)>& serve) {
    Terminal terminal;
    const pid_t server = ::fork();
    if (server == 0) {
        ::prctl(PR_SET_PDEATHSIG, SIGKILL);
        pin_to(1);
        serve(terminal);
        std::_Exit(1);
    }
    const std::uint8_t pdu[] = {0x03, 0, 7, 0, 1};
    const auto request = wire::encode_frame(wire::Framing::rtu, UnitId{1}, 0, pdu);
    std::this_thread::sleep_for(300ms);
    const Load load = ask(terminal.own, request.span(), length, silence);
    ::kill(server, SIGKILL);
    ::waitpid(server, nullptr, 0);
    return load;
}

}  // namespace

std::pair<Load, Load> measure_pty(std::chrono::milliseconds length) {
    constexpr std::size_t kRequest = 8;
    return {measure(length, wire::t3_5(kFormat), [](Terminal& t) { serve_takt(t.path); }),
            measure(length, Duration::zero(), [](Terminal& t) { serve_echo(t.other, kRequest, kAnswer); })};
}

}  // namespace bench
