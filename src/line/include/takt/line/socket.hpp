// TCP sockets: addresses, options, non-blocking bytes.
#pragma once

#include <sys/socket.h>

#include <string>
#include <utility>
#include <vector>

#include "takt/base/result.hpp"
#include "takt/line/byte_stream.hpp"
#include "takt/os/descriptor.hpp"

namespace takt::line {

/// A numeric address with its port.
struct SocketAddress {
    sockaddr_storage storage{};
    socklen_t length = 0;

    [[nodiscard]] const sockaddr* get() const { return reinterpret_cast<const sockaddr*>(&storage); }
    [[nodiscard]] sockaddr* get() { return reinterpret_cast<sockaddr*>(&storage); }
    [[nodiscard]] int family() const { return storage.ss_family; }
    /// "10.0.0.5:502", "[::1]:502"; an IPv4 address inside IPv6 as IPv4.
    [[nodiscard]] std::string text() const;
    [[nodiscard]] std::uint16_t port() const;
};

/// The addresses of a host in the order to try, at most 16. Blocks for as long as the name service needs,
/// except with `numeric_only`, where a name is an error.
/// @returns cannot_open (host:port, the negative error number of getaddrinfo)
[[nodiscard]] Result<std::vector<SocketAddress>> resolve(const std::string& host, std::uint16_t port,
                                                         bool numeric_only);

/// A new non-blocking TCP socket. @returns io_failed ("socket", errno)
[[nodiscard]] Result<os::Descriptor> open_socket(int family);

/// Options of a connection: TCP_NODELAY, and keep-alive probes that detect a lost peer within about 20 s.
void set_connection_options(int fd);

/// Whether the connection is one to its own socket: TCP simultaneous open on a closed local port.
[[nodiscard]] bool is_connected_to_itself(int fd);

/// A connected socket.
class SocketStream final : public ByteStream {
public:
    SocketStream(os::Descriptor fd, std::string peer) : fd_(std::move(fd)), peer_(std::move(peer)) {}

    [[nodiscard]] int fd() const override { return fd_.get(); }
    /// connection_lost (peer, errno; 0: the peer closed it)
    [[nodiscard]] Result<std::size_t> read(std::span<std::uint8_t> buffer) override;
    [[nodiscard]] Result<std::size_t> write(Bytes bytes) override;
    [[nodiscard]] const std::string& peer() const { return peer_; }

    /// Acknowledges each segment when it is read, not up to 40 ms later (tcp(7), TCP_QUICKACK). A peer
    /// without TCP_NODELAY keeps its next frame until then, or until a request is sent: every response would
    /// be received right after the next request.
    void acknowledge_at_once() { at_once_ = true; }

private:
    bool at_once_ = false;
    os::Descriptor fd_;
    std::string peer_;
};

}  // namespace takt::line
