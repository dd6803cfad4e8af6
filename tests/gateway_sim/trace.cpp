#include "trace.hpp"

#include <variant>

namespace takt::gatewaysim {
namespace {

using publish::MqttAcknowledged;
using publish::MqttAction;
using publish::MqttClosed;
using publish::MqttConnect;
using publish::MqttConnected;
using publish::MqttDisconnect;
using publish::MqttEvent;
using publish::MqttPublish;
using publish::MqttReceived;
using publish::MqttSubscribe;
using publish::MqttSubscribed;

std::string decimal(std::uint64_t value) {
    return std::to_string(value);
}

struct EventText {
    std::string operator()(const MqttConnect& connect) const {
        return "-> CONNECT " + decimal(connect.connection) + " to " + connect.broker.host + ", version " +
               decimal(static_cast<std::uint64_t>(connect.version));
    }
    std::string operator()(const MqttPublish& publish) const {
        return "-> PUBLISH " + decimal(publish.token) + " QoS " + decimal(publish.message.qos) + " " +
               publish.message.topic + " " + publish.message.payload;
    }
    std::string operator()(const MqttSubscribe& subscribe) const {
        return "-> SUBSCRIBE " + decimal(subscribe.token);
    }
    std::string operator()(const MqttDisconnect& disconnect) const {
        return std::string("-> DISCONNECT") + (disconnect.orderly ? "" : ", without a packet");
    }
    std::string operator()(const MqttConnected& connected) const {
        return "<- CONNACK, receive maximum " + decimal(connected.receive_maximum) + ", QoS " +
               decimal(connected.maximum_qos);
    }
    std::string operator()(const MqttClosed& closed) const {
        return "<- closed: " + std::string(name(closed.failure.kind)) + ", " +
               std::string(name(closed.failure.reason));
    }
    std::string operator()(const MqttAcknowledged& acknowledged) const {
        return "<- PUBACK " + decimal(acknowledged.token) + " " + std::string(name(acknowledged.reason));
    }
    std::string operator()(const MqttSubscribed& subscribed) const {
        return "<- SUBACK " + decimal(subscribed.token);
    }
    std::string operator()(const MqttReceived& received) const {
        return "<- PUBLISH " + received.message.topic + (received.message.retain ? ", retained " : " ") +
               received.message.payload;
    }
    std::string operator()(const publish::MqttOversized& oversized) const {
        return "<- PUBLISH " + oversized.topic + ", too large";
    }
};

}  // namespace

std::string text_of(const MqttAction& action) {
    return std::visit(EventText(), action);
}

std::string text_of(const MqttEvent& event) {
    return std::visit(EventText(), event);
}

}  // namespace takt::gatewaysim
