// A range of registers in every type and byte order (takt read --type all).
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "takt/file/json.hpp"
#include "takt/report/drawing/texts.hpp"
#include "takt/report/states/client_report.hpp"

namespace takt::report {

/// Tables: each register in hexadecimal and binary, signed and unsigned, in both byte orders; then from each
/// register on the integers and floating-point numbers of two and four registers in four orders, as far as
/// the range goes; then the range as text; at the end the orders by name and permutation.
[[nodiscard]] std::string all_types_text(const Texts& texts, std::uint16_t start,
                                         std::span<const std::uint16_t> registers);

/// The object that `takt read --type all --json` prints (docs/commands/read.md).
[[nodiscard]] file::Json all_types_json(const Texts& texts, const ClientRun& run,
                                        const client::ReadSpec& spec,
                                        std::span<const std::uint16_t> registers, const Result<void>& ended);

}  // namespace takt::report
