// TLS of one connection: OpenSSL's context with the check of the broker's certificate.
#pragma once

#include <openssl/types.h>

#include <cstddef>
#include <memory>
#include <optional>
#include <string>

#include "takt/publish/mqtt_port.hpp"

namespace takt::publish {

/// A context for one connection to one host. TLS 1.2 or later; the certificate is checked against the trusted
/// authorities, its dates, and the host name or address.
class BrokerTls {
public:
    /// Reads the files. See is_usable()
    BrokerTls(const MqttTls& files, const std::string& host);
    ~BrokerTls();
    BrokerTls(const BrokerTls&) = delete;
    BrokerTls& operator=(const BrokerTls&) = delete;

    /// false: a file cannot be used, see failure().
    [[nodiscard]] bool is_usable() const { return context_ != nullptr; }
    /// A client of TLS on a connected socket, before its handshake. The caller frees it. Null: out of memory.
    [[nodiscard]] SSL* make_client(int socket) const;
    /// Why the files cannot be used, the certificate was rejected, or the broker ended TLS.
    [[nodiscard]] const std::optional<MqttFailure>& failure() const { return failure_; }

private:
    struct Free {
        void operator()(SSL_CTX* context) const;
    };

    bool load(const MqttTls& files);
    bool is_readable(const std::string& file, std::size_t limit);
    void fail_with_files(const std::string& subject);
    void check_host();
    static int on_certificate(int accepted, X509_STORE_CTX* store);
    static void on_state(const SSL* ssl, int where, int value);

    std::string host_;
    bool host_is_address_ = false;
    std::unique_ptr<SSL_CTX, Free> context_;
    std::optional<MqttFailure> failure_;
};

}  // namespace takt::publish
