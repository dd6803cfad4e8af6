#include "servers.hpp"

#include <arpa/inet.h>
#include <modbus/modbus.h>
#include <netinet/tcp.h>
#include <sched.h>
#include <sys/epoll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <string>
#include <unordered_map>
#include <vector>

#include "takt/line/slave_session.hpp"
#include "takt/line/tcp_server.hpp"
#include "takt/sim/devices.hpp"

namespace bench {
namespace {

constexpr std::size_t kMostConnections = 20'000;
constexpr int kEvents = 64;
constexpr std::size_t kReadAtOnce = 4096;

using Ready = std::function<void(std::uint16_t port)>;

void serve_takt(const Ready& ready) {
    using namespace takt;
    const auto loop = std::move(line::Loop::create()).value();
    sim::Devices devices(UnitId{1}, sim::Fill::ramp);
    line::SlaveSessions sessions;
    line::TcpServerOptions options;
    options.max_connections = kMostConnections;
    const auto factory = [&](Instant, const line::Peer& peer) {
        serve::TcpConfig config;
        config.peer.assign(peer.address);
        return std::make_unique<line::SlaveSession>(config, devices, sessions);
    };
    const auto server = std::move(line::TcpServer::listen(*loop, {"127.0.0.1", 0}, factory, options)).value();
    ready(server->port());
    loop->run();
}

std::uint16_t port_of(int listener) {
    sockaddr_in address{};
    socklen_t length = sizeof address;
    ::getsockname(listener, reinterpret_cast<sockaddr*>(&address), &length);
    return ntohs(address.sin_port);
}

void watch(int epoll, int fd, std::uint32_t events, int operation) {
    epoll_event event{};
    event.events = events;
    event.data.fd = fd;
    ::epoll_ctl(epoll, operation, fd, &event);
}

/// Waits for connections and their bytes; `readable` and `writable` close what they are done with.
void epoll_loop(int listener, bool blocking,
                const std::function<void(int epoll, int fd, std::uint32_t events)>& act) {
    const int epoll = ::epoll_create1(0);
    watch(epoll, listener, EPOLLIN, EPOLL_CTL_ADD);
    epoll_event events[kEvents];
    for (;;) {
        const int count = ::epoll_wait(epoll, events, kEvents, -1);
        for (int i = 0; i < count; ++i) {
            if (events[i].data.fd != listener) {
                act(epoll, events[i].data.fd, events[i].events);
                continue;
            }
            const int fd = ::accept4(listener, nullptr, nullptr, blocking ? 0 : SOCK_NONBLOCK);
            if (fd < 0) continue;
            const int on = 1;
            ::setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
            watch(epoll, fd, EPOLLIN, EPOLL_CTL_ADD);
        }
    }
}

/// One connection of the echo.
struct Echo {
    std::size_t received = 0;  // bytes of a request that is not whole
    std::size_t owed = 0;      // bytes of answers not yet taken
};

void serve_echo(Sizes sizes, const Ready& ready) {
    const int listener = ::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    ::bind(listener, reinterpret_cast<const sockaddr*>(&address), sizeof address);
    ::listen(listener, SOMAXCONN);
    ready(port_of(listener));
    std::unordered_map<int, Echo> echoes;
    std::vector<char> buffer(kReadAtOnce);
    const std::vector<char> answers((kReadAtOnce / sizes.request + 1) * sizes.response);
    epoll_loop(listener, false, [&](int epoll, int fd, std::uint32_t events) {
        Echo& echo = echoes[fd];
        if ((events & EPOLLOUT) == 0) {
            const ssize_t got = ::recv(fd, buffer.data(), buffer.size(), 0);
            if (got == 0 || (got < 0 && errno != EAGAIN)) {
                ::close(fd);
                echoes.erase(fd);
                return;
            }
            echo.received += static_cast<std::size_t>(std::max<ssize_t>(got, 0));
            echo.owed += echo.received / sizes.request * sizes.response;
            echo.received %= sizes.request;
        }
        if (echo.owed == 0) return;
        const ssize_t sent = ::send(fd, answers.data(), std::min(echo.owed, answers.size()), MSG_NOSIGNAL);
        if (sent > 0) echo.owed -= static_cast<std::size_t>(sent);
        if (echo.owed > 0)
            watch(epoll, fd, EPOLLOUT, EPOLL_CTL_MOD);
        else if ((events & EPOLLOUT) != 0)
            watch(epoll, fd, EPOLLIN, EPOLL_CTL_MOD);
    });
}

void serve_libmodbus(const Ready& ready) {
    constexpr int kItems = 10'000;
    constexpr int kBacklog = 1024;
    modbus_t* bus = modbus_new_tcp("127.0.0.1", 0);
    modbus_mapping_t* map = modbus_mapping_new(kItems, kItems, kItems, kItems);
    for (int a = 0; a < kItems; ++a) map->tab_registers[a] = static_cast<std::uint16_t>(a);
    const int listener = modbus_tcp_listen(bus, kBacklog);
    ready(port_of(listener));
    epoll_loop(listener, true, [&](int, int fd, std::uint32_t) {
        std::uint8_t query[MODBUS_TCP_MAX_ADU_LENGTH];
        modbus_set_socket(bus, fd);
        const int size = modbus_receive(bus, query);
        if (size > 0) modbus_reply(bus, query, size, map);
        if (size < 0) ::close(fd);
    });
}

[[noreturn]] void serve(Kind kind, Sizes sizes, int port_pipe) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    pin_to(1);
    const Ready ready = [port_pipe](std::uint16_t port) {
        if (::write(port_pipe, &port, sizeof port) != sizeof port) std::_Exit(1);
        ::close(port_pipe);
    };
    switch (kind) {
        case Kind::takt: serve_takt(ready); break;
        case Kind::echo: serve_echo(sizes, ready); break;
        case Kind::libmodbus: serve_libmodbus(ready); break;
    }
    std::_Exit(1);
}

}  // namespace

