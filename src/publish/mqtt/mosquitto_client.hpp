// One connection of libmosquitto, driven by poll().
#pragma once

#include <mosquitto.h>
#include <poll.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "mqtt/broker_stream.hpp"
#include "mqtt/packet_gate.hpp"
#include "takt/os/descriptor.hpp"
#include "takt/publish/mqtt_port.hpp"

namespace takt::publish {

/// An attempt to connect to one address of a broker, and the connection that it becomes. The owner calls it
/// when its descriptors are ready, and once a second. One thread. Functions do not block.
///
/// libmosquitto 2.0.11 allocates each packet at the length that the broker announces, and has no option to
/// limit it. So it is connected to this object, by a socket of the loopback interface, and the object to the
/// broker:
///
///     broker <-> BrokerStream <-> PacketGate <-> socket <-> libmosquitto
///
/// Memory is bounded: a direction is read only while its next buffer is empty, and the broker only while
/// libmosquitto has nothing to write.
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

    /// To the broker, of libmosquitto, and to libmosquitto; with the events to wait for. -1: none.
    using Descriptors = std::array<pollfd, 3>;
    /// libmosquitto closes its descriptor within its functions: they must be asked for again after each call.
    /// @param paused  nothing is read from the broker
    [[nodiscard]] Descriptors descriptors(bool paused) const;
    void on_ready(const Descriptors& ready);
    void on_second();

    void publish(const MqttPublish& action);
    void subscribe(const MqttSubscribe& action);
    /// Sends DISCONNECT. The connection ends as soon as it is written.
    void disconnect();

    /// The broker's host accepted the TCP connection.
    [[nodiscard]] bool is_reached() const { return stream_.is_reached(); }
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

    void begin(const MqttConnect& connect);
    bool prepare(const MqttConnect& connect);
    int connect_library(const MqttConnect& connect);
    bool set_will(const MqttMessage& will, MqttVersion version);
    void set_callbacks();
    void end(MqttFailure failure);
    void check(int result, int error);
    MqttFailure failure_of(int result, int error) const;
    void serve_stream();
    void serve_library(short ready);
    void serve_local();
    void pass_to_library();
    void pass_to_broker(std::string_view bytes);
    void flush_to_library();
    void flush_to_broker();
    void check_gate();

    void on_connack(int code, const mosquitto_property* properties);
    void on_closed(int code, const mosquitto_property* properties);
    void on_published(int identifier, int code);
    void on_subscribed(int identifier, int count, const int* codes);
    void on_message(const mosquitto_message& message, const mosquitto_property* properties);

    MqttConnectionId connection_;
    MqttVersion version_;
    Sink sink_;
    BrokerStream stream_;
    PacketGate gate_{kMostReceivedBytes};
    os::Descriptor local_;    // the end of libmosquitto's connection
    std::string to_library_;  // from the broker
    std::string to_broker_;
    std::unique_ptr<mosquitto, Destroy> client_;
    bool open_ = false;                       // CONNACK with success
    bool disconnecting_ = false;              // disconnect() was called
    bool flushing_ = false;                   // libmosquitto has ended; the rest goes to the broker
    bool library_ended_ = false;              // and all that it wrote was read
    std::optional<MqttFailure> from_broker_;  // CONNACK or DISCONNECT with a reason
    std::optional<MqttFailure> ended_;
    std::map<int, MqttToken> publishing_;  // packet identifier to token
    MqttToken publishing_now_ = 0;         // within mosquitto_publish_v5(): its identifier is not known yet
    std::optional<Subscribing> subscribing_;
};

}  // namespace takt::publish
