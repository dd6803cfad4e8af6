// Properties of MQTT 5 to and from those of libmosquitto.
#pragma once

#include <mosquitto.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "takt/publish/mqtt_port.hpp"

namespace takt::publish {

struct FreeMosquittoProperties {
    void operator()(mosquitto_property* properties) const { mosquitto_property_free_all(&properties); }
};
using MosquittoProperties = std::unique_ptr<mosquitto_property, FreeMosquittoProperties>;

/// Null for none. @returns none: libmosquitto rejects a property
[[nodiscard]] std::optional<MosquittoProperties> to_mosquitto(const MqttProperties& properties);

/// Properties of a received PUBLISH.
[[nodiscard]] MqttProperties from_mosquitto(const mosquitto_property* properties);

/// The limits of CONNACK.
[[nodiscard]] MqttConnected connack_limits(const mosquitto_property* properties);

/// The Reason String; empty: none.
[[nodiscard]] std::string reason_string(const mosquitto_property* properties);

}  // namespace takt::publish
