#include "mqtt/broker_tls.hpp"

#include <arpa/inet.h>
#include <openssl/err.h>
#include <openssl/ssl.h>
#include <openssl/x509_vfy.h>
#include <openssl/x509v3.h>

#include <array>
#include <cstring>
#include <vector>

#include "mqtt/file_reason.hpp"
#include "takt/file/read.hpp"

namespace takt::publish {
namespace {

MqttFailureKind kind_of(int verify_error) {
    switch (verify_error) {
        case X509_V_ERR_CERT_HAS_EXPIRED:
        case X509_V_ERR_CERT_NOT_YET_VALID: return MqttFailureKind::tls_expired;
        case X509_V_ERR_HOSTNAME_MISMATCH:
        case X509_V_ERR_IP_ADDRESS_MISMATCH: return MqttFailureKind::tls_other_name;
        case X509_V_ERR_UNABLE_TO_GET_ISSUER_CERT:
        case X509_V_ERR_UNABLE_TO_GET_ISSUER_CERT_LOCALLY:
        case X509_V_ERR_UNABLE_TO_VERIFY_LEAF_SIGNATURE:
        case X509_V_ERR_DEPTH_ZERO_SELF_SIGNED_CERT:
        case X509_V_ERR_SELF_SIGNED_CERT_IN_CHAIN:
        case X509_V_ERR_CERT_UNTRUSTED: return MqttFailureKind::tls_unknown_issuer;
        default: return MqttFailureKind::tls;
    }
}

bool is_address(const std::string& host) {
    std::array<unsigned char, sizeof(in6_addr)> address{};
    return inet_pton(AF_INET, host.c_str(), address.data()) == 1 ||
           inet_pton(AF_INET6, host.c_str(), address.data()) == 1;
}

std::string alert_text(int alert) {
    // OpenSSL 3.0 has no text for this alert of TLS 1.3.
    if ((alert & 0xFF) == SSL_AD_CERTIFICATE_REQUIRED) return "the broker reports: certificate required";
    return std::string("the broker reports: ") + SSL_alert_desc_string_long(alert);
}

}  // namespace

void BrokerTls::Free::operator()(SSL_CTX* context) const {
    SSL_CTX_free(context);
}

BrokerTls::BrokerTls(const MqttTls& files, const std::string& host)
    : host_(host), host_is_address_(is_address(host)), context_(SSL_CTX_new(TLS_client_method())) {
    if (!context_) {
        failure_ = MqttFailure{MqttFailureKind::local, {}, "SSL_CTX_new"};
        return;
    }
    SSL_CTX_set_min_proto_version(context_.get(), TLS1_2_VERSION);
    SSL_CTX_set_app_data(context_.get(), this);
    SSL_CTX_set_verify(context_.get(), SSL_VERIFY_PEER, on_certificate);
    SSL_CTX_set_info_callback(context_.get(), on_state);
    check_host();
    ERR_clear_error();
    if (!load(files)) context_.reset();
    ERR_clear_error();
}

BrokerTls::~BrokerTls() {
    if (context_) SSL_CTX_set_app_data(context_.get(), nullptr);
}

SSL* BrokerTls::make_client(int socket) const {
    SSL* client = SSL_new(context_.get());
    if (!client) return nullptr;
    SSL_set_mode(client, SSL_MODE_ENABLE_PARTIAL_WRITE | SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER);
    SSL_set_connect_state(client);
    // RFC 6066, 3: an address is no name of a server.
    const bool named = host_is_address_ || SSL_set_tlsext_host_name(client, host_.c_str()) == 1;
    if (named && SSL_set_fd(client, socket) == 1) return client;
    SSL_free(client);
    return nullptr;
}

void BrokerTls::check_host() {
    X509_VERIFY_PARAM* parameters = SSL_CTX_get0_param(context_.get());
    if (host_is_address_) {
        X509_VERIFY_PARAM_set1_ip_asc(parameters, host_.c_str());
    } else {
        X509_VERIFY_PARAM_set_hostflags(parameters, X509_CHECK_FLAG_NO_PARTIAL_WILDCARDS);
        X509_VERIFY_PARAM_set1_host(parameters, host_.c_str(), host_.size());
    }
}

bool BrokerTls::load(const MqttTls& files) {
    SSL_CTX* context = context_.get();
    if (!is_readable(files.ca_file, file::kMaxCertificateBytes) ||
        !is_readable(files.certificate_file, file::kMaxCertificateBytes) ||
        !is_readable(files.key_file, file::kMaxSecretBytes))
        return false;
    const bool trusted = files.ca_file.empty()
                             ? SSL_CTX_set_default_verify_paths(context) == 1
                             : SSL_CTX_load_verify_locations(context, files.ca_file.c_str(), nullptr) == 1;
    if (!trusted) return fail_with_files(files.ca_file), false;
    if (!files.certificate_file.empty() &&
        SSL_CTX_use_certificate_chain_file(context, files.certificate_file.c_str()) != 1)
        return fail_with_files(files.certificate_file), false;
    // A key with a passphrase must not make OpenSSL ask for it on the terminal.
    SSL_CTX_set_default_passwd_cb(context, [](char*, int, int, void*) { return -1; });
    if (!files.key_file.empty() &&
        (SSL_CTX_use_PrivateKey_file(context, files.key_file.c_str(), SSL_FILETYPE_PEM) != 1 ||
         SSL_CTX_check_private_key(context) != 1))
        return fail_with_files(files.key_file), false;
    if (files.alpn.empty() || files.alpn.size() > 255) return true;
    std::vector<unsigned char> protocols{static_cast<unsigned char>(files.alpn.size())};
    protocols.insert(protocols.end(), files.alpn.begin(), files.alpn.end());
    SSL_CTX_set_alpn_protos(context, protocols.data(), static_cast<unsigned>(protocols.size()));
    return true;
}

// OpenSSL would wait for the writer of a FIFO.
bool BrokerTls::is_readable(const std::string& file, std::size_t limit) {
    if (file.empty()) return true;
    const auto readable = file::check_readable(file, limit);
    if (!readable)
        failure_ = MqttFailure{MqttFailureKind::tls_files, {}, file + ": " + file_reason(readable.error())};
    return readable.has_value();
}

void BrokerTls::fail_with_files(const std::string& subject) {
    // Of an error of the system, the last entry of the queue names a library only.
    const auto first = ERR_peek_error();
    const char* reason = ERR_SYSTEM_ERROR(first) ? std::strerror(ERR_GET_REASON(first))
                                                 : ERR_reason_error_string(ERR_peek_last_error());
    failure_ =
        MqttFailure{MqttFailureKind::tls_files, {}, subject + ": " + (reason ? reason : "cannot be used")};
}

int BrokerTls::on_certificate(int accepted, X509_STORE_CTX* store) {
    if (accepted) return accepted;
    const auto* ssl =
        static_cast<const SSL*>(X509_STORE_CTX_get_ex_data(store, SSL_get_ex_data_X509_STORE_CTX_idx()));
    auto* self = static_cast<BrokerTls*>(SSL_CTX_get_app_data(SSL_get_SSL_CTX(ssl)));
    const int error = X509_STORE_CTX_get_error(store);
    if (self && !self->failure_)
        self->failure_ = MqttFailure{kind_of(error), {}, X509_verify_cert_error_string(error)};
    return 0;
}

void BrokerTls::on_state(const SSL* ssl, int where, int value) {
    auto* self = static_cast<BrokerTls*>(SSL_CTX_get_app_data(SSL_get_SSL_CTX(ssl)));
    if (!self) return;
    constexpr int kFatal = SSL3_AL_FATAL;
    if (where == SSL_CB_READ_ALERT && value >> 8 == kFatal && !self->failure_)
        self->failure_ = MqttFailure{MqttFailureKind::tls, {}, alert_text(value)};
}

}  // namespace takt::publish
