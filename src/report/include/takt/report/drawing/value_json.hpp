// Values as JSON.
#pragma once

#include <string>

#include "takt/base/data_type.hpp"
#include "takt/base/result.hpp"
#include "takt/file/json.hpp"
#include "takt/host/value_json.hpp"
#include "takt/report/drawing/texts.hpp"
#include "takt/value/store.hpp"
#include "takt/value/value.hpp"

namespace takt::report {

using host::to_json;

/// "2026-11-22T22:51:33Z" of `system.time`; empty of all other values.
[[nodiscard]] std::string utc_text(const value::SlotInfo& info, const value::Value& value);

/// An error as {"code", "text"}.
[[nodiscard]] file::Json error_json(const Texts& texts, const Error& error);

}  // namespace takt::report
