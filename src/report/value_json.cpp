#include "takt/report/value_json.hpp"

#include <fmt/chrono.h>

#include <cstdint>
#include <ctime>
#include <variant>

#include "takt/model/service.hpp"

namespace takt::report {

std::string utc_text(const value::SlotInfo& info, const value::Value& value) {
    const auto* const seconds = std::get_if<std::uint64_t>(&value);
    const auto* const field = info.service ? model::find_service_field(info.name) : nullptr;
    if (field == nullptr || field->value != model::ServiceValue::time || seconds == nullptr) return {};
    return fmt::format("{:%Y-%m-%dT%H:%M:%S}Z", fmt::gmtime(static_cast<std::time_t>(*seconds)));
}

file::Json error_json(const Texts& texts, const Error& error) {
    auto object = file::Json::object();
    object.set("code", name(error.code));
    object.set("text", texts.describe(error));
    return object;
}

}  // namespace takt::report
