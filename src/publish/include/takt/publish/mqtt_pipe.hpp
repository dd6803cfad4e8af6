// The interface of the transport of an MQTT session.
#pragma once

#include <optional>

#include "takt/publish/mqtt_port.hpp"

namespace takt::publish {

/// Carries out the actions of one MqttSession and reports what happens. One thread uses it; nothing blocks.
class MqttPipe {
public:
    virtual ~MqttPipe() = default;

    virtual void send(MqttAction&& action) = 0;
    [[nodiscard]] virtual std::optional<MqttEvent> next_event() = 0;
    /// Readable while next_event() would return something; for poll().
    [[nodiscard]] virtual int descriptor() const = 0;
};

}  // namespace takt::publish
