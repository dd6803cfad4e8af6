#include "peers.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <utility>

#include "../working_folder.hpp"
#include "takt/os/realtime.hpp"

namespace takt::bench {
namespace {

using Clock = std::chrono::steady_clock;
constexpr auto kStartLimit = std::chrono::seconds(10);

sockaddr_in loopback(std::uint16_t port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(port);
    return address;
}

void send_at_once(int fd) {
    const int on = 1;
    (void)::setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
}

/// Listens on a free port. @returns it
std::uint16_t listen_on(const os::Descriptor& socket) {
    auto address = loopback(0);
    socklen_t length = sizeof address;
    auto* const name = reinterpret_cast<sockaddr*>(&address);
    if (!socket || ::bind(socket.get(), name, length) != 0 || ::listen(socket.get(), 1) != 0 ||
        ::getsockname(socket.get(), name, &length) != 0)
        throw Failure(std::string("cannot listen: ") + std::strerror(errno));
    return ntohs(address.sin_port);
}

os::Descriptor connect_to(std::uint16_t port) {
    const auto address = loopback(port);
    const auto limit = Clock::now() + kStartLimit;
    while (Clock::now() < limit) {
        check_interrupted();
        os::Descriptor socket(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
        if (::connect(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) {
            send_at_once(socket.get());
            return socket;
        }
        ::usleep(10'000);
    }
    throw Failure("the peer does not listen");
}

[[noreturn]] void run_echo(int listener, const PeerOptions& options) {
    (void)os::become_realtime(
        {.priority = options.realtime ? std::optional(49) : std::nullopt, .cpu = options.cpu});
    const int fd = ::accept(listener, nullptr, nullptr);
    send_at_once(fd);
    std::array<std::uint8_t, 512> buffer{};
    for (;;) {
        const auto count = ::read(fd, buffer.data(), buffer.size());
        if (count <= 0 || ::write(fd, buffer.data(), static_cast<std::size_t>(count)) != count) ::_exit(0);
    }
}

[[noreturn]] void run_takt(std::uint16_t port, const PeerOptions& options) {
    const auto takt = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "takt";
    std::vector<std::string> words{"takt",     "serve",
                                   "--listen", "127.0.0.1:" + std::to_string(port),
                                   "--cpu",    std::to_string(options.cpu)};
    if (options.realtime) words.emplace_back("--realtime");
    if (options.spin) {
        words.emplace_back("--spin");
        words.push_back(std::to_string(options.spin->count()) + "us");
    }
    std::vector<char*> arguments;
    for (auto& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    const int silent = ::open("/dev/null", O_RDWR);
    for (const int fd : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) ::dup2(silent, fd);
    ::execv(takt.c_str(), arguments.data());
    ::_exit(127);
}

/// A child that ends with its parent.
pid_t fork_child() {
    const pid_t process = ::fork();
    if (process < 0) throw Failure(std::string("fork: ") + std::strerror(errno));
    if (process == 0) ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    return process;
}

}  // namespace

Peer Peer::echo(const PeerOptions& options) {
    const os::Descriptor listener(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    const auto port = listen_on(listener);
    const pid_t process = fork_child();
    if (process == 0) run_echo(listener.get(), options);
    return {process, connect_to(port)};
}

Peer Peer::takt(const PeerOptions& options) {
    std::uint16_t port = 0;
    {
        const os::Descriptor probe(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
        port = listen_on(probe);
    }
    const pid_t process = fork_child();
    if (process == 0) run_takt(port, options);
    return {process, connect_to(port)};
}

Peer::Peer(Peer&& other) noexcept
    : process_(std::exchange(other.process_, -1)), socket_(std::move(other.socket_)) {}

Peer::~Peer() {
    if (process_ < 0) return;
    ::kill(process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
}

std::chrono::nanoseconds Peer::exchange(const std::vector<std::uint8_t>& request,
                                        std::size_t expected) const {
    std::array<std::uint8_t, 512> buffer{};
    const auto sent_at = Clock::now();
    if (::write(socket_.get(), request.data(), request.size()) != static_cast<ssize_t>(request.size()))
        throw Failure("the peer has ended");
    for (std::size_t received = 0; received < expected;) {
        const auto count = ::read(socket_.get(), buffer.data(), buffer.size());
        if (count <= 0) throw Failure("the peer has ended");
        received += static_cast<std::size_t>(count);
    }
    return Clock::now() - sent_at;
}

}  // namespace takt::bench
