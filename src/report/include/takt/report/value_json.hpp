// Values as JSON.
#pragma once

#include <string>

#include "takt/base/data_type.hpp"
#include "takt/base/result.hpp"
#include "takt/file/json.hpp"
#include "takt/report/texts.hpp"
#include "takt/value/store.hpp"
#include "takt/value/value.hpp"

namespace takt::report {

/// null, true, a number, a text. A `float` has the digits of a float (0.1, not 0.10000000149011612). NaN and
/// infinity, which JSON does not have, are null.
[[nodiscard]] file::Json to_json(DataType type, bool scaled, const value::Value& value);

/// "2026-11-22T22:51:33Z" of `system.time`; empty of all other values.
[[nodiscard]] std::string utc_text(const value::SlotInfo& info, const value::Value& value);

/// An error as {"code", "text"}.
[[nodiscard]] file::Json error_json(const Texts& texts, const Error& error);

}  // namespace takt::report
