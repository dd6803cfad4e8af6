#include "mqtt/mosquitto_library.hpp"

#include <mosquitto.h>

namespace takt::publish {

int use_mosquitto_library() {
    static const int version = [] {
        mosquitto_lib_init();
        return mosquitto_lib_version(nullptr, nullptr, nullptr);
    }();
    return version;
}

}  // namespace takt::publish
