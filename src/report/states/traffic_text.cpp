#include "takt/report/states/traffic_text.hpp"

namespace takt::report {

std::string incident_text(const Texts& texts, wire::Incident incident, Duration after,
                          const std::optional<Mismatch>& instead) {
    const auto code = std::string("incident.").append(wire::name(incident));
    if (!instead) return texts(code, {{"time", texts.duration(after)}});
    return texts(code + ".instead", {{"time", texts.duration(after)},
                                     {"what", text::what(texts.language(), misdirected({}, *instead))}});
}

std::string fault_text(const Texts& texts, wire::FrameFault fault) {
    return texts(std::string("fault.").append(wire::name(fault)));
}

}  // namespace takt::report
