#include "mqtt/mosquitto_client.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <mqtt_protocol.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "mqtt/mosquitto_library.hpp"
#include "mqtt/mosquitto_properties.hpp"

namespace takt::publish {
namespace {

// A record of TLS, so that none stays half-read in OpenSSL, where poll() does not see it.
constexpr std::size_t kReadBytes = 16384;
constexpr int kAcceptMs = 1000;

MqttFailureKind kind_of_result(int result) {
    switch (result) {
        case MOSQ_ERR_CONN_LOST:
        case MOSQ_ERR_NO_CONN: return MqttFailureKind::lost;
        case MOSQ_ERR_KEEPALIVE: return MqttFailureKind::timed_out;
        case MOSQ_ERR_NOMEM:
        case MOSQ_ERR_INVAL:
        case MOSQ_ERR_NOT_SUPPORTED: return MqttFailureKind::local;
        default: return MqttFailureKind::protocol;
    }
}

// libmosquitto describes it as "Unknown error."
const char* text_of_result(int result) {
    return result == MOSQ_ERR_KEEPALIVE ? "no response to PINGREQ" : mosquitto_strerror(result);
}

// Why libmosquitto did not accept a message; none: the connection failed.
std::optional<MqttReason> rejection(int result) {
    switch (result) {
        case MOSQ_ERR_OVERSIZE_PACKET:
        case MOSQ_ERR_PAYLOAD_SIZE: return MqttReason::packet_too_large;
        case MOSQ_ERR_MALFORMED_UTF8:
        case MOSQ_ERR_INVAL: return MqttReason::topic_name_invalid;
        case MOSQ_ERR_DUPLICATE_PROPERTY:
        case MOSQ_ERR_PROTOCOL: return MqttReason::payload_format_invalid;
        default: return {};
    }
}

MosquittoClient& self_of(void* pointer) {
    return *static_cast<MosquittoClient*>(pointer);
}

sockaddr_in loopback() {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    return address;
}

/// @param get  getsockname or getpeername. @returns 0: it fails
template <class Get>
in_port_t port_of(Get get, int socket) {
    sockaddr_in address{};
    socklen_t length = sizeof address;
    return get(socket, reinterpret_cast<sockaddr*>(&address), &length) == 0 ? address.sin_port : 0;
}

os::Descriptor listen_locally() {
    os::Descriptor listener(socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
    const auto address = loopback();
    if (listener && (bind(listener.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
                     listen(listener.get(), SOMAXCONN) != 0))
        listener.reset();
    return listener;
}

// Another program may find the port first: only the connection of `port` is accepted.
os::Descriptor accept_from(const os::Descriptor& listener, in_port_t port) {
    pollfd ready{.fd = listener.get(), .events = POLLIN, .revents = 0};
    while (poll(&ready, 1, kAcceptMs) > 0) {
        os::Descriptor accepted(accept4(listener.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
        if (accepted && port != 0 && port_of(getpeername, accepted.get()) == port) return accepted;
    }
    return {};
}

}  // namespace

MosquittoClient::MosquittoClient(const MqttConnect& connect, const std::string& address, Sink sink)
    : connection_(connect.connection),
      version_(connect.version),
      sink_(std::move(sink)),
      stream_(connect.broker, address) {
    use_mosquitto_library();
    begin(connect);
}

MosquittoClient::~MosquittoClient() = default;

void MosquittoClient::begin(const MqttConnect& connect) {
    if (stream_.state() == BrokerStream::State::ended) return end(*stream_.failure());
    if (!prepare(connect)) return end({MqttFailureKind::local, {}, "libmosquitto rejects the options"});
    errno = 0;
    const int result = connect_library(connect);
    check(result, errno);
}

bool MosquittoClient::prepare(const MqttConnect& connect) {
    client_.reset(mosquitto_new(connect.client_id.empty() ? nullptr : connect.client_id.c_str(), true, this));
    mosquitto* client = client_.get();
    if (!client) return false;
    const int protocol = version_ == MqttVersion::v5 ? MQTT_PROTOCOL_V5 : MQTT_PROTOCOL_V311;
    // The session keeps the window; libmosquitto must not queue beside it.
    if (mosquitto_int_option(client, MOSQ_OPT_PROTOCOL_VERSION, protocol) != MOSQ_ERR_SUCCESS ||
        mosquitto_int_option(client, MOSQ_OPT_SEND_MAXIMUM, 0) != MOSQ_ERR_SUCCESS ||
        mosquitto_int_option(client, MOSQ_OPT_TCP_NODELAY, 1) != MOSQ_ERR_SUCCESS)
        return false;
    if (!connect.user.empty() &&
        mosquitto_username_pw_set(client, connect.user.c_str(),
                                  connect.password.empty() ? nullptr : connect.password.c_str()) !=
            MOSQ_ERR_SUCCESS)
        return false;
    if (connect.will && !set_will(*connect.will, connect.version)) return false;
    set_callbacks();
    return true;
}

// Only the blocking function takes properties of CONNECT. The listener is in this process: it does not block.
int MosquittoClient::connect_library(const MqttConnect& connect) {
    const auto listener = listen_locally();
    if (!listener) return MOSQ_ERR_ERRNO;
    mosquitto_property* list = nullptr;
    if (version_ == MqttVersion::v5 && mosquitto_property_add_int32(&list, MQTT_PROP_MAXIMUM_PACKET_SIZE,
                                                                    kMostReceivedBytes) != MOSQ_ERR_SUCCESS)
        return MOSQ_ERR_NOMEM;
    const MosquittoProperties properties(list);
    const int result =
        mosquitto_connect_bind_v5(client_.get(), "127.0.0.1", ntohs(port_of(getsockname, listener.get())),
                                  static_cast<int>(connect.keep_alive.count()), nullptr, properties.get());
    if (result != MOSQ_ERR_SUCCESS) return result;
    // A program that is started meanwhile must not keep the connection open: the will would be late.
    fcntl(mosquitto_socket(client_.get()), F_SETFD, FD_CLOEXEC);
    local_ = accept_from(listener, port_of(getsockname, mosquitto_socket(client_.get())));
    if (!local_) return MOSQ_ERR_NO_CONN;
    const int yes = 1;
    setsockopt(local_.get(), IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
    return MOSQ_ERR_SUCCESS;
}

bool MosquittoClient::set_will(const MqttMessage& will, MqttVersion version) {
    auto properties = to_mosquitto(version == MqttVersion::v5 ? will.properties : MqttProperties{});
    if (!properties) return false;
    const int result =
        mosquitto_will_set_v5(client_.get(), will.topic.c_str(), static_cast<int>(will.payload.size()),
                              will.payload.data(), will.qos, will.retain, properties->get());
    if (result == MOSQ_ERR_SUCCESS) (void)properties->release();  // libmosquitto owns them now
    return result == MOSQ_ERR_SUCCESS;
}

void MosquittoClient::set_callbacks() {
    mosquitto_connect_v5_callback_set(
        client_.get(), [](mosquitto*, void* object, int code, int, const mosquitto_property* properties) {
            self_of(object).on_connack(code, properties);
        });
    mosquitto_disconnect_v5_callback_set(
        client_.get(), [](mosquitto*, void* object, int code, const mosquitto_property* properties) {
            self_of(object).on_closed(code, properties);
        });
    mosquitto_publish_v5_callback_set(
        client_.get(), [](mosquitto*, void* object, int identifier, int code, const mosquitto_property*) {
            self_of(object).on_published(identifier, code);
        });
    mosquitto_subscribe_v5_callback_set(client_.get(), [](mosquitto*, void* object, int identifier, int count,
                                                          const int* codes, const mosquitto_property*) {
        self_of(object).on_subscribed(identifier, count, codes);
    });
    mosquitto_message_v5_callback_set(
        client_.get(),
        [](mosquitto*, void* object, const mosquitto_message* message, const mosquitto_property* properties) {
            self_of(object).on_message(*message, properties);
        });
}

void MosquittoClient::end(MqttFailure failure) {
    if (!ended_) ended_ = std::move(failure);
}

// The result of a function of libmosquitto, and errno after it.
void MosquittoClient::check(int result, int error) {
    if (ended_ || flushing_) return;
    const bool closed = mosquitto_socket(client_.get()) < 0;
    if (disconnecting_ && (closed || result != MOSQ_ERR_SUCCESS))
        flushing_ = true;
    else if (result != MOSQ_ERR_SUCCESS)
        end(failure_of(result, error));
    else if (closed)
        end(failure_of(MOSQ_ERR_CONN_LOST, 0));
}

MqttFailure MosquittoClient::failure_of(int result, int error) const {
    if (from_broker_) return *from_broker_;
    if (stream_.state() == BrokerStream::State::ended && stream_.failure()) {
        // The alert of the broker is lost if its reset comes before.
        if (stream_.failure()->kind == MqttFailureKind::tls && !open_ && stream_.was_open())
            return {MqttFailureKind::tls, {}, "TLS ended before CONNACK; is a client certificate required?"};
        return *stream_.failure();
    }
    if (result == MOSQ_ERR_ERRNO) return {kind_of_errno(error), {}, std::strerror(error)};
    return {kind_of_result(result), {}, text_of_result(result)};
}

MosquittoClient::Descriptors MosquittoClient::descriptors(bool paused) const {
    Descriptors all{{{.fd = -1, .events = 0, .revents = 0},
                     {.fd = -1, .events = 0, .revents = 0},
                     {.fd = -1, .events = 0, .revents = 0}}};
    if (ended_ || !client_) return all;
    auto& [broker, library, local] = all;
    const bool writes = !flushing_ && mosquitto_want_write(client_.get());
    broker.events =
        stream_.events(!paused && !writes && to_library_.empty() && gate_.may_read(), !to_broker_.empty());
    if (!flushing_)
        library.events = static_cast<short>((paused || writes ? 0 : POLLIN) | (writes ? POLLOUT : 0));
    const bool takes = stream_.is_open() && to_broker_.empty() && !library_ended_;
    local.events = static_cast<short>((takes ? POLLIN : 0) | (to_library_.empty() ? 0 : POLLOUT));
    // poll() reports the end of a connection without being asked.
    if (broker.events != 0) broker.fd = stream_.fd();
    if (library.events != 0) library.fd = mosquitto_socket(client_.get());
    if (local.events != 0) local.fd = local_.get();
    return all;
}

void MosquittoClient::on_ready(const Descriptors& ready) {
    const auto& [broker, library, local] = ready;
    if (!ended_ && broker.revents != 0) serve_stream();
    if (!ended_ && !flushing_ && library.revents != 0) serve_library(library.revents);
    if (!ended_ && local.revents != 0) serve_local();
    if (!ended_ && flushing_ &&
        (stream_.state() == BrokerStream::State::ended || (library_ended_ && to_broker_.empty())))
        end({});
}

void MosquittoClient::serve_stream() {
    if (!stream_.is_open()) {
        stream_.advance();
        if (stream_.state() == BrokerStream::State::ended) end(failure_of(MOSQ_ERR_CONN_LOST, 0));
        return;
    }
    flush_to_broker();
    if (to_library_.empty()) pass_to_library();
}

void MosquittoClient::serve_library(short ready) {
    errno = 0;
    int result = MOSQ_ERR_SUCCESS;
    if ((ready & ~POLLOUT) != 0) result = mosquitto_loop_read(client_.get(), 1);
    check(result, errno);
    if (ended_ || flushing_ || (ready & POLLOUT) == 0) return;
    errno = 0;
    result = mosquitto_loop_write(client_.get(), 1);
    check(result, errno);
}

void MosquittoClient::serve_local() {
    flush_to_library();
    if (!to_broker_.empty() || !stream_.is_open()) return;
    std::array<char, kReadBytes> buffer;
    const auto got = recv(local_.get(), buffer.data(), buffer.size(), 0);
    if (got > 0) return pass_to_broker({buffer.data(), static_cast<std::size_t>(got)});
    if (got == 0 || (errno != EAGAIN && errno != EINTR)) library_ended_ = true;
}

void MosquittoClient::pass_to_library() {
    std::array<char, kReadBytes> buffer;
    const std::size_t got = stream_.read(buffer);
    gate_.from_broker({buffer.data(), got}, to_library_);
    while (auto dropped = gate_.next_dropped())
        sink_(MqttOversized{connection_, std::move(dropped->topic), dropped->bytes});
    pass_to_broker({});
    flush_to_library();
    check_gate();
}

void MosquittoClient::flush_to_library() {
    if (!to_library_.empty()) {
        const auto sent = send(local_.get(), to_library_.data(), to_library_.size(), MSG_NOSIGNAL);
        if (sent > 0) to_library_.erase(0, static_cast<std::size_t>(sent));
        if (sent < 0 && errno != EAGAIN && errno != EINTR) to_library_.clear();
    }
    // libmosquitto reads what is left, with the reason of a DISCONNECT, and then the end.
    if (to_library_.empty() && stream_.state() == BrokerStream::State::ended) shutdown(local_.get(), SHUT_WR);
}

void MosquittoClient::pass_to_broker(std::string_view bytes) {
    gate_.to_broker(bytes, to_broker_);
    check_gate();
    flush_to_broker();
}

void MosquittoClient::flush_to_broker() {
    to_broker_.erase(0, stream_.write(to_broker_));
}

void MosquittoClient::check_gate() {
    if (gate_.failure() && !ended_) end(*gate_.failure());
}

void MosquittoClient::on_second() {
    if (ended_ || flushing_ || !stream_.is_open()) return;
    errno = 0;
    const int result = mosquitto_loop_misc(client_.get());
    check(result, errno);
}

void MosquittoClient::publish(const MqttPublish& action) {
    if (ended_) return;
    const auto& message = action.message;
    const auto properties = to_mosquitto(version_ == MqttVersion::v5 ? message.properties : MqttProperties{});
    if (!properties)
        return sink_(MqttAcknowledged{connection_, action.token, MqttReason::payload_format_invalid});
    int identifier = 0;
    publishing_now_ = action.token;
    errno = 0;
    const int result = mosquitto_publish_v5(client_.get(), &identifier, message.topic.c_str(),
                                            static_cast<int>(message.payload.size()), message.payload.data(),
                                            message.qos, message.retain, properties->get());
    const int error = errno;
    const MqttToken still_open = std::exchange(publishing_now_, 0);
    if (const auto reason = rejection(result))
        return sink_(MqttAcknowledged{connection_, action.token, *reason});
    if (still_open != 0) publishing_[identifier] = action.token;
    check(result, error);
}

void MosquittoClient::subscribe(const MqttSubscribe& action) {
    if (ended_) return;
    subscribing_.emplace();
    subscribing_->answer = {connection_, action.token, {}};
    subscribing_->answer.reasons.resize(action.subscriptions.size(), MqttReason::topic_filter_invalid);
    const int options = version_ == MqttVersion::v5 ? MQTT_SUB_OPT_RETAIN_AS_PUBLISHED : 0;
    for (std::size_t i = 0; i < action.subscriptions.size() && !ended_; ++i) {
        int identifier = 0;
        errno = 0;
        const int result =
            mosquitto_subscribe_v5(client_.get(), &identifier, action.subscriptions[i].filter.c_str(),
                                   action.subscriptions[i].qos, options, nullptr);
        if (result == MOSQ_ERR_SUCCESS) subscribing_->waiting[identifier] = i;
        if (!rejection(result)) check(result, errno);
    }
    if (!ended_ && subscribing_->waiting.empty()) on_subscribed(0, 0, nullptr);
}

void MosquittoClient::disconnect() {
    if (ended_) return;
    disconnecting_ = true;
    errno = 0;
    const int result = mosquitto_disconnect_v5(client_.get(), 0, nullptr);
    check(result, errno);
}

void MosquittoClient::on_connack(int code, const mosquitto_property* properties) {
    if (code == 0) {
        open_ = true;
        auto event = version_ == MqttVersion::v5 ? connack_limits(properties) : MqttConnected{};
        event.connection = connection_;
        return sink_(event);
    }
    const auto reason = version_ == MqttVersion::v5 ? static_cast<MqttReason>(code)
                                                    : from_connack_3_1_1(static_cast<std::uint8_t>(code));
    from_broker_ = MqttFailure{failure_kind(reason), reason, reason_string(properties)};
}

// The code is a reason of DISCONNECT, or one of libmosquitto's errors, which are below 0x80.
void MosquittoClient::on_closed(int code, const mosquitto_property* properties) {
    const auto reason = static_cast<MqttReason>(code & 0xFF);
    if (code > 0 && code <= 0xFF && is_failure(reason) && !from_broker_)
        from_broker_ = MqttFailure{failure_kind(reason), reason, reason_string(properties)};
}

void MosquittoClient::on_published(int identifier, int code) {
    MqttToken token = 0;
    if (const auto found = publishing_.find(identifier); found != publishing_.end()) {
        token = found->second;
        publishing_.erase(found);
    } else {
        token = std::exchange(publishing_now_, 0);  // QoS 0, written at once
    }
    if (token != 0) sink_(MqttAcknowledged{connection_, token, static_cast<MqttReason>(code)});
}

void MosquittoClient::on_subscribed(int identifier, int count, const int* codes) {
    if (!subscribing_) return;
    const auto found = subscribing_->waiting.find(identifier);
    if (found != subscribing_->waiting.end()) {
        if (count > 0) subscribing_->answer.reasons[found->second] = static_cast<MqttReason>(codes[0]);
        subscribing_->waiting.erase(found);
    }
    if (!subscribing_->waiting.empty()) return;
    sink_(std::move(subscribing_->answer));
    subscribing_.reset();
}

void MosquittoClient::on_message(const mosquitto_message& message, const mosquitto_property* properties) {
    MqttReceived event{.connection = connection_, .message = {}};
    event.message.topic = message.topic ? message.topic : "";
    if (message.payloadlen > 0)
        event.message.payload.assign(static_cast<const char*>(message.payload),
                                     static_cast<std::size_t>(message.payloadlen));
    event.message.qos = static_cast<std::uint8_t>(message.qos);
    event.message.retain = message.retain;
    event.message.properties = from_mosquitto(properties);
    sink_(std::move(event));
}

}  // namespace takt::publish
