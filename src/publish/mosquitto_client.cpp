#include "mosquitto_client.hpp"

#include <fcntl.h>
#include <mqtt_protocol.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "mosquitto_library.hpp"
#include "mosquitto_properties.hpp"
#include "takt/publish/command_request.hpp"

namespace takt::publish {
namespace {

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

MqttFailureKind kind_of_result(int result) {
    switch (result) {
        case MOSQ_ERR_CONN_LOST:
        case MOSQ_ERR_NO_CONN: return MqttFailureKind::lost;
        case MOSQ_ERR_KEEPALIVE: return MqttFailureKind::timed_out;
        case MOSQ_ERR_TLS:
        case MOSQ_ERR_TLS_HANDSHAKE: return MqttFailureKind::tls;
        case MOSQ_ERR_EAI:
        case MOSQ_ERR_LOOKUP: return MqttFailureKind::dns;
        case MOSQ_ERR_NOMEM:
        case MOSQ_ERR_INVAL:
        case MOSQ_ERR_NOT_SUPPORTED: return MqttFailureKind::local;
        default: return MqttFailureKind::protocol;
    }
}

// libmosquitto describes the first as "Unknown error.", the second as "A TLS error occurred."
const char* text_of_result(int result) {
    switch (result) {
        case MOSQ_ERR_KEEPALIVE: return "no response to PINGREQ";
        case MOSQ_ERR_TLS:
        case MOSQ_ERR_TLS_HANDSHAKE: return "the TLS handshake failed; is it a port for TLS?";
        default: return mosquitto_strerror(result);
    }
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

}  // namespace

MosquittoClient::MosquittoClient(const MqttConnect& connect, const std::string& address, Sink sink)
    : connection_(connect.connection), version_(connect.version), sink_(std::move(sink)) {
    use_mosquitto_library();
    if (!prepare(connect)) {
        if (!ended_) end({MqttFailureKind::local, {}, "libmosquitto rejects the options"});
        return;
    }
    const int keep_alive = static_cast<int>(connect.keep_alive.count());
    errno = 0;
    const int result =
        mosquitto_connect_async(client_.get(), address.c_str(), connect.broker.port, keep_alive);
    check(result, errno);
    // A program that is started meanwhile must not keep the connection open: the will would be late.
    if (!ended_) fcntl(mosquitto_socket(client_.get()), F_SETFD, FD_CLOEXEC);
}

MosquittoClient::~MosquittoClient() = default;

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
    if (!connect.broker.tls) return true;
    tls_ = std::make_unique<MosquittoTls>(*connect.broker.tls, connect.broker.host);
    if (!tls_->context()) {
        end(*tls_->failure());
        return false;
    }
    // Without MOSQ_OPT_SSL_CTX_WITH_DEFAULTS the context is used as it is.
    return mosquitto_int_option(client, MOSQ_OPT_SSL_CTX_WITH_DEFAULTS, 0) == MOSQ_ERR_SUCCESS &&
           mosquitto_void_option(client, MOSQ_OPT_SSL_CTX, tls_->context()) == MOSQ_ERR_SUCCESS;
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
    if (ended_) return;
    if (result != MOSQ_ERR_SUCCESS)
        end(failure_of(result, error));
    else if (mosquitto_socket(client_.get()) < 0)
        end(failure_of(MOSQ_ERR_CONN_LOST, 0));
}

MqttFailure MosquittoClient::failure_of(int result, int error) const {
    if (from_broker_) return *from_broker_;
    if (disconnecting_) return {};
    if (tls_ && tls_->failure()) return *tls_->failure();
    // The alert of the broker is lost if its reset comes before.
    if (tls_ && !open_ && result == MOSQ_ERR_ERRNO && error == EPROTO)
        return {MqttFailureKind::tls, {}, "TLS ended before CONNACK; is a client certificate required?"};
    if (result == MOSQ_ERR_ERRNO)
        return {error == EPROTO ? MqttFailureKind::tls : kind_of_errno(error), {}, std::strerror(error)};
    return {kind_of_result(result), {}, text_of_result(result)};
}

int MosquittoClient::fd() const {
    return ended_ || !client_ ? -1 : mosquitto_socket(client_.get());
}

short MosquittoClient::events() const {
    if (!reached_) return POLLOUT;
    return static_cast<short>(POLLIN | (mosquitto_want_write(client_.get()) ? POLLOUT : 0));
}

void MosquittoClient::on_ready(short ready) {
    if (ended_ || ready == 0) return;
    if (!reached_) return on_tcp_ready();
    errno = 0;
    int result = MOSQ_ERR_SUCCESS;
    // During the handshake of TLS both directions continue in mosquitto_loop_read().
    if ((ready & ~POLLOUT) != 0 || (tls_ && !open_)) result = mosquitto_loop_read(client_.get(), 1);
    check(result, errno);
    if (ended_ || (ready & POLLOUT) == 0) return;
    errno = 0;
    result = mosquitto_loop_write(client_.get(), 1);
    check(result, errno);
}

// The library does not see how connect() ended before it reads or writes, and loops on a failed one.
void MosquittoClient::on_tcp_ready() {
    int error = 0;
    socklen_t length = sizeof error;
    if (getsockopt(mosquitto_socket(client_.get()), SOL_SOCKET, SO_ERROR, &error, &length) != 0)
        error = errno;
    if (error != 0) return end({kind_of_errno(error), {}, std::strerror(error)});
    reached_ = true;
    on_ready(POLLOUT);
}

void MosquittoClient::on_second() {
    if (ended_ || !reached_) return;
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
        return sink_(std::move(event));
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
    // One byte more than a command may have is enough to refuse it: a payload of 256 MiB is not copied.
    if (message.payloadlen > 0)
        event.message.payload.assign(
            static_cast<const char*>(message.payload),
            std::min(static_cast<std::size_t>(message.payloadlen), CommandRequest::kMostBytes + 1));
    event.message.qos = static_cast<std::uint8_t>(message.qos);
    event.message.retain = message.retain;
    event.message.properties = from_mosquitto(properties);
    sink_(std::move(event));
}

}  // namespace takt::publish
