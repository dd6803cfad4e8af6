#include "takt/publish/message_format.hpp"

#include <cmath>
#include <utility>
#include <variant>

#include "takt/base/assert.hpp"
#include "takt/base/iso_time.hpp"
#include "takt/file/json.hpp"
#include "takt/host/value_json.hpp"

namespace takt::publish {
namespace {

using file::Json;

/// Numbers that JSON cannot have.
std::string_view special_number(const value::Value& value) {
    const auto* const number = std::get_if<double>(&value);
    if (number == nullptr || std::isfinite(*number)) return {};
    if (std::isnan(*number)) return "nan";
    return *number > 0 ? "infinity" : "-infinity";
}

void set_reason(Json& object, std::string_view key, value::Reason reason) {
    object.set(key, value::name(reason));
    if (value::is_exception(reason)) object.set("exception", value::status_code(reason) & 0xFFU);
}

void set_value(Json& object, const PlacedSample& placed) {
    const auto& sample = *placed.sample;
    object.set("value", host::to_json(placed.series->type, placed.series->scaled, sample.value));
    if (const auto special = special_number(sample.value); !special.empty()) object.set("special", special);
    if (!placed.series->unit.empty()) object.set("unit", placed.series->unit);
    object.set("quality", value::name(sample.quality));
    if (sample.reason != value::Reason::ok) set_reason(object, "reason", sample.reason);
    object.set("time", utc_time_text(sample.wall_ns));
    const bool good = sample.quality == value::Quality::good;
    if (sample.previous_wall_ns)
        object.set(good ? "after" : "last_good", utc_time_text(*sample.previous_wall_ns));
    object.set("cause", name(sample.cause));
}

void set_place(Json& object, std::uint64_t epoch, std::uint64_t number, bool repeated) {
    object.set("epoch", epoch);
    object.set("seq", number);
    if (repeated) object.set("repeated", true);
}

Json counters_of(const bus::TransactionCounters& counters) {
    auto object = Json::object();
    object.set("sent", counters.sent);
    object.set("answered", counters.answered);
    object.set("exceptions", counters.exceptions);
    object.set("timeouts", counters.timeouts);
    object.set("checksum_errors", counters.checksums);
    return object;
}

Json line_of(const model::Line& line, const host::Snapshot::Line& state) {
    auto object = Json::object();
    object.set("name", line.name);
    object.set("up", state.up);
    if (state.why) object.set("why", takt::name(state.why->code));
    object.set("utilization", std::round(state.statistics.recent_utilization * 1000) / 1000);
    return object;
}

Json device_of(const model::Line& line, const model::Device& device, const poll::DeviceStatistics& state) {
    auto object = Json::object();
    object.set("name", device.name);
    object.set("line", line.name);
    object.set("state", poll::name(state.state));
    if (state.failure != value::Reason::ok) set_reason(object, "cause", state.failure);
    object.set("counters", counters_of(state.counters));
    return object;
}

}  // namespace

std::string variable_message(const PlacedSample& sample, std::uint64_t epoch, bool repeated) {
    auto object = Json::object();
    object.set("variable", sample.series->variable);
    if (!sample.series->device.empty()) object.set("device", sample.series->device);
    set_value(object, sample);
    set_place(object, epoch, sample.number, repeated);
    return object.dump();
}

std::string group_message(std::span<const PlacedSample> samples, std::uint64_t epoch, bool repeated) {
    TAKT_ASSERT(!samples.empty());
    auto object = Json::object();
    if (const auto& device = samples.front().series->device; !device.empty()) object.set("device", device);
    Json::Object values;
    for (const auto& sample : samples) {
        auto value = Json::object();
        set_value(value, sample);
        value.set("seq", sample.number);
        values.emplace_back(sample.series->variable, std::move(value));
    }
    object.set("values", Json(std::move(values)));
    object.set("epoch", epoch);
    if (repeated) object.set("repeated", true);
    return object.dump();
}

std::string gap_message(const MissingSamples& missing, std::uint64_t epoch, bool repeated) {
    auto what = Json::object();
    what.set("cause", missing.cause);
    what.set("samples", missing.samples);
    what.set("first", utc_time_text(missing.first_wall_ns));
    what.set("last", utc_time_text(missing.last_wall_ns));
    auto object = Json::object();
    object.set("gap", std::move(what));
    set_place(object, epoch, missing.first_number, repeated);
    return object.dump();
}

std::string state_message(bool online) {
    auto object = Json::object();
    object.set("state", online ? "online" : "offline");
    return object.dump();
}

std::string status_message(const host::Snapshot& snapshot, std::int64_t wall_ns) {
    const auto& project = snapshot.configuration->project();
    auto lines = Json::array();
    auto devices = Json::array();
    for (std::size_t i = 0; i < project.lines.size(); ++i) {
        const auto& line = project.lines[i];
        lines.push_back(line_of(line, snapshot.lines[i]));
        for (std::size_t k = 0; k < line.devices.size(); ++k)
            devices.push_back(device_of(line, line.devices[k], snapshot.lines[i].devices[k]));
    }
    auto object = Json::object();
    object.set("time", utc_time_text(wall_ns));
    object.set("started", utc_time_text(wall_ns - (snapshot.t - snapshot.started).count()));
    object.set("lines", std::move(lines));
    object.set("devices", std::move(devices));
    return object.dump();
}

}  // namespace takt::publish
