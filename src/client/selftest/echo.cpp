#include "selftest/echo.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdlib>

namespace takt::client {
namespace {

Result<void> set_nonblocking(int fd) {
    const int flags = ::fcntl(fd, F_GETFL);
    if (flags < 0 || ::fcntl(fd, F_SETFL, flags | O_NONBLOCK) != 0)
        return fail(Code::io_failed, "fcntl", errno);
    return {};
}

void send_at_once(int fd) {
    const int on = 1;
    (void)::setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
}

Result<void> set_raw(int fd) {
    termios settings{};
    if (::tcgetattr(fd, &settings) != 0) return fail(Code::io_failed, "tcgetattr", errno);
    ::cfmakeraw(&settings);
    if (::tcsetattr(fd, TCSANOW, &settings) != 0) return fail(Code::io_failed, "tcsetattr", errno);
    return {};
}

bool write_all(int fd, const std::uint8_t* bytes, std::size_t count) {
    while (count > 0) {
        const auto written = ::write(fd, bytes, count);
        if (written < 0 && errno == EINTR) continue;
        if (written <= 0) return false;
        bytes += written;
        count -= static_cast<std::size_t>(written);
    }
    return true;
}

// Of a pseudo-terminal whose other end is closed read() fails with EIO.
void echo(int fd) {
    std::array<std::uint8_t, 256> buffer{};
    for (;;) {
        const auto count = ::read(fd, buffer.data(), buffer.size());
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0 || !write_all(fd, buffer.data(), static_cast<std::size_t>(count))) return;
    }
}

}  // namespace

Result<Link> loopback_link() {
    const os::Descriptor listener(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t length = sizeof address;
    auto* const name = reinterpret_cast<sockaddr*>(&address);
    if (!listener || ::bind(listener.get(), name, length) != 0 || ::listen(listener.get(), 1) != 0 ||
        ::getsockname(listener.get(), name, &length) != 0)
        return fail(Code::io_failed, "listen", errno);
    Link link;
    link.near.reset(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    if (!link.near || ::connect(link.near.get(), name, length) != 0)
        return fail(Code::io_failed, "connect", errno);
    link.far.reset(::accept4(listener.get(), nullptr, nullptr, SOCK_CLOEXEC));
    if (!link.far) return fail(Code::io_failed, "accept", errno);
    send_at_once(link.near.get());
    send_at_once(link.far.get());
    TAKT_CHECK(set_nonblocking(link.near.get()));
    return link;
}

Result<Link> pty_link() {
    Link link;
    link.near.reset(::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC));
    std::array<char, 64> name{};
    if (!link.near || ::grantpt(link.near.get()) != 0 || ::unlockpt(link.near.get()) != 0 ||
        ::ptsname_r(link.near.get(), name.data(), name.size()) != 0)
        return fail(Code::io_failed, "posix_openpt", errno);
    link.far.reset(::open(name.data(), O_RDWR | O_NOCTTY | O_CLOEXEC));
    if (!link.far) return fail(Code::io_failed, name.data(), errno);
    TAKT_CHECK(set_raw(link.far.get()));
    TAKT_CHECK(set_nonblocking(link.near.get()));
    return link;
}

EchoPeer::EchoPeer(int far, const std::function<void()>& begin_thread)
    : thread_([far, begin_thread] {
          if (begin_thread) begin_thread();
          echo(far);
      }) {}

EchoPeer::~EchoPeer() {
    thread_.join();
}

Exchange::Exchange(line::Loop& loop, int near, Duration pace, LatencyStatistics& statistics)
    : near_(near),
      pace_(pace),
      statistics_(statistics),
      timer_(loop, [this](Instant t) { send(t); }),
      watch_(loop, near, [this] { receive(); }) {
    timer_.set(line::now() + pace);
}

void Exchange::send(Instant t) {
    timer_.set(t + pace_);
    if (missing_ > 0) return;
    const std::array<std::uint8_t, kBytes> request{};
    sent_at_ = line::now();
    if (!write_all(near_, request.data(), request.size())) return;
    missing_ = request.size();
    watch_.want_read();
}

void Exchange::receive() {
    std::array<std::uint8_t, kBytes> buffer{};
    const auto count = ::read(near_, buffer.data(), missing_);
    if (count > 0) missing_ -= static_cast<std::size_t>(count);
    if (missing_ > 0) return watch_.want_read();
    statistics_.record(line::now() - sent_at_);
}

}  // namespace takt::client
