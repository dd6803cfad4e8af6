// TLS on one connected socket.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "takt/base/engine.hpp"
#include "takt/base/result.hpp"
#include "takt/tls/context.hpp"

struct ssl_st;  // OpenSSL's SSL

namespace takt::tls {

/// TLS on a connected, non-blocking socket that the caller owns. No call waits. The program
/// must ignore SIGPIPE, which OpenSSL's writing to a closed socket raises. One owner, one thread.
///
/// Errors: tls_failed (peer, TlsFault), connection_lost (peer, the system's error number; 0: the peer closed
/// it). After one the connection is of no use.
class Connection {
public:
    enum class Progress : std::uint8_t { done, wants_read, wants_write };

    /// @param host  a client: the server's name or address, sent as the name of the server (RFC 6066) and
    ///              demanded of its certificate, unless the context has another name
    /// @param peer  the subject of errors
    [[nodiscard]] static Result<Connection> begin(std::shared_ptr<const Context> context, int socket,
                                                  const std::string& host, std::string peer);

    Connection(Connection&&) noexcept = default;
    Connection& operator=(Connection&&) = delete;
    /// Sends the peer a closing notice, unless the socket would have to wait. The socket must still be open.
    ~Connection();

    /// Goes on with the handshake, by at most the messages that are there: about one signature and one check
    /// of a certificate chain of work.
    [[nodiscard]] Result<Progress> handshake();

    /// Reads decrypted bytes, at most buffer.size() > 0. @returns their number, 0: none now
    [[nodiscard]] Result<std::size_t> read(std::span<std::uint8_t> buffer);
    /// @returns how many bytes were taken, possibly 0. The rest must be offered again, from its beginning
    [[nodiscard]] Result<std::size_t> write(Bytes bytes);
    /// Whether decrypted bytes wait that no event of the socket will announce.
    [[nodiscard]] bool has_buffered() const;

    /// Of the peer's certificate, after the handshake. Of a resumed session: that of the one which began it.
    [[nodiscard]] const std::string& role() const { return role_; }

private:
    struct Free {
        void operator()(ssl_st* ssl) const;
    };

    Connection(std::shared_ptr<const Context> context, std::unique_ptr<ssl_st, Free> ssl, std::string peer)
        : context_(std::move(context)), ssl_(std::move(ssl)), peer_(std::move(peer)) {}

    [[nodiscard]] Error failure(int result);

    std::shared_ptr<const Context> context_;
    std::unique_ptr<ssl_st, Free> ssl_;
    std::string peer_;
    std::string role_;
    bool open_ = false;  // the handshake is done, and nothing has failed since
};

}  // namespace takt::tls
