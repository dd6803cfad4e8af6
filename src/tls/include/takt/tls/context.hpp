// Certificates of one side of TLS connections, and what it demands of the other side.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "takt/base/result.hpp"
#include "takt/model/tls_files.hpp"

struct ssl_ctx_st;  // OpenSSL's SSL_CTX and SSL
struct ssl_st;

namespace takt::tls {

enum class Side : std::uint8_t { client, server };

/// Certificates and keys that were read and fit together, shared by connections. TLS 1.2 and 1.3 with
/// authenticated encryption, certificates on both sides, no renegotiation, no compression. A server keeps the
/// sessions of its clients itself, so a resumed one has the role of the certificate that began it, and none
/// outlives the context. Unchanged after load(); connections on several threads may use it.
/// Source: Modbus/TCP Security v36, R-01 to.
class Context {
public:
    /// Reads the files.
    /// @returns with the file as subject: cannot_open, unsupported, io_failed, too_long (as
    ///          os::open_for_reading()); tls_failed (TlsFault::file, TlsFault::key)
    [[nodiscard]] static Result<std::shared_ptr<const Context>> load(Side side, const model::TlsFiles& files);

    /// A connection of this side before its handshake; nullptr: out of memory.
    [[nodiscard]] ssl_st* make_connection() const;
    [[nodiscard]] Side side() const { return side_; }
    /// A client: whom the server's certificate must name instead of the host; empty: the host.
    [[nodiscard]] const std::string& server_name() const { return server_name_; }

private:
    struct Free {
        void operator()(ssl_ctx_st* context) const;
    };

    explicit Context(Side side);

    void set_rules();
    [[nodiscard]] Result<void> trust(const model::TlsFiles& files);
    [[nodiscard]] Result<void> refuse_revoked(const std::string& crl);
    [[nodiscard]] Result<void> use_own(const model::TlsFiles& files);

    Side side_;
    std::string server_name_;
    std::unique_ptr<ssl_ctx_st, Free> context_;
};

}  // namespace takt::tls
