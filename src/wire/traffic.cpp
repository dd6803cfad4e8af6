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

Mismatch mismatch(const ExchangeKey& came, const ExchangeKey& asked) {
    using enum Mismatch::Part;
    if (came.unit != asked.unit) return {unit, came.unit.value, asked.unit.value};
    if (came.function != asked.function) return {function, came.function, asked.function};
    return {transaction, came.wire_id, asked.wire_id};
}

}  // namespace takt::wire
