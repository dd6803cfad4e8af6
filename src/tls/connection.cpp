#include "takt/tls/connection.hpp"

#include <openssl/err.h>
#include <openssl/ssl.h>
#include <openssl/x509v3.h>

#include <cerrno>
#include <utility>

#include "role.hpp"
#include "takt/base/network.hpp"

namespace takt::tls {
namespace {

TlsFault fault_of_certificate(long verification) {
    switch (verification) {
        case X509_V_ERR_CERT_HAS_EXPIRED: return TlsFault::expired;
        case X509_V_ERR_CERT_NOT_YET_VALID: return TlsFault::not_yet_valid;
        case X509_V_ERR_CERT_REVOKED: return TlsFault::revoked;
        case X509_V_ERR_HOSTNAME_MISMATCH:
        case X509_V_ERR_IP_ADDRESS_MISMATCH: return TlsFault::other_name;
        case X509_V_ERR_INVALID_PURPOSE: return TlsFault::purpose;
        case X509_V_ERR_UNABLE_TO_GET_CRL:
        case X509_V_ERR_CRL_HAS_EXPIRED:
        case X509_V_ERR_CRL_NOT_YET_VALID:
        case X509_V_ERR_CRL_SIGNATURE_FAILURE: return TlsFault::revocation_list;
        case X509_V_ERR_UNABLE_TO_GET_ISSUER_CERT:
        case X509_V_ERR_UNABLE_TO_GET_ISSUER_CERT_LOCALLY:
        case X509_V_ERR_UNABLE_TO_VERIFY_LEAF_SIGNATURE:
        case X509_V_ERR_DEPTH_ZERO_SELF_SIGNED_CERT:
        case X509_V_ERR_SELF_SIGNED_CERT_IN_CHAIN:
        case X509_V_ERR_CERT_SIGNATURE_FAILURE:
        case X509_V_ERR_CERT_UNTRUSTED: return TlsFault::untrusted;
        case X509_V_ERR_EE_KEY_TOO_SMALL:
        case X509_V_ERR_CA_KEY_TOO_SMALL:
        case X509_V_ERR_CA_MD_TOO_WEAK: return TlsFault::algorithms;
        default: return TlsFault::other;
    }
}

// RFC 8446, 6.2
TlsFault fault_of_alert(int alert) {
    switch (alert) {
        case SSL_AD_HANDSHAKE_FAILURE:
        case SSL_AD_INSUFFICIENT_SECURITY: return TlsFault::algorithms;
        case SSL_AD_CERTIFICATE_REVOKED: return TlsFault::refused_revoked;
        case SSL_AD_CERTIFICATE_EXPIRED: return TlsFault::refused_expired;
        case SSL_AD_UNKNOWN_CA: return TlsFault::refused_untrusted;
        case SSL_AD_BAD_CERTIFICATE:
        case SSL_AD_UNSUPPORTED_CERTIFICATE:
        case SSL_AD_CERTIFICATE_UNKNOWN:
        case SSL_AD_ACCESS_DENIED:
        case SSL_AD_CERTIFICATE_REQUIRED: return TlsFault::refused;
        case SSL_AD_PROTOCOL_VERSION: return TlsFault::version;
        default: return TlsFault::other;
    }
}

TlsFault fault_of_reason(int reason) {
    if (reason >= SSL_AD_REASON_OFFSET) return fault_of_alert(reason - SSL_AD_REASON_OFFSET);
    switch (reason) {
        case SSL_R_WRONG_VERSION_NUMBER:
        case SSL_R_HTTP_REQUEST:
        case SSL_R_HTTPS_PROXY_REQUEST:
        case SSL_R_PACKET_LENGTH_TOO_LONG:
        case SSL_R_BAD_RECORD_TYPE: return TlsFault::not_tls;
        case SSL_R_UNSUPPORTED_PROTOCOL:
        case SSL_R_NO_PROTOCOLS_AVAILABLE: return TlsFault::version;
        case SSL_R_NO_SHARED_CIPHER:
        case SSL_R_NO_SUITABLE_SIGNATURE_ALGORITHM: return TlsFault::algorithms;
        case SSL_R_PEER_DID_NOT_RETURN_A_CERTIFICATE: return TlsFault::no_certificate;
        default: return TlsFault::other;
    }
}

// A peer that ends inside the handshake mostly does not know TLS.
Error of_handshake(Error error) {
    if (error.code != Code::connection_lost) return error;
    return {Code::tls_failed, error.subject, {static_cast<int>(TlsFault::not_tls), 0, 0}};
}

// RFC 6066, 3: an address is no name of a server.
bool expect(SSL* ssl, const std::string& host, const std::string& name) {
    SSL_set_hostflags(ssl, X509_CHECK_FLAG_NO_PARTIAL_WILDCARDS | X509_CHECK_FLAG_NEVER_CHECK_SUBJECT);
    if (!parse_ip(host) && SSL_set_tlsext_host_name(ssl, host.c_str()) != 1) return false;
    if (!parse_ip(name)) return SSL_set1_host(ssl, name.c_str()) == 1;
    return X509_VERIFY_PARAM_set1_ip_asc(SSL_get0_param(ssl), name.c_str()) == 1;
}

}  // namespace

void Connection::Free::operator()(ssl_st* ssl) const {
    SSL_free(ssl);
}

Result<Connection> Connection::begin(std::shared_ptr<const Context> context, int socket,
                                     const std::string& host, std::string peer) {
    Connection made(std::move(context), nullptr, std::move(peer));
    made.ssl_.reset(made.context_->make_connection());
    SSL* const ssl = made.ssl_.get();
    bool ready = ssl != nullptr && SSL_set_fd(ssl, socket) == 1;
    if (ready && made.context_->side() == Side::server) SSL_set_accept_state(ssl);
    if (ready && made.context_->side() == Side::client) {
        SSL_set_connect_state(ssl);
        const auto& other = made.context_->server_name();
        ready = expect(ssl, host, other.empty() ? host : other);
    }
    ERR_clear_error();
    if (!ready) return fail(Code::tls_failed, made.peer_, static_cast<int>(TlsFault::other));
    return made;
}

Connection::~Connection() {
    if (ssl_ && open_) SSL_shutdown(ssl_.get());
    ERR_clear_error();
}

Result<Connection::Progress> Connection::handshake() {
    ERR_clear_error();
    const int result = SSL_do_handshake(ssl_.get());
    switch (result == 1 ? SSL_ERROR_NONE : SSL_get_error(ssl_.get(), result)) {
        case SSL_ERROR_NONE: break;
        case SSL_ERROR_WANT_READ: return Progress::wants_read;
        case SSL_ERROR_WANT_WRITE: return Progress::wants_write;
        default: break;
    }
    if (result != 1) return std::unexpected(of_handshake(failure(result)));
    const X509* const certificate = SSL_get0_peer_certificate(ssl_.get());
    const auto fault = [&](TlsFault what) {
        return std::unexpected(
            Error{Code::tls_failed, std::string_view(peer_), {static_cast<int>(what), 0, 0}});
    };
    if (certificate == nullptr) return fault(TlsFault::no_certificate);
    // OpenSSL checks the certificate of a session when it begins, not when it is resumed.
    if (X509_cmp_current_time(X509_get0_notAfter(certificate)) <= 0) return fault(TlsFault::expired);
    role_ = role_of(*certificate);
    open_ = true;
    return Progress::done;
}

// Errors of the system are in errno, so nothing may come between the call and this one.
Error Connection::failure(int result) {
    const int system = errno;
    const auto lost = [&](int number) {
        return Error{Code::connection_lost, std::string_view(peer_), {number, 0, 0}};
    };
    const int kind = SSL_get_error(ssl_.get(), result);
    open_ = open_ && kind == SSL_ERROR_ZERO_RETURN;
    const int reason = ERR_GET_REASON(ERR_peek_error());
    const long verification = SSL_get_verify_result(ssl_.get());
    ERR_clear_error();
    if (kind == SSL_ERROR_ZERO_RETURN) return lost(0);  // the other direction stays open
    if (kind == SSL_ERROR_SYSCALL) return lost(system);
    const auto fault = reason == SSL_R_CERTIFICATE_VERIFY_FAILED ? fault_of_certificate(verification)
                                                                 : fault_of_reason(reason);
    return {Code::tls_failed, std::string_view(peer_), {static_cast<std::int64_t>(fault), 0, 0}};
}

Result<std::size_t> Connection::read(std::span<std::uint8_t> buffer) {
    ERR_clear_error();
    std::size_t count = 0;
    const int result = SSL_read_ex(ssl_.get(), buffer.data(), buffer.size(), &count);
    if (result == 1) return count;
    const int kind = SSL_get_error(ssl_.get(), result);
    if (kind == SSL_ERROR_WANT_READ || kind == SSL_ERROR_WANT_WRITE) return 0;
    return std::unexpected(failure(result));
}

Result<std::size_t> Connection::write(Bytes bytes) {
    ERR_clear_error();
    std::size_t count = 0;
    const int result = SSL_write_ex(ssl_.get(), bytes.data(), bytes.size(), &count);
    if (result == 1) return count;
    const int kind = SSL_get_error(ssl_.get(), result);
    if (kind == SSL_ERROR_WANT_READ || kind == SSL_ERROR_WANT_WRITE) return 0;
    const Error lost = failure(result);
    // A peer that refuses the certificate says so before it closes (in TLS 1.3 after the handshake).
    std::uint8_t none = 0;
    const auto said = read({&none, 1});
    return std::unexpected(!said && said.error().code == Code::tls_failed ? said.error() : lost);
}

bool Connection::has_buffered() const {
    return SSL_pending(ssl_.get()) > 0;  // of one record; no further one is read ahead
}

}  // namespace takt::tls
