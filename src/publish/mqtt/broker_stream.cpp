#include "mqtt/broker_stream.hpp"

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <openssl/err.h>
#include <openssl/ssl.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <cstring>
#include <utility>

namespace takt::publish {
namespace {

struct FreeAddress {
    void operator()(addrinfo* list) const { freeaddrinfo(list); }
};

std::unique_ptr<addrinfo, FreeAddress> numeric_address(const std::string& address, std::uint16_t port) {
    addrinfo hints{};
    hints.ai_flags = AI_NUMERICHOST | AI_NUMERICSERV;
    hints.ai_socktype = SOCK_STREAM;
    addrinfo* list = nullptr;
    if (getaddrinfo(address.c_str(), std::to_string(port).c_str(), &hints, &list) != 0) return nullptr;
    return std::unique_ptr<addrinfo, FreeAddress>(list);
}

bool would_block(int error) {
    return error == EAGAIN || error == EWOULDBLOCK || error == EINTR;
}

}  // namespace

MqttFailureKind kind_of_errno(int error) {
    switch (error) {
        case ECONNREFUSED: return MqttFailureKind::refused;
        case ETIMEDOUT: return MqttFailureKind::timed_out;
        case EHOSTUNREACH:
        case ENETUNREACH:
        case EHOSTDOWN:
        case ENETDOWN:
        case EACCES:
        case EPERM:
        case EADDRNOTAVAIL: return MqttFailureKind::unreachable;
        case EMFILE:
        case ENFILE:
        case ENOBUFS:
        case ENOMEM: return MqttFailureKind::local;
        default: return MqttFailureKind::lost;
    }
}

void BrokerStream::Free::operator()(SSL* client) const {
    SSL_free(client);
}

BrokerStream::BrokerStream(const MqttBroker& broker, const std::string& address) {
    if (broker.tls) {
        tls_ = std::make_unique<BrokerTls>(*broker.tls, broker.host);
        if (!tls_->is_usable()) {
            state_ = State::ended;
            failure_ = tls_->failure();
            return;
        }
    }
    connect(address, broker.port);
}

void BrokerStream::connect(const std::string& address, std::uint16_t port) {
    const auto target = numeric_address(address, port);
    if (!target) return fail(MqttFailureKind::dns, "no address: " + address);
    socket_.reset(socket(target->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
    if (!socket_) return fail_with(errno);
    const int yes = 1;
    setsockopt(socket_.get(), IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
    if (::connect(socket_.get(), target->ai_addr, target->ai_addrlen) != 0 && errno != EINPROGRESS)
        fail_with(errno);
}

BrokerStream::~BrokerStream() {
    // close_notify distinguishes this end from a cut connection.
    if (client_ && state_ == State::open) SSL_shutdown(client_.get());
    ERR_clear_error();
}

void BrokerStream::fail(MqttFailureKind kind, std::string text) {
    state_ = State::ended;
    failure_ = tls_ && tls_->failure() ? *tls_->failure() : MqttFailure{kind, {}, std::move(text)};
}

void BrokerStream::fail_with(int error) {
    fail(kind_of_errno(error), std::strerror(error));
}

short BrokerStream::events(bool to_read, bool to_write) const {
    switch (state_) {
        case State::connecting: return POLLOUT;
        case State::handshake: return blocked_on_;
        case State::open: break;
        case State::ended: return 0;
    }
    const int wanted = (to_read ? POLLIN : 0) | (to_write ? POLLOUT : 0);
    return static_cast<short>(to_read || to_write ? wanted | blocked_on_ : 0);
}

void BrokerStream::advance() {
    if (state_ == State::handshake) return shake_hands();
    if (state_ != State::connecting) return;
    int error = 0;
    socklen_t length = sizeof error;
    if (getsockopt(socket_.get(), SOL_SOCKET, SO_ERROR, &error, &length) != 0) error = errno;
    if (error != 0) return fail_with(error);
    reached_ = true;
    connected();
}

void BrokerStream::connected() {
    if (!tls_) return open();
    client_.reset(tls_->make_client(socket_.get()));
    if (!client_) return fail(MqttFailureKind::local, "SSL_new");
    state_ = State::handshake;
    shake_hands();
}

void BrokerStream::open() {
    state_ = State::open;
    was_open_ = true;
}

void BrokerStream::shake_hands() {
    ERR_clear_error();
    const int result = SSL_do_handshake(client_.get());
    blocked_on_ = 0;
    if (result == 1) return open();
    switch (SSL_get_error(client_.get(), result)) {
        case SSL_ERROR_WANT_READ: blocked_on_ = POLLIN; break;
        case SSL_ERROR_WANT_WRITE: blocked_on_ = POLLOUT; break;
        default: fail(MqttFailureKind::tls, "the TLS handshake failed; is it a port for TLS?");
    }
}

std::size_t BrokerStream::read(std::span<char> buffer) {
    if (state_ != State::open) return 0;
    return client_ ? read_tls(buffer) : read_plain(buffer);
}

std::size_t BrokerStream::read_plain(std::span<char> buffer) {
    const auto got = recv(socket_.get(), buffer.data(), buffer.size(), 0);
    if (got > 0) return static_cast<std::size_t>(got);
    if (got == 0)
        state_ = State::ended;
    else if (!would_block(errno))
        fail_with(errno);
    return 0;
}

std::size_t BrokerStream::read_tls(std::span<char> buffer) {
    ERR_clear_error();
    const int got = SSL_read(client_.get(), buffer.data(),
                             static_cast<int>(std::min<std::size_t>(buffer.size(), INT_MAX)));
    const int error = errno;
    blocked_on_ = 0;
    if (got > 0) return static_cast<std::size_t>(got);
    switch (SSL_get_error(client_.get(), got)) {
        case SSL_ERROR_WANT_READ: break;
        case SSL_ERROR_WANT_WRITE: blocked_on_ = POLLOUT; break;
        case SSL_ERROR_ZERO_RETURN: state_ = State::ended; break;
        case SSL_ERROR_SYSCALL:
            if (error != 0) {
                fail_with(error);
                break;
            }
            [[fallthrough]];
        default: fail(MqttFailureKind::tls, "TLS ended without close_notify");
    }
    return 0;
}

std::size_t BrokerStream::write(std::string_view bytes) {
    if (state_ != State::open || bytes.empty()) return 0;
    if (client_) return write_tls(bytes);
    const auto sent = send(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent >= 0) return static_cast<std::size_t>(sent);
    return would_block(errno) ? 0 : bytes.size();
}

std::size_t BrokerStream::write_tls(std::string_view bytes) {
    ERR_clear_error();
    const int sent = SSL_write(client_.get(), bytes.data(),
                               static_cast<int>(std::min<std::size_t>(bytes.size(), INT_MAX)));
    if (sent > 0) return static_cast<std::size_t>(sent);
    switch (SSL_get_error(client_.get(), sent)) {
        case SSL_ERROR_WANT_READ: blocked_on_ = POLLIN; return 0;
        case SSL_ERROR_WANT_WRITE: return 0;
        default: return bytes.size();
    }
}

}  // namespace takt::publish