std::string_view name(Kind kind) {
    constexpr std::array<std::string_view, kKinds.size()> kNames{"takt", "echo", "libmodbus"};
    return kNames[static_cast<std::size_t>(kind)];
}

ServerProcess::ServerProcess(Kind kind, Sizes sizes) {
    int ends[2] = {-1, -1};
    if (::pipe(ends) != 0) std::abort();
    std::fflush(nullptr);
    pid_ = ::fork();
    if (pid_ == 0) {
        ::close(ends[0]);
        serve(kind, sizes, ends[1]);
    }
    ::close(ends[1]);
    if (::read(ends[0], &port_, sizeof port_) != sizeof port_) {
        std::fprintf(stderr, "%s: the server does not start\n", std::string(name(kind)).c_str());
        std::exit(1);
    }
    ::close(ends[0]);
}

ServerProcess::~ServerProcess() {
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
}

std::size_t ServerProcess::resident() const {
    std::ifstream file("/proc/" + std::to_string(pid_) + "/statm");
    std::size_t all = 0;
    std::size_t resident = 0;
    std::size_t shared = 0;
    file >> all >> resident >> shared;
    return (resident - shared) * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

double ServerProcess::processor_s() const {
    std::ifstream file("/proc/" + std::to_string(pid_) + "/stat");
    std::string word;
    double ticks = 0;
    constexpr int kUser = 14;
    constexpr int kSystem = 15;
    for (int field = 1; field <= kSystem && file >> word; ++field)
        if (field >= kUser) ticks += std::stod(word);
    return ticks / static_cast<double>(::sysconf(_SC_CLK_TCK));
}

void pin_to(unsigned processor) {
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET(processor, &set);
    ::sched_setaffinity(0, sizeof set, &set);  // on a machine with one processor it stays where it is
}

std::size_t raise_descriptors() {
    rlimit limit{};
    ::getrlimit(RLIMIT_NOFILE, &limit);
    limit.rlim_cur = limit.rlim_max;
    ::setrlimit(RLIMIT_NOFILE, &limit);
    return limit.rlim_cur;
}

}  // namespace bench
