// Traffic in words, in the language of the reader.
#pragma once

#include <optional>
#include <string>

#include "takt/base/engine.hpp"
#include "takt/report/drawing/texts.hpp"
#include "takt/wire/frame.hpp"
#include "takt/wire/traffic.hpp"

namespace takt::report {

/// "no response within 500 ms", "late response: late by 12.0 ms", "surplus response: a response of unit 1
/// came, unit 5 was asked".
[[nodiscard]] std::string incident_text(const Texts& texts, wire::Incident incident, Duration after,
                                        const std::optional<Mismatch>& instead);

/// Why a frame was dropped: "checksum wrong".
[[nodiscard]] std::string fault_text(const Texts& texts, wire::FrameFault fault);

}  // namespace takt::report
