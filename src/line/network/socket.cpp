#include "takt/line/socket.hpp"

#include <arpa/inet.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <memory>

#include "takt/line/target.hpp"

namespace takt::line {
namespace {

void set_option(int fd, int level, int name, int value) {
    ::setsockopt(fd, level, name, &value, sizeof value);
}

}  // namespace

std::uint16_t SocketAddress::port() const {
    if (family() == AF_INET6) return ntohs(reinterpret_cast<const sockaddr_in6*>(&storage)->sin6_port);
    return ntohs(reinterpret_cast<const sockaddr_in*>(&storage)->sin_port);
}

std::string SocketAddress::text() const {
    std::array<char, INET6_ADDRSTRLEN> text{};
    if (family() == AF_INET6) {
        const auto& address = reinterpret_cast<const sockaddr_in6*>(&storage)->sin6_addr;
        if (IN6_IS_ADDR_V4MAPPED(&address))
            inet_ntop(AF_INET, &address.s6_addr[12], text.data(), text.size());
        else
            inet_ntop(AF_INET6, &address, text.data(), text.size());
    } else {
        inet_ntop(AF_INET, &reinterpret_cast<const sockaddr_in*>(&storage)->sin_addr, text.data(),
                  text.size());
    }
    return host_and_port(text.data(), port());
}

Result<std::vector<SocketAddress>> resolve(const std::string& host, std::uint16_t port, bool numeric_only) {
    constexpr std::size_t kMost = 16;
    addrinfo hints{};
    hints.ai_socktype = SOCK_STREAM;
    hints.ai_flags = AI_NUMERICSERV | (numeric_only ? AI_NUMERICHOST : 0);
    addrinfo* list = nullptr;
    const int error = ::getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &list);
    if (error != 0) return fail(Code::cannot_open, host_and_port(host, port), error);
    const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> owner(list, &::freeaddrinfo);
    std::vector<SocketAddress> addresses;
    for (const addrinfo* entry = list; entry && addresses.size() < kMost; entry = entry->ai_next) {
        SocketAddress address;
        std::memcpy(&address.storage, entry->ai_addr, entry->ai_addrlen);
        address.length = entry->ai_addrlen;
        addresses.push_back(address);
    }
    return addresses;
}

Result<os::Descriptor> open_socket(int family) {
    os::Descriptor fd(::socket(family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, IPPROTO_TCP));
    if (!fd) return fail(Code::io_failed, "socket", errno);
    return fd;
}

void set_connection_options(int fd) {
    set_option(fd, IPPROTO_TCP, TCP_NODELAY, 1);
    set_option(fd, SOL_SOCKET, SO_KEEPALIVE, 1);
    set_option(fd, IPPROTO_TCP, TCP_KEEPIDLE, 10);
    set_option(fd, IPPROTO_TCP, TCP_KEEPINTVL, 3);
    set_option(fd, IPPROTO_TCP, TCP_KEEPCNT, 3);
    set_option(fd, IPPROTO_TCP, TCP_USER_TIMEOUT, 20'000);
}

bool is_connected_to_itself(int fd) {
    SocketAddress own, peer;
    own.length = peer.length = sizeof own.storage;
    if (::getsockname(fd, own.get(), &own.length) != 0 || ::getpeername(fd, peer.get(), &peer.length) != 0)
        return false;
    return own.length == peer.length && std::memcmp(&own.storage, &peer.storage, own.length) == 0;
}

Result<std::size_t> SocketStream::read(std::span<std::uint8_t> buffer) {
    const ssize_t got = ::recv(fd_.get(), buffer.data(), buffer.size(), 0);
    if (got > 0 && at_once_) set_option(fd_.get(), IPPROTO_TCP, TCP_QUICKACK, 1);  // the kernel resets it
    if (got > 0) return static_cast<std::size_t>(got);
    if (got < 0 && (errno == EAGAIN || errno == EINTR)) return 0;
    return fail(Code::connection_lost, peer_, got == 0 ? 0 : errno);
}

Result<std::size_t> SocketStream::write(Bytes bytes) {
    const ssize_t taken = ::send(fd_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (taken >= 0) return static_cast<std::size_t>(taken);
    if (errno == EAGAIN || errno == EINTR) return 0;
    return fail(Code::connection_lost, peer_, errno);
}

}  // namespace takt::line
