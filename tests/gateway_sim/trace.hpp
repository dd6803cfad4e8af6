// Events of a run as lines.
#pragma once

#include <string>

#include "takt/publish/mqtt_port.hpp"

namespace takt::gatewaysim {

[[nodiscard]] std::string text_of(const publish::MqttAction& action);
[[nodiscard]] std::string text_of(const publish::MqttEvent& event);

}  // namespace takt::gatewaysim
