// One connection of libmosquitto, driven by poll().
#pragma once

#include <mosquitto.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "mosquitto_tls.hpp"
#include "takt/publish/mqtt_port.hpp"

namespace takt::publish {

/// An attempt to connect to one address of a broker, and the connection that it becomes. The owner calls it
/// when its descriptor is ready, and once a second. One thread. Functions do not block.
///
/// libmosquitto closes its descriptor within its functions: fd() must be read again after each call.
class MosquittoClient {
public:
    /// Gets the events but MqttClosed, within the functions of the client.
    using Sink = std::function<void(MqttEvent&&)>;

    /// Begins to connect.
    /// @param connect  outlives the client
    /// @param address  numeric
    MosquittoClient(const MqttConnect& connect, const std::string& address, Sink sink);
    /// Closes the connection without a DISCONNECT packet.
    ~MosquittoClient();
    MosquittoClient(const MosquittoClient&) = delete;
    MosquittoClient& operator=(const MosquittoClient&) = delete;

    /// -1: the connection has ended.
    [[nodiscard]] int fd() const;
    /// Events to wait for, as for poll().
    [[nodiscard]] short events() const;
    void on_ready(short ready);
    void on_second();

    void publish(const MqttPublish& action);
    void subscribe(const MqttSubscribe& action);
    /// Sends DISCONNECT. The connection ends as soon as it is written.
    void disconnect();

    /// The broker's host accepted the TCP connection.
    [[nodiscard]] bool is_reached() const { return reached_; }
    /// Why the connection has ended; none: it has not. Kind none: disconnect().
    [[nodiscard]] const std::optional<MqttFailure>& ended() const { return ended_; }

private:
    struct Destroy {
        void operator()(mosquitto* client) const { mosquitto_destroy(client); }
    };
    struct Subscribing {
        MqttSubscribed answer;
        std::map<int, std::size_t> waiting;  // packet identifier to the index of the subscription
    };

    bool prepare(const MqttConnect& connect);
    bool set_will(const MqttMessage& will, MqttVersion version);
    void set_callbacks();
    void end(MqttFailure failure);
    void check(int result, int error);
    MqttFailure failure_of(int result, int error) const;
    void on_tcp_ready();

    void on_connack(int code, const mosquitto_property* properties);
    void on_closed(int code, const mosquitto_property* properties);
    void on_published(int identifier, int code);
    void on_subscribed(int identifier, int count, const int* codes);
    void on_message(const mosquitto_message& message, const mosquitto_property* properties);

    MqttConnectionId connection_;
    MqttVersion version_;
    Sink sink_;
    std::unique_ptr<MosquittoTls> tls_;
    std::unique_ptr<mosquitto, Destroy> client_;
    bool reached_ = false;
    bool open_ = false;                       // CONNACK with success
    bool disconnecting_ = false;              // disconnect() was called
    std::optional<MqttFailure> from_broker_;  // CONNACK or DISCONNECT with a reason
    std::optional<MqttFailure> ended_;
    std::map<int, MqttToken> publishing_;  // packet identifier to token
    MqttToken publishing_now_ = 0;         // within mosquitto_publish_v5(): its identifier is not known yet
    std::optional<Subscribing> subscribing_;
};

}  // namespace takt::publish
