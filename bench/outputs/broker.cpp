#include "broker.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <fstream>

namespace takt::bench {
namespace {

using namespace std::chrono_literals;

constexpr auto kAwake = 5ms;
constexpr auto kAsleep = 95ms;

sockaddr_in loopback(std::uint16_t port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    return address;
}

bool is_listening(std::uint16_t port) {
    const int fd = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const sockaddr_in address = loopback(port);
    const bool connected = ::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
    ::close(fd);
    return connected;
}

[[noreturn]] void become_mosquitto(const char* configuration, const char* log) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    const int file = ::open(log, O_WRONLY | O_CREAT | O_APPEND, 0600);
    ::dup2(file, STDOUT_FILENO);
    ::dup2(file, STDERR_FILENO);
    const char* const installed = "/usr/sbin/mosquitto";  // not in the path of every user
    if (::access(installed, X_OK) == 0) ::execl(installed, "mosquitto", "-c", configuration, nullptr);
    ::execlp("mosquitto", "mosquitto", "-c", configuration, nullptr);
    ::_exit(127);
}

}  // namespace

std::uint16_t free_port() {
    const int fd = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address = loopback(0);
    socklen_t length = sizeof address;
    ::bind(fd, reinterpret_cast<sockaddr*>(&address), length);
    ::getsockname(fd, reinterpret_cast<sockaddr*>(&address), &length);
    ::close(fd);
    return ntohs(address.sin_port);
}

Broker::Broker(const WorkingFolder& folder) : folder_(folder), port_(free_port()) {
    // `user root`: as root, mosquitto else changes to a user that cannot read the folder.
    std::ofstream(folder_ / "broker.conf") << fmt::format(
        "user root\nlistener {} 127.0.0.1\nallow_anonymous true\npersistence false\n"
        "max_queued_messages 0\nmax_inflight_messages 100\nlog_type error\n",
        port_);
}

Broker::~Broker() {
    kill();
}

void Broker::start() {
    const std::string configuration = folder_ / "broker.conf";
    const std::string log = folder_ / "broker.log";
    process_ = ::fork();
    if (process_ == 0) become_mosquitto(configuration.c_str(), log.c_str());
    for (int i = 0; i < 1000; ++i) {
        if (is_listening(port_)) return;
        std::this_thread::sleep_for(10ms);
    }
    throw Failure("mosquitto does not start");
}

void Broker::kill() {
    wake();
    if (process_ < 0) return;
    send(SIGKILL);
    ::waitpid(process_, nullptr, 0);
    process_ = -1;
}

void Broker::send(int signal) const {
    if (process_ > 0) ::kill(process_, signal);
}

void Broker::slow_down() {
    wake();
    slow_ = true;
    brake_ = std::thread([this] {
        while (slow_) {
            send(SIGSTOP);
            std::this_thread::sleep_for(kAsleep);
            send(SIGCONT);
            std::this_thread::sleep_for(kAwake);
        }
    });
}

void Broker::freeze() {
    wake();
    send(SIGSTOP);
}

void Broker::wake() {
    slow_ = false;
    if (brake_.joinable()) brake_.join();
    send(SIGCONT);
}

}  // namespace takt::bench
