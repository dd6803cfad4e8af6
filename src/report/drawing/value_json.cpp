#include "takt/report/drawing/value_json.hpp"

#include <cstdint>
#include <variant>

#include "takt/base/iso_time.hpp"
#include "takt/model/service.hpp"

namespace takt::report {

std::string utc_text(const value::SlotInfo& info, const value::Value& value) {
    const auto* const seconds = std::get_if<std::uint64_t>(&value);
    const auto* const field = info.service ? model::find_service_field(info.name) : nullptr;
    if (field == nullptr || field->value != model::ServiceValue::time || seconds == nullptr) return {};
    return utc_time_text(static_cast<std::int64_t>(*seconds) * kNanosecondsPerSecond, Fraction::none);
}

file::Json error_json(const Texts& texts, const Error& error) {
    auto object = file::Json::object();
    object.set("code", name(error.code));
    object.set("text", texts.describe(error));
    return object;
}

}  // namespace takt::report
