#include "takt/tls/context.hpp"

#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>

#include <utility>

#include "takt/os/open.hpp"

namespace takt::tls {
namespace {

// Suites of TLS 1.2 in the order of the specification: elliptic curves and AES-128 first; all
// of them with authenticated encryption. TLS 1.3 has its own, which are all of this
// kind.
constexpr const char* kSuites =
    "ECDHE-ECDSA-AES128-GCM-SHA256:ECDHE-RSA-AES128-GCM-SHA256:ECDHE-ECDSA-AES256-GCM-SHA384:"
    "ECDHE-RSA-AES256-GCM-SHA384:ECDHE-ECDSA-CHACHA20-POLY1305:ECDHE-RSA-CHACHA20-POLY1305";
constexpr const char* kGroups = "P-256:X25519:P-384";
constexpr std::size_t kMostBytes = 4 << 20;            // of a file: the bundles of systems have 300 KiB
constexpr long kMostSessions = 512;                    // that may be resumed; each has 12 KB
constexpr long kSessionSeconds = 600;
constexpr std::uint8_t kSessionId[] = "takt";  // a server that asks for certificates must have one

// The certificate, or its key, is too weak for the level of security.
bool is_weak() {
    const int reason = ERR_GET_REASON(ERR_peek_last_error());
    return reason == SSL_R_EE_KEY_TOO_SMALL || reason == SSL_R_CA_KEY_TOO_SMALL ||
           reason == SSL_R_CA_MD_TOO_WEAK;
}

template <auto free>
struct Freed {
    template <class T>
    void operator()(T* object) const {
        free(object);
    }
};
using Bio = std::unique_ptr<BIO, Freed<&BIO_free>>;
using Certificate = std::unique_ptr<X509, Freed<&X509_free>>;
using RevocationList = std::unique_ptr<X509_CRL, Freed<&X509_CRL_free>>;
using Key = std::unique_ptr<EVP_PKEY, Freed<&EVP_PKEY_free>>;

std::unexpected<Error> unusable(const std::string& file, TlsFault fault) {
    ERR_clear_error();
    return fail(Code::tls_failed, file, static_cast<std::int64_t>(fault));
}

Result<Bio> open_file(const std::string& path) {
    TAKT_TRY(const os::Descriptor fd, os::open_for_reading(path));
    auto bytes = os::read_all(fd.get(), path, kMostBytes);
    if (!bytes) {
        auto error = bytes.error();
        error.subject = std::string_view(path);
        return std::unexpected(error);
    }
    // The copy is the BIO's own, and a key is not left behind in memory.
    Bio copy(BIO_new(BIO_s_secmem()));
    if (copy) BIO_write(copy.get(), bytes->data(), static_cast<int>(bytes->size()));
    OPENSSL_cleanse(bytes->data(), bytes->size());
    return copy;
}

// OpenSSL would ask for a passphrase on the terminal.
int no_passphrase(char*, int, int, void*) {
    return -1;
}

// Calls `take` with each object of a kind in a file. @returns tls_failed: there is none, or a wrong one
template <class Object, class Read, class Take>
Result<void> for_each_object(const std::string& path, Read read, const Take& take) {
    TAKT_TRY(const Bio file, open_file(path));
    bool any = false;
    while (Object object{read(file.get(), nullptr, no_passphrase, nullptr)}) {
        if (!take(object.get())) return unusable(path, is_weak() ? TlsFault::algorithms : TlsFault::file);
        any = true;
    }
    const auto end = ERR_peek_last_error();
    if (!any || ERR_GET_REASON(end) != PEM_R_NO_START_LINE) return unusable(path, TlsFault::file);
    ERR_clear_error();
    return {};
}

}  // namespace

void Context::Free::operator()(ssl_ctx_st* context) const {
    SSL_CTX_free(context);
}

Context::Context(Side side)
    : side_(side), context_(SSL_CTX_new(side == Side::client ? TLS_client_method() : TLS_server_method())) {}

Result<std::shared_ptr<const Context>> Context::load(Side side, const model::TlsFiles& files) {
    std::shared_ptr<Context> context(new Context(side));
    if (!context->context_) return fail(Code::tls_failed, "OpenSSL", static_cast<int>(TlsFault::other));
    ERR_clear_error();
    context->set_rules();
    context->server_name_ = files.server_name;
    TAKT_CHECK(context->trust(files));
    TAKT_CHECK(context->use_own(files));
    return context;
}

void Context::set_rules() {
    SSL_CTX* const context = context_.get();
    SSL_CTX_set_min_proto_version(context, TLS1_2_VERSION);
    SSL_CTX_set_cipher_list(context, kSuites);
    SSL_CTX_set1_groups_list(context, kGroups);
    // An end without notice is none to worry about: frames of Modbus tell when they are complete.
    SSL_CTX_set_options(context, SSL_OP_IGNORE_UNEXPECTED_EOF | SSL_OP_NO_RENEGOTIATION |
                                     SSL_OP_NO_COMPRESSION | SSL_OP_CIPHER_SERVER_PREFERENCE |
                                     SSL_OP_NO_TICKET);
    SSL_CTX_set_mode(context, SSL_MODE_ENABLE_PARTIAL_WRITE | SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER |
                                  SSL_MODE_RELEASE_BUFFERS);
    SSL_CTX_set_verify(context, SSL_VERIFY_PEER | SSL_VERIFY_FAIL_IF_NO_PEER_CERT, nullptr);
    if (side_ == Side::client) return;
    SSL_CTX_set_session_id_context(context, kSessionId, sizeof kSessionId - 1);
    SSL_CTX_sess_set_cache_size(context, kMostSessions);
    SSL_CTX_set_timeout(context, kSessionSeconds);
}

Result<void> Context::trust(const model::TlsFiles& files) {
    X509_STORE* const store = SSL_CTX_get_cert_store(context_.get());
    TAKT_CHECK(for_each_object<Certificate>(files.ca, PEM_read_bio_X509, [&](X509* root) {
        // A server names the roots that it accepts.
        return X509_STORE_add_cert(store, root) == 1 &&
               (side_ == Side::client || SSL_CTX_add_client_CA(context_.get(), root) == 1);
    }));
    return files.crl.empty() ? Result<void>() : refuse_revoked(files.crl);
}

Result<void> Context::refuse_revoked(const std::string& crl) {
    X509_STORE* const store = SSL_CTX_get_cert_store(context_.get());
    X509_STORE_set_flags(store, X509_V_FLAG_CRL_CHECK | X509_V_FLAG_CRL_CHECK_ALL);
    return for_each_object<RevocationList>(
        crl, PEM_read_bio_X509_CRL, [&](X509_CRL* list) { return X509_STORE_add_crl(store, list) == 1; });
}

Result<void> Context::use_own(const model::TlsFiles& files) {
    SSL_CTX* const context = context_.get();
    bool own = true;
    TAKT_CHECK(for_each_object<Certificate>(files.certificate, PEM_read_bio_X509, [&](X509* certificate) {
        if (!std::exchange(own, false)) return SSL_CTX_add1_chain_cert(context, certificate) == 1;
        return SSL_CTX_use_certificate(context, certificate) == 1;
    }));
    TAKT_TRY(const Bio file, open_file(files.key));
    const Key key(PEM_read_bio_PrivateKey(file.get(), nullptr, no_passphrase, nullptr));
    if (!key) return unusable(files.key, TlsFault::file);
    if (SSL_CTX_use_PrivateKey(context, key.get()) != 1 || SSL_CTX_check_private_key(context) != 1)
        return unusable(files.key, TlsFault::key);
    // The whole chain with its root is sent, where the own root is among the trusted ones.
    SSL_CTX_build_cert_chain(context, SSL_BUILD_CHAIN_FLAG_UNTRUSTED | SSL_BUILD_CHAIN_FLAG_IGNORE_ERROR |
                                          SSL_BUILD_CHAIN_FLAG_CLEAR_ERROR);
    ERR_clear_error();
    return {};
}

ssl_st* Context::make_connection() const {
    return SSL_new(context_.get());
}

}  // namespace takt::tls
