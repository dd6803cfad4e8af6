#include "mqtt/mosquitto_properties.hpp"

#include <mqtt_protocol.h>

#include <cstdlib>

namespace takt::publish {
namespace {

std::string read_string(const mosquitto_property* properties, int identifier) {
    char* text = nullptr;
    if (!mosquitto_property_read_string(properties, identifier, &text, false) || !text) return {};
    std::string copy(text);
    std::free(text);
    return copy;
}

bool add_text(mosquitto_property** list, int identifier, const std::string& text) {
    return text.empty() || mosquitto_property_add_string(list, identifier, text.c_str()) == MOSQ_ERR_SUCCESS;
}

std::vector<MqttUserProperty> user_properties(const mosquitto_property* properties) {
    std::vector<MqttUserProperty> users;
    char* name = nullptr;
    char* value = nullptr;
    const mosquitto_property* found = properties;
    for (bool skip = false;
         (found = mosquitto_property_read_string_pair(found, MQTT_PROP_USER_PROPERTY, &name, &value, skip));
         skip = true) {
        users.push_back({name ? name : "", value ? value : ""});
        std::free(name);
        std::free(value);
        name = value = nullptr;
    }
    return users;
}

}  // namespace

std::optional<MosquittoProperties> to_mosquitto(const MqttProperties& properties) {
    mosquitto_property* list = nullptr;
    bool good = add_text(&list, MQTT_PROP_RESPONSE_TOPIC, properties.response_topic) &&
                add_text(&list, MQTT_PROP_CONTENT_TYPE, properties.content_type);
    const auto& correlation = properties.correlation_data;
    if (good && !correlation.empty())
        good =
            correlation.size() <= UINT16_MAX &&
            mosquitto_property_add_binary(&list, MQTT_PROP_CORRELATION_DATA, correlation.data(),
                                          static_cast<std::uint16_t>(correlation.size())) == MOSQ_ERR_SUCCESS;
    if (good && properties.expiry_s)
        good = mosquitto_property_add_int32(&list, MQTT_PROP_MESSAGE_EXPIRY_INTERVAL, *properties.expiry_s) ==
               MOSQ_ERR_SUCCESS;
    for (const auto& user : properties.user)
        good = good && mosquitto_property_add_string_pair(&list, MQTT_PROP_USER_PROPERTY, user.name.c_str(),
                                                          user.value.c_str()) == MOSQ_ERR_SUCCESS;
    MosquittoProperties owned(list);
    if (!good) return {};
    return owned;
}

MqttProperties from_mosquitto(const mosquitto_property* properties) {
    MqttProperties result;
    if (!properties) return result;
    result.response_topic = read_string(properties, MQTT_PROP_RESPONSE_TOPIC);
    result.content_type = read_string(properties, MQTT_PROP_CONTENT_TYPE);
    void* data = nullptr;
    std::uint16_t length = 0;
    if (mosquitto_property_read_binary(properties, MQTT_PROP_CORRELATION_DATA, &data, &length, false)) {
        if (data) result.correlation_data.assign(static_cast<const char*>(data), length);
        std::free(data);
    }
    std::uint32_t expiry = 0;
    if (mosquitto_property_read_int32(properties, MQTT_PROP_MESSAGE_EXPIRY_INTERVAL, &expiry, false))
        result.expiry_s = expiry;
    result.user = user_properties(properties);
    return result;
}

MqttConnected connack_limits(const mosquitto_property* properties) {
    MqttConnected limits;
    if (!properties) return limits;
    std::uint16_t number = 0;
    if (mosquitto_property_read_int16(properties, MQTT_PROP_RECEIVE_MAXIMUM, &number, false) && number > 0)
        limits.receive_maximum = number;
    if (mosquitto_property_read_int16(properties, MQTT_PROP_SERVER_KEEP_ALIVE, &number, false))
        limits.server_keep_alive = number;
    std::uint32_t size = 0;
    if (mosquitto_property_read_int32(properties, MQTT_PROP_MAXIMUM_PACKET_SIZE, &size, false) && size > 0)
        limits.maximum_packet = size;
    std::uint8_t byte = 0;
    if (mosquitto_property_read_byte(properties, MQTT_PROP_MAXIMUM_QOS, &byte, false))
        limits.maximum_qos = byte;
    if (mosquitto_property_read_byte(properties, MQTT_PROP_RETAIN_AVAILABLE, &byte, false))
        limits.retain_available = byte != 0;
    return limits;
}

std::string reason_string(const mosquitto_property* properties) {
    return properties ? read_string(properties, MQTT_PROP_REASON_STRING) : std::string();
}

}  // namespace takt::publish
