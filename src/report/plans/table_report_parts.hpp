// Shared parts of the reports of both table formats.
#pragma once

#include <cstdint>
#include <string>

#include "takt/base/time.hpp"
#include "takt/file/json.hpp"
#include "takt/report/drawing/texts.hpp"

namespace takt::report {

/// null for 0, which is no function
[[nodiscard]] file::Json function_code_json(std::uint8_t function);
[[nodiscard]] std::string checksum_text(std::uint32_t checksum);
[[nodiscard]] std::string heading(const Texts& texts, const char* format, std::uint16_t version,
                                  std::size_t bytes, std::uint32_t checksum);
[[nodiscard]] std::string device_text(const Texts& texts, const std::string& name, int unit, Duration period,
                                      Duration timeout, int attempts);

}  // namespace takt::report
