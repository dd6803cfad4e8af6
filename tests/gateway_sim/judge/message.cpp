#include "message.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <utility>

namespace takt::gatewaysim {
namespace {

using file::Json;

std::optional<std::uint64_t> integer(const Json* json) {
    if (json == nullptr) return std::nullopt;
    if (const auto* i = std::get_if<std::int64_t>(&json->value()); i && *i >= 0)
        return static_cast<std::uint64_t>(*i);
    if (const auto* u = std::get_if<std::uint64_t>(&json->value())) return *u;
    return std::nullopt;
}

std::optional<std::string> string_of(const Json* json) {
    if (json == nullptr) return std::nullopt;
    const auto* s = std::get_if<std::string>(&json->value());
    return s ? std::optional(*s) : std::nullopt;
}

std::optional<double> real(const Json::Value& value) {
    if (const auto* i = std::get_if<std::int64_t>(&value)) return static_cast<double>(*i);
    if (const auto* u = std::get_if<std::uint64_t>(&value)) return static_cast<double>(*u);
    if (const auto* d = std::get_if<double>(&value)) return *d;
    return std::nullopt;
}

std::optional<SeenGap> read_gap(const Json& message, const Json& gap) {
    const auto number = integer(message.find("seq"));
    const auto samples = integer(gap.find("samples"));
    const auto cause = string_of(gap.find("cause"));
    const auto first = string_of(gap.find("first"));
    const auto last = string_of(gap.find("last"));
    if (!number || !samples || !cause || !first || !last) return std::nullopt;
    return SeenGap{*number, *cause, *samples, *first, *last};
}

bool read_group(const Json& values, SeenMessage& into) {
    const auto* object = std::get_if<Json::Object>(&values.value());
    if (object == nullptr || object->empty()) return false;
    for (const auto& [variable, fields] : *object) {
        const auto number = integer(fields.find("seq"));
        if (!number) return false;
        into.samples.push_back({*number, variable, fields});
    }
    return true;
}

bool is_same(const Json* json, const publish::Series& series, const value::Value& value) {
    if (json == nullptr) return false;
    const auto& seen = json->value();
    if (const auto* b = std::get_if<bool>(&value)) return seen == Json::Value(*b);
    if (const auto* s = std::get_if<std::string>(&value)) return seen == Json::Value(*s);
    if (const auto* i = std::get_if<std::int64_t>(&value)) return real(seen) == static_cast<double>(*i);
    if (const auto* u = std::get_if<std::uint64_t>(&value)) return real(seen) == static_cast<double>(*u);
    const auto* d = std::get_if<double>(&value);
    if (d == nullptr || !std::isfinite(*d)) return json->is_null();
    const auto number = real(seen);
    if (!number) return false;
    const bool single = series.type == DataType::float32 && !series.scaled;
    return single ? static_cast<float>(*number) == static_cast<float>(*d) : *number == *d;
}

std::string differs(const char* key, const std::string& expected, const Json* seen) {
    return std::string(key) + ": " + expected + " became " + (seen ? seen->dump() : "nothing");
}

std::optional<SeenMessage> read_object(const Json& json) {
    const auto epoch = integer(json.find("epoch"));
    if (!epoch) return std::nullopt;
    SeenMessage message{.epoch = *epoch};
    const auto* repeated = json.find("repeated");
    message.repeated = repeated != nullptr && repeated->value() == Json::Value(true);
    message.device = string_of(json.find("device")).value_or("");
    if (const auto* gap = json.find("gap")) {
        message.gap = read_gap(json, *gap);
        return message.gap ? std::optional(message) : std::nullopt;
    }
    if (const auto* values = json.find("values"))
        return read_group(*values, message) ? std::optional(message) : std::nullopt;
    const auto number = integer(json.find("seq"));
    const auto variable = string_of(json.find("variable"));
    if (!number || !variable) return std::nullopt;
    message.samples.push_back({*number, *variable, json});
    return message;
}

/// The elements are in order and alike but for their samples.
std::optional<SeenMessage> read_array(const Json::Array& array) {
    if (array.size() < 2) return std::nullopt;
    std::optional<SeenMessage> all;
    std::uint64_t last_start = 0;
    for (const auto& element : array) {
        const auto message = read_object(element);
        if (!message || message->gap) return std::nullopt;
        const auto start = std::ranges::min(message->samples, {}, &SeenSample::number).number;
        if (start <= std::exchange(last_start, start)) return std::nullopt;
        if (!all) {
            all = message;
            continue;
        }
        if (message->epoch != all->epoch || message->repeated != all->repeated ||
            message->device != all->device)
            return std::nullopt;
        all->samples.insert(all->samples.end(), message->samples.begin(), message->samples.end());
    }
    return all;
}

}  // namespace

std::optional<SeenMessage> read_message(std::string_view payload) {
    const auto json = Json::parse(payload);
    if (!json) return std::nullopt;
    if (const auto* array = std::get_if<Json::Array>(&json->value())) return read_array(*array);
    return read_object(*json);
}

std::string time_text(std::int64_t wall_ns) {
    using namespace std::chrono;
    const auto ms = floor<milliseconds>(nanoseconds(wall_ns));
    const auto day = floor<days>(ms);
    const year_month_day date{sys_days(day)};
    const auto rest = (ms - day).count();
    char buffer[48];
    std::snprintf(buffer, sizeof buffer, "%04d-%02u-%02uT%02d:%02d:%02d.%03dZ", static_cast<int>(date.year()),
                  static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()),
                  static_cast<int>(rest / 3'600'000), static_cast<int>(rest / 60'000 % 60),
                  static_cast<int>(rest / 1000 % 60), static_cast<int>(rest % 1000));
    return buffer;
}

std::string difference(const Json& fields, const publish::Series& series, const publish::Sample& sample) {
    const auto* value = fields.find("value");
    if (!is_same(value, series, sample.value)) return differs("value", "the sampled one", value);
    const auto same_text = [&](const char* key, const std::string& expected) {
        const auto* seen = fields.find(key);
        const bool good = expected.empty() ? seen == nullptr : string_of(seen) == expected;
        return good ? std::string() : differs(key, expected.empty() ? "none" : expected, seen);
    };
    const bool good = sample.reason == value::Reason::ok;
    const auto previous = sample.previous_wall_ns ? time_text(*sample.previous_wall_ns) : std::string();
    const bool is_good = sample.quality == value::Quality::good;
    for (const auto& [key, expected] :
         {std::pair<const char*, std::string>{"quality", std::string(value::name(sample.quality))},
          {"reason", good ? std::string() : std::string(value::name(sample.reason))},
          {"time", time_text(sample.wall_ns)},
          {"after", is_good ? previous : ""},
          {"last_good", is_good ? "" : previous},
          {"cause", std::string(publish::name(sample.cause))},
          {"unit", series.unit}})
        if (auto wrong = same_text(key, expected); !wrong.empty()) return wrong;
    return {};
}

}  // namespace takt::gatewaysim
