#include "trace.hpp"

#include <variant>

namespace takt::gatewaysim {
namespace {

using namespace publish;  // NOLINT(*-using-namespace): the types of the port

std::string number(std::uint64_t value) {
    return std::to_string(value);
}

struct Text {
    std::string operator()(const MqttConnect& connect) const {
        return "-> CONNECT " + number(connect.connection) + " to " + connect.broker.host + ", version " +
               number(static_cast<std::uint64_t>(connect.version));
    }
    std::string operator()(const MqttPublish& publish) const {
        return "-> PUBLISH " + number(publish.token) + " QoS " + number(publish.message.qos) + " " +
               publish.message.topic + " " + publish.message.payload;
    }
    std::string operator()(const MqttSubscribe& subscribe) const {
        return "-> SUBSCRIBE " + number(subscribe.token);
    }
    std::string operator()(const MqttDisconnect& disconnect) const {
        return std::string("-> DISCONNECT") + (disconnect.orderly ? "" : ", without a packet");
    }
    std::string operator()(const MqttConnected& connected) const {
        return "<- CONNACK, receive maximum " + number(connected.receive_maximum) + ", QoS " +
               number(connected.maximum_qos);
    }
    std::string operator()(const MqttClosed& closed) const {
        return "<- closed: " + std::string(name(closed.failure.kind)) + ", " +
               std::string(name(closed.failure.reason));
    }
    std::string operator()(const MqttAcknowledged& acknowledged) const {
        return "<- PUBACK " + number(acknowledged.token) + " " + std::string(name(acknowledged.reason));
    }
    std::string operator()(const MqttSubscribed& subscribed) const {
        return "<- SUBACK " + number(subscribed.token);
    }
    std::string operator()(const MqttReceived& received) const {
        return "<- PUBLISH " + received.message.topic + (received.message.retain ? ", retained " : " ") +
               received.message.payload;
    }
};

}  // namespace

std::string text_of(const MqttAction& action) {
    return std::visit(Text(), action);
}

std::string text_of(const MqttEvent& event) {
    return std::visit(Text(), event);
}

}  // namespace takt::gatewaysim
