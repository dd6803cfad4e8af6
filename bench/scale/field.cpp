#include "field.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sched.h>
#include <signal.h>
#include <sys/epoll.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <new>
#include <span>
#include <vector>

#include "takt/line/descriptors.hpp"

namespace takt::bench {
namespace {

constexpr std::uint32_t kFirstAddress = 0x7F010001;
constexpr std::size_t kOwnDescriptors = 16;  // of a process

sockaddr_in address_of(std::size_t device, std::uint16_t port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(kFirstAddress + static_cast<std::uint32_t>(device));
    return address;
}

class Devices {
public:
    explicit Devices(FieldState& state) : state_(state), epoll_(::epoll_create1(EPOLL_CLOEXEC)) {}

    /// @param first, end  the devices
    bool listen(std::size_t first, std::size_t end) {
        std::uint16_t port = state_.port;
        for (std::size_t device = first; device < end; ++device) {
            const int fd = ::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
            sockaddr_in address = address_of(device, port);
            socklen_t length = sizeof address;
            auto* const raw = reinterpret_cast<sockaddr*>(&address);
            if (fd < 0 || ::bind(fd, raw, length) != 0 || ::listen(fd, 8) != 0) return false;
            if (port == 0 && ::getsockname(fd, raw, &length) == 0) port = ntohs(address.sin_port);
            watch(fd, true);
        }
        state_.port = port;
        state_.listening += end - first;
        return true;
    }

    void serve() {
        std::array<epoll_event, 256> events;
        for (;;) {
            const int count = ::epoll_wait(epoll_, events.data(), static_cast<int>(events.size()), 10);
            for (int i = 0; i < count; ++i) {
                const auto fd = static_cast<int>(events[static_cast<std::size_t>(i)].data.u32);
                if (is_listener_[static_cast<std::size_t>(fd)])
                    accept(fd);
                else
                    answer(fd);
            }
            if (const auto wanted = state_.drops.load(); wanted != drops_) {
                drops_ = wanted;
                drop_all();
            }
        }
    }

private:
    void watch(int fd, bool listener) {
        const auto index = static_cast<std::size_t>(fd);
        if (is_listener_.size() <= index) {
            is_listener_.resize(index + 1);
            connected_.resize(index + 1);
        }
        is_listener_[index] = listener;
        connected_[index] = !listener;
        epoll_event event{};
        event.events = EPOLLIN;
        event.data.u32 = static_cast<std::uint32_t>(fd);
        ::epoll_ctl(epoll_, EPOLL_CTL_ADD, fd, &event);
    }

    void accept(int listener) {
        const int fd = ::accept4(listener, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
        if (fd < 0) return;
        const int on = 1;
        ::setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
        ++state_.connections;
        watch(fd, false);
    }

    void close(int fd) {
        connected_[static_cast<std::size_t>(fd)] = false;
        ::close(fd);
    }

    void drop_all() {
        const linger reset{.l_onoff = 1, .l_linger = 0};
        for (std::size_t fd = 0; fd < connected_.size(); ++fd) {
            if (!connected_[fd]) continue;
            ::setsockopt(static_cast<int>(fd), SOL_SOCKET, SO_LINGER, &reset, sizeof reset);
            close(static_cast<int>(fd));
        }
    }

    // A request is 12 bytes and comes in one piece: its sender is on the same machine.
    void answer(int fd) {
        std::array<std::uint8_t, 260> bytes;
        const ssize_t got = ::recv(fd, bytes.data(), bytes.size(), 0);
        if (got == 0 || (got < 0 && errno != EAGAIN)) return close(fd);
        for (std::size_t at = 0; at + 12 <= static_cast<std::size_t>(std::max<ssize_t>(got, 0)); at += 12)
            respond(fd, std::span(bytes).subspan(at, 12));
    }

    void respond(int fd, std::span<const std::uint8_t> request) {
        ++state_.requests;
        ++value_;
        const std::size_t registers = std::min<std::size_t>(request[11], 125);
        std::array<std::uint8_t, 260> frame{request[0], request[1]};
        frame[5] = static_cast<std::uint8_t>(3 + 2 * registers);
        frame[6] = request[6];
        frame[7] = request[7];
        frame[8] = static_cast<std::uint8_t>(2 * registers);
        for (std::size_t i = 0; i < registers; ++i) {
            frame[9 + 2 * i] = static_cast<std::uint8_t>(value_ >> 8);
            frame[10 + 2 * i] = static_cast<std::uint8_t>(value_);
        }
        if (::send(fd, frame.data(), 9 + 2 * registers, MSG_NOSIGNAL) < 0) close(fd);
    }

    FieldState& state_;
    int epoll_;
    std::vector<bool> is_listener_;  // by descriptor
    std::vector<bool> connected_;
    std::uint32_t drops_ = 0;
    std::uint16_t value_ = 0;
};

}  // namespace

std::string device_address(std::size_t device) {
    std::array<char, INET_ADDRSTRLEN> text{};
    const auto address = address_of(device, 0);
    ::inet_ntop(AF_INET, &address.sin_addr, text.data(), text.size());
    return text.data();
}

void pin_to_processor(int processor) {
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET(static_cast<std::size_t>(processor), &set);
    ::sched_setaffinity(0, sizeof set, &set);
}

Field::Field(std::size_t devices, int processor) {
    void* shared =
        ::mmap(nullptr, sizeof(FieldState), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (shared == MAP_FAILED) std::abort();
    state_ = new (shared) FieldState{};
    const std::size_t allowed = line::raise_descriptor_limit();
    const std::size_t most = allowed > kOwnDescriptors ? (allowed - kOwnDescriptors) / 2 : 1;
    for (std::size_t first = 0; first < devices && !state_->failed; first += most)
        start(first, std::min(first + most, devices), processor);
}

// A listening socket and a connection for each device.
void Field::start(std::size_t first, std::size_t end, int processor) {
    const pid_t process = ::fork();
    if (process == 0) {
        ::prctl(PR_SET_PDEATHSIG, SIGKILL);
        pin_to_processor(processor);
        Devices field(*state_);
        if (!field.listen(first, end)) {
            state_->failed = true;
            ::_exit(1);
        }
        field.serve();
    }
    processes_.push_back(process);
    while (state_->listening < end && !state_->failed) ::usleep(1000);
}

Field::~Field() {
    for (const pid_t process : processes_) {
        ::kill(process, SIGKILL);
        ::waitpid(process, nullptr, 0);
    }
    ::munmap(state_, sizeof(FieldState));
}

}  // namespace takt::bench
