#include "takt/publish/mqtt_status.hpp"

namespace takt::publish {

std::string_view name(MqttState state) {
    switch (state) {
        case MqttState::off: return "off";
        case MqttState::connecting: return "connecting";
        case MqttState::connected: return "connected";
        case MqttState::leaving: return "leaving";
        case MqttState::backing_off: return "backing_off";
        case MqttState::stopped: return "stopped";
    }
    return "unknown";
}

}  // namespace takt::publish
