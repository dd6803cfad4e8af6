#include "takt/wire/traffic.hpp"

namespace takt::wire {

std::string_view name(Incident incident) {
    switch (incident) {
        case Incident::no_response: return "no_response";
        case Incident::late_response: return "late_response";
        case Incident::surplus_response: return "surplus_response";
        case Incident::connected: return "connected";
        case Incident::disconnected: return "disconnected";
    }
    return "incident";
}

}  // namespace takt::wire
