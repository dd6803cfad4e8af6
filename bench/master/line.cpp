#include "line.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <pty.h>
#include <sched.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <new>
#include <optional>
#include <span>

#include "takt/line/loop.hpp"
#include "takt/wire/frame.hpp"

namespace takt::bench {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kRequestPdu = 5;  // 0x03 and 0x04: function, start, quantity

void begin_process(int processor) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET(static_cast<std::size_t>(processor), &set);
    ::sched_setaffinity(0, sizeof set, &set);
    const sched_param priority{.sched_priority = 10};
    ::sched_setscheduler(0, SCHED_FIFO, &priority);
}

wire::Pdu answer(std::span<const std::uint8_t> request) {
    const unsigned start = request[1] * 256U + request[2];
    const unsigned quantity = std::min<unsigned>(request[4], 125);
    wire::Pdu pdu{request[0], static_cast<std::uint8_t>(2 * quantity)};
    for (unsigned i = 0; i < quantity; ++i) {
        pdu.push_back(static_cast<std::uint8_t>((start + i) >> 8));
        pdu.push_back(static_cast<std::uint8_t>(start + i));
    }
    return pdu;
}

// Sleeps, and spins at the end only: the kernel needs the processor to hand on what was written.
void wait_until(Instant t) {
    constexpr Duration kSpin = 60us;
    const auto wake = (t - kSpin).time_since_epoch();
    const timespec at{static_cast<time_t>(wake / 1s), static_cast<long>((wake % 1s).count())};
    ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr);
    while (line::now() < t) {}
}

class SerialDevice {
public:
    SerialDevice(int fd, const wire::CharacterFormat& format, Seen& seen)
        : fd_(fd), format_(format), seen_(seen) {}

    void serve() {
        for (;;) {
            const Instant first = receive();
            if (end_) note_idle(first - *end_ - wire::t3_5(format_));
            ++seen_.requests;
            const Instant request_end = first + wire::transmission_time(format_, request_.size());
            const wire::Pdu pdu = answer(std::span(request_).subspan(1, kRequestPdu));
            respond(request_end + wire::t3_5(format_),
                    wire::encode_frame(wire::Framing::rtu, UnitId{request_[0]}, 0, pdu.span()).span());
        }
    }

private:
    Instant receive() {
        Instant first;
        for (std::size_t got = 0; got < request_.size();) {
            pollfd waiting{fd_, POLLIN, 0};
            if (::poll(&waiting, 1, -1) != 1) continue;
            const ssize_t count = ::read(fd_, request_.data() + got, request_.size() - got);
            if (count <= 0) continue;
            if (got == 0) first = line::now();
            got += static_cast<std::size_t>(count);
        }
        return first;
    }

    void respond(Instant start, Bytes response) {
        bool stuttered = false;
        const Duration character = wire::transmission_time(format_, 1);
        for (std::size_t i = 0; i < response.size(); ++i) {
            const Instant due = start + wire::transmission_time(format_, i + 1);
            wait_until(due);
            if (::write(fd_, &response[i], 1) != 1) std::abort();
            stuttered = stuttered || line::now() > due + character;
        }
        end_ = stuttered ? std::nullopt : std::optional(line::now());
        if (stuttered) ++seen_.disturbed;
    }

    void note_idle(Duration idle) {
        const std::size_t place = seen_.samples;
        if (place == Seen::kMost) return;
        seen_.idle_ns[place] = idle.count();
        seen_.samples = place + 1;
    }

    int fd_;
    wire::CharacterFormat format_;
    Seen& seen_;
    std::array<std::uint8_t, 3 + kRequestPdu> request_{};
    std::optional<Instant> end_;
};

void serve_tcp(int listener, Seen& seen) {
    constexpr std::size_t kRequest = 7 + kRequestPdu;
    for (;;) {
        const int fd = ::accept(listener, nullptr, nullptr);
        const int on = 1;
        ::setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
        std::array<std::uint8_t, 16 * kRequest> bytes{};
        std::size_t held = 0;
        for (;;) {
            const ssize_t got = ::recv(fd, bytes.data() + held, bytes.size() - held, 0);
            if (got <= 0) break;
            held += static_cast<std::size_t>(got);
            std::size_t at = 0;
            for (; at + kRequest <= held; at += kRequest) {
                const auto request = std::span(bytes).subspan(at, kRequest);
                const auto id = static_cast<std::uint16_t>(request[0] << 8 | request[1]);
                const auto frame = wire::encode_frame(wire::Framing::tcp, UnitId{request[6]}, id,
                                                      answer(request.subspan(7)).span());
                ++seen.requests;
                if (::send(fd, frame.data(), frame.size(), MSG_NOSIGNAL) < 0) break;
            }
            std::copy(bytes.begin() + static_cast<std::ptrdiff_t>(at),
                      bytes.begin() + static_cast<std::ptrdiff_t>(held), bytes.begin());
            held -= at;
        }
        ::close(fd);
    }
}

}  // namespace

void FarEnd::share() {
    void* shared = ::mmap(nullptr, sizeof(Seen), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (shared == MAP_FAILED) std::abort();
    seen_ = new (shared) Seen{};
}

FarEnd::FarEnd(const wire::CharacterFormat& format, int processor) {
    share();
    int far = -1;
    char name[128] = {};
    if (::openpty(&far, &near_, name, nullptr, nullptr) != 0) std::abort();
    path_ = name;
    process_ = ::fork();
    if (process_ == 0) {
        ::close(near_);
        begin_process(processor);
        SerialDevice(far, format, *seen_).serve();
    }
    ::close(far);
}

FarEnd::FarEnd(int processor) {
    share();
    const int listener = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t length = sizeof address;
    auto* const raw = reinterpret_cast<sockaddr*>(&address);
    if (::bind(listener, raw, length) != 0 || ::listen(listener, 1) != 0 ||
        ::getsockname(listener, raw, &length) != 0)
        std::abort();
    seen_->port = ntohs(address.sin_port);
    process_ = ::fork();
    if (process_ == 0) {
        begin_process(processor);
        serve_tcp(listener, *seen_);
    }
    ::close(listener);
}

FarEnd::~FarEnd() {
    ::kill(process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
    if (near_ >= 0) ::close(near_);
    ::munmap(seen_, sizeof(Seen));
}

std::vector<Duration> FarEnd::idle() const {
    std::vector<Duration> idle;
    for (std::size_t i = 0; i < seen_->samples; ++i) idle.emplace_back(seen_->idle_ns[i]);
    std::ranges::sort(idle);
    return idle;
}

}  // namespace takt::bench
