// What `takt check --firmware` computes, as text and as JSON.
#pragma once

#include <string>

#include "takt/file/json.hpp"
#include "takt/plan/firmware_estimate.hpp"
#include "takt/report/drawing/texts.hpp"

namespace takt::report {

/// A table of what the clocks allow, then wake-ups, current and assumptions.
[[nodiscard]] std::string firmware_text(const Texts& texts, const model::Firmware& firmware,
                                        const plan::FirmwareEstimate& estimate);

/// The keys of docs/commands/check.md.
[[nodiscard]] file::Json firmware_json(const plan::FirmwareEstimate& estimate);

}  // namespace takt::report
