#include "takt/report/states/state_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "states/problems.hpp"
#include "takt/file/json_members.hpp"
#include "takt/model/name_filter.hpp"
#include "takt/model/service.hpp"
#include "takt/report/drawing/formatting.hpp"
#include "takt/report/drawing/progress_text.hpp"
#include "takt/report/drawing/text_table.hpp"
#include "takt/report/drawing/value_json.hpp"
#include "takt/report/drawing/word_wrap.hpp"
#include "takt/report/states/command_report.hpp"
#include "takt/report/states/event_report.hpp"
#include "takt/report/states/outputs_report.hpp"
#include "takt/report/times/response_times_report.hpp"
#include "takt/text/catalogue.hpp"
#include "takt/text/escape.hpp"
#include "takt/value/text.hpp"

namespace takt::report {
namespace {

using namespace std::chrono_literals;
using value::Quality;

constexpr std::size_t kMostProblems = 20;   // in the text
constexpr std::string_view kLate = "late";  // of device_cause()

// ---- values

/// The current state of one value.
struct ValueState {
    value::SlotInfo info;
    const model::Line* line = nullptr;
    const model::Device* device = nullptr;
    const model::Variable* variable = nullptr;
    value::Value value;
    Quality quality = Quality::good;
    value::Reason reason = value::Reason::ok;
    value::Reason cause = value::Reason::ok;  ///< why its device does not answer
    std::optional<Duration> age;
};

std::string_view unit_of(const ValueState& state) {
    if (state.variable) return state.variable->unit;
    const auto* const service = state.info.service ? model::find_service_field(state.info.name) : nullptr;
    return service ? service->unit : std::string_view();
}

ValueState state_of_slot(const host::Configuration& configuration, value::SlotId slot) {
    return {.info = configuration.info(slot),
            .line = configuration.line_of(slot),
            .device = configuration.device_of(slot),
            .variable = configuration.variable_of(slot)};
}

/// Since the value was good, at the moment `t`.
std::optional<Duration> age_of(std::optional<Instant> sampled_at, Instant t) {
    if (!sampled_at) return std::nullopt;
    return std::max(Duration{}, t - *sampled_at);
}

file::Json json_of(const ValueState& state) {
    auto object = file::Json::object();
    object.set("name", state.info.name);
    if (state.line) object.set("line", state.line->name);
    if (state.device) object.set("device", state.device->name);
    object.set("value", to_json(state.info.type, state.info.scaled, state.value));
    object.set("text", value::format(state.info.type, state.info.scaled, state.value));
    auto words = state.variable ? host::words_of(*state.variable, state.value) : std::string();
    if (!words.empty()) object.set("words", std::move(words));
    if (const auto utc = utc_text(state.info, state.value); !utc.empty()) object.set("utc", utc);
    object.set("unit", unit_of(state));
    object.set("quality", value::name(state.quality));
    object.set("reason", reason_word(state.reason));
    if (state.cause != value::Reason::ok) object.set("cause", reason_word(state.cause));
    object.set("age_ms", state.age ? file::Json(milliseconds(*state.age)) : file::Json());
    return object;
}

file::Json answer(std::string_view command) {
    auto object = file::Json::object();
    object.set("event", "answer");
    object.set("command", command);
    return object;
}

/// The last failure of the device of a variable.
value::Reason cause_of(const host::Snapshot& snapshot, value::SlotId slot) {
    const auto owner = snapshot.configuration->slots().owner(slot);
    const auto* const index = std::get_if<value::VariableIndex>(&owner);
    if (!index || index->device >= snapshot.lines[index->line].devices.size()) return value::Reason::ok;
    return snapshot.lines[index->line].devices[index->device].failure;
}

// ---- status

/// Values by quality.
struct QualityCounts {
    std::size_t good = 0;
    std::size_t uncertain = 0;
    std::size_t bad = 0;
    std::size_t never_read = 0;

    void add(Quality quality) {
        switch (quality) {
            case Quality::good: ++good; break;
            case Quality::uncertain: ++uncertain; break;
            case Quality::bad: ++bad; break;
            case Quality::never_read: ++never_read; break;
        }
    }
    [[nodiscard]] file::Json json() const {
        auto object = file::Json::object();
        object.set("good", good);
        object.set("uncertain", uncertain);
        object.set("bad", bad);
        object.set("never_read", never_read);
        return object;
    }
};

QualityCounts count_values(const host::Snapshot& snapshot, std::size_t line, std::size_t device) {
    QualityCounts counts;
    const auto& variables = snapshot.configuration->project().lines[line].devices[device].variables;
    for (std::size_t v = 0; v < variables.size(); ++v)
        counts.add(
            snapshot.values[snapshot.configuration->slots().variable({line, device, v}).value].quality);
    return counts;
}

/// Failed transactions of a device.
std::uint64_t failed(const bus::TransactionCounters& counters) {
    return counters.timeouts + counters.checksums + counters.unexpected + counters.ambiguous +
           counters.link_lost;
}

/// The text of the event that reported a finding; empty for none.
template <class Found, class Finding>
std::string finding_text(const Texts& texts, const host::Snapshot& snapshot, std::size_t line,
                         std::size_t device, const std::optional<Finding>& finding) {
    if (!finding) return {};
    return event_text(texts, *snapshot.configuration,
                      {.body = Found{.line = line, .device = device, .finding = *finding}});
}

file::Json with_text(file::Json object, const std::string& text) {
    if (!object.is_null() && !text.empty()) object.set("text", text);
    return object;
}

/// The end of the back-off, in milliseconds after the snapshot: zero or less if the next probe is due.
file::Json back_off_json(const poll::DeviceStatistics& device, Instant t) {
    if (!device.next_probe) return {};
    auto object = file::Json::object();
    object.set("next_probe_ms", milliseconds(*device.next_probe - t));
    object.set("pause_ms", milliseconds(device.back_off));
    return object;
}

file::Json device_state_json(const Texts& texts, const host::Snapshot& snapshot, std::size_t line,
                             std::size_t index) {
    const auto& device = snapshot.lines[line].devices[index];
    const auto& settings = snapshot.configuration->project().lines[line].devices[index];
    auto object = file::Json::object();
    object.set("name", settings.name);
    object.set("address", settings.address.value);
    object.set("state", poll::name(device.state));
    const bool broadcast = snapshot.configuration->project().lines[line].is_broadcast(settings);
    if (broadcast) object.set("broadcast", true);
    if (auto cause = device_cause(device); !cause.empty()) object.set("cause", std::move(cause));
    if (is_troubled(device)) object.set("fails_often", true);
    object.set("back_off", back_off_json(device, snapshot.t));
    object.set("values", count_values(snapshot, line, index).json());
    object.set("response_ms", device.counters.time.count() > 0 ? file::Json(milliseconds(device.recent_time))
                                                               : file::Json());
    object.set("sent", device.counters.sent);
    object.set("failed", failed(device.counters));
    object.set("exceptions", device.counters.exceptions);
    object.set("outages", device.outages);
    set_availability(object, device.availability.at(snapshot.t));
    if (broadcast) object.set("availability_percent", file::Json());
    object.set("late_answers", device.late);
    object.set("surplus_answers", device.surplus);
    object.set("delays",
               with_text(finding_json(device.delays),
                         finding_text<host::DelaysFound>(texts, snapshot, line, index, device.delays)));
    object.set("noise",
               with_text(finding_json(device.noise),
                         finding_text<host::NoiseFound>(texts, snapshot, line, index, device.noise)));
    const auto& measured = snapshot.lines[line].times[index];
    object.set("turnaround",
               with_text(turnaround_json(settings, measured), turnaround_text(texts, settings, measured)));
    object.set("late_responses",
               with_text(late_responses_json(measured), late_responses_text(texts, settings, measured)));
    return object;
}

file::Json line_state_json(const Texts& texts, const host::Snapshot& snapshot, std::size_t index) {
    const auto& line = snapshot.lines[index];
    const auto& settings = snapshot.configuration->project().lines[index];
    auto object = file::Json::object();
    object.set("name", settings.name);
    object.set("state", link_word(line));
    if (line.why) object.set("text", texts.describe(*line.why));
    object.set("load", line.statistics.recent_utilization);
    object.set("planned_cycle_ms", milliseconds(line.statistics.planned_cycle));
    object.set("measured_cycle_ms", line.statistics.measured_cycle > Duration::zero()
                                        ? file::Json(milliseconds(line.statistics.measured_cycle))
                                        : file::Json());
    set_availability(object, line.statistics.availability.at(snapshot.t));
    object.set("requests", line.requests.size());
    object.set("overrun", std::ranges::count_if(line.requests, &poll::RequestStatistics::overrun));
    auto devices = file::Json::array();
    for (std::size_t i = 0; i < settings.devices.size(); ++i)
        devices.push_back(device_state_json(texts, snapshot, index, i));
    object.set("devices", std::move(devices));
    return object;
}

// ---- text of JSON

std::string milliseconds_or_dash(const Texts& texts, const file::Json& object, std::string_view key) {
    const auto time = time_member(object, key);
    return time ? texts.duration(*time) : "–";
}

std::string percentage_or_dash(const file::Json& object, std::string_view key) {
    const auto percent = number_member(object, key);
    return percent ? availability_text(*percent / 100) : "–";
}

/// The text of a code; a word that this program does not know stays as it is.
std::string word_text(const Texts& texts, const std::string& prefix, const std::string& word) {
    return text::has(text::Language::english, prefix + word) ? texts(prefix + word) : word;
}

/// The text of what reason_word() returned.
std::string reason_word_text(const Texts& texts, const std::string& reason) {
    constexpr std::string_view kException = "exception ";
    return reason.starts_with(kException)
               ? texts("app.reason.exception", {{"code", reason.substr(kException.size())}})
               : word_text(texts, "app.reason.", reason);
}

/// " (time-out)": why a device does not answer.
std::string cause_text(const Texts& texts, std::string_view cause) {
    return cause.empty() ? std::string() : " (" + reason_word_text(texts, std::string(cause)) + ')';
}

std::string values_counted(const Texts& texts, const file::Json& counts) {
    std::string text;
    for (const auto* const quality : {"good", "uncertain", "bad", "never_read"}) {
        const auto count = count_member(counts, quality);
        if (count == "0") continue;
        text += (text.empty() ? "" : ", ") + count + ' ' + texts(fmt::format("app.quality.{}", quality));
    }
    return text.empty() ? "–" : text;
}

std::string shown_state(const file::Json& device) {
    const auto state = string_member(device, "state");
    const bool works =
        state == poll::name(poll::DeviceState::answering) || state == poll::name(poll::DeviceState::unknown);
    return device.find("broadcast") && works ? "broadcast" : state;
}

std::string line_state_text(const Texts& texts, const file::Json& line, std::size_t columns) {
    std::string text =
        texts("app.ctl.line", {{"line", string_member(line, "name")},
                               {"state", word_text(texts, "app.link.", string_member(line, "state"))},
                               {"load", percent_text(number_member(line, "load").value_or(0))},
                               {"measured", milliseconds_or_dash(texts, line, "measured_cycle_ms")},
                               {"planned", milliseconds_or_dash(texts, line, "planned_cycle_ms")}});
    if (count_member(line, "overrun") != "0")
        text += texts("app.ctl.overrun", {{"count", count_member(line, "overrun")},
                                          {"requests", count_member(line, "requests")}});
    text += '\n';
    if (const auto why = string_member(line, "text"); !why.empty())
        text += "  " + text::escape_line(why) + '\n';
    using enum TextTable::Align;
    TextTable table({left, left, left, right, right, right, right, right});
    table.add({texts("app.device"), texts("app.state"), texts("app.ctl.values"), texts("app.ctl.response"),
               texts("app.sent"), texts("app.failed"), texts("app.outages"), texts("app.available")});
    for (const auto& device : array_member(line, "devices"))
        table.add({string_member(device, "name"),
                   device_state_text(texts, shown_state(device), string_member(device, "cause"),
                                     device.find("fails_often") != nullptr),
                   values_counted(texts, member(device, "values")),
                   milliseconds_or_dash(texts, device, "response_ms"), count_member(device, "sent"),
                   count_member(device, "failed"), count_member(device, "outages"),
                   percentage_or_dash(device, "availability_percent")});
    text += table.render("  ", columns);
    for (const auto& device : array_member(line, "devices"))
        for (const auto* const key : {"turnaround", "late_responses"})  // the others are among the problems
            if (const auto words = string_member(member(device, key), "text"); !words.empty())
                text += "  " + text::escape_line(words) + '\n';
    return text;
}

/// With its unit and its words; "–" for none.
std::string value_with_unit(const file::Json& value) {
    const auto text = string_member(value, "text");
    const auto unit = string_member(value, "unit");
    if (text.empty() && member(value, "value").is_null()) return "–";
    const auto words = string_member(value, "words");
    return text + (unit.empty() ? "" : ' ' + unit) + (words.empty() ? "" : " (" + words + ')');
}

std::string value_age(const Texts& texts, const file::Json& value) {
    const auto age = time_member(value, "age_ms");
    return age && !string_member(value, "device").empty() ? texts.duration(*age) : "";
}

}  // namespace

bool name_matches(std::string_view pattern, std::string_view name) {
    return model::is_wildcard(pattern) ? model::fits(name, pattern) : name.contains(pattern);
}

std::string_view link_word(const host::Snapshot::Line& line) {
    if (line.up) return "connected";
    return line.was_up ? "lost" : "never_connected";
}

std::string device_state_text(const Texts& texts, std::string_view state, std::string_view cause,
                              bool troubled) {
    if (troubled) return texts("app.state.troubled");
    if (state == poll::name(poll::DeviceState::not_answering)) {
        if (cause == reason_word(value::Reason::bad_checksum)) return texts("app.state.damaged");
        if (cause == reason_word(value::Reason::unexpected_reply)) return texts("app.state.unfitting");
        if (cause == kLate) return texts("app.state.late");
    }
    return word_text(texts, "app.state.", std::string(state)) + cause_text(texts, cause);
}

bool fails_often(const poll::DeviceCondition& condition) {
    using enum poll::DeviceState;
    return condition.share.state() == poll::FailureShare::State::failing &&
           (condition.state == answering || condition.state == not_answering);
}

bool is_troubled(const poll::DeviceStatistics& device) {
    return fails_often(device) || (device.state == poll::DeviceState::answering &&
                                   device.refusals.state() == poll::FailureShare::State::failing);
}

bool has_other_id(const poll::DeviceTraffic& device) {
    return device.last_foreign && device.last_foreign->part == Mismatch::Part::transaction;
}

// A device that is slow enough answers requests that the engine has forgotten.
bool mostly_late(const poll::DeviceStatistics& device) {
    const std::uint64_t forgotten = has_other_id(device) ? device.foreign : 0;
    return device.delays && device.late > 0 && 2 * (device.late + forgotten) >= device.counters.timeouts;
}

bool answers_late(const poll::DeviceStatistics& device) {
    using value::Reason;
    const bool missed = device.failure == Reason::timeout ||
                        (device.failure == Reason::unexpected_reply && has_other_id(device));
    return device.state == poll::DeviceState::not_answering && missed && mostly_late(device);
}

std::string device_cause(const poll::DeviceStatistics& device) {
    if (device.failure == value::Reason::ok) return {};
    return answers_late(device) ? std::string(kLate) : reason_word(device.failure);
}

std::string device_state_text(const Texts& texts, const poll::DeviceStatistics& device) {
    return device_state_text(texts, poll::name(device.state), device_cause(device), is_troubled(device));
}

file::Json status_json(const Texts& texts, const host::Snapshot& snapshot, const std::string& time) {
    auto object = answer("status");
    object.set("time", time);
    const auto problems = find_problems(texts, snapshot);
    object.set("health", health_word(snapshot, problems));
    auto listed = file::Json::array();
    for (const auto& problem : problems) listed.push_back(problem_json(problem));
    object.set("problems", std::move(listed));
    object.set("uptime_ms", milliseconds(snapshot.t - snapshot.started));
    QualityCounts counts;
    for (const auto& slot : snapshot.values) counts.add(slot.quality);
    object.set("values", counts.json());
    auto lines = file::Json::array();
    for (std::size_t i = 0; i < snapshot.lines.size(); ++i)
        lines.push_back(line_state_json(texts, snapshot, i));
    object.set("lines", std::move(lines));
    return object;
}

file::Json list_json(const host::Configuration& configuration) {
    file::Json::Array names;
    for (std::uint32_t id = 0; id < configuration.slot_count(); ++id) {
        const auto state = state_of_slot(configuration, {id});
        auto entry = file::Json::object();
        entry.set("name", state.info.name);
        if (state.line) entry.set("line", state.line->name);
        if (state.device) entry.set("device", state.device->name);
        entry.set("type", name(state.info.type));
        entry.set("unit", unit_of(state));
        entry.set("readable", !state.variable || state.variable->read.has_value());
        entry.set("writable", state.variable ? state.variable->write.has_value() : !state.info.service);
        names.push_back(std::move(entry));
    }
    auto object = answer("list");
    object.set("names", file::Json(std::move(names)));
    return object;
}

file::Json values_json(const host::Snapshot& snapshot, const std::string& time, std::string_view pattern) {
    file::Json::Array values;
    for (std::uint32_t id = 0; id < snapshot.values.size(); ++id) {
        if (!name_matches(pattern, snapshot.configuration->info({id}).name)) continue;
        const auto& slot = snapshot.values[id];
        auto state = state_of_slot(*snapshot.configuration, {id});
        state.value = slot.value;
        state.quality = slot.quality;
        state.reason = slot.reason;
        if (slot.reason == value::Reason::not_answering) state.cause = cause_of(snapshot, {id});
        state.age = age_of(slot.sampled_at, snapshot.t);
        values.push_back(json_of(state));
    }
    auto object = answer("values");
    object.set("time", time);
    object.set("values", file::Json(std::move(values)));
    return object;
}

file::Json get_json(const host::Configuration& configuration, const host::Outcome& outcome) {
    auto state =
        outcome.service
            ? ValueState{.info = {.name = model::ServiceNames(configuration.project()).name(*outcome.service),
                                  .type = outcome.service->field->type,
                                  .local = true,
                                  .service = true}}
            : state_of_slot(configuration, outcome.slot);
    state.value = outcome.value;
    state.quality = outcome.quality;
    state.reason = outcome.reason;
    state.cause = outcome.cause;
    state.age = age_of(outcome.sampled_at, outcome.t);
    auto object = answer("get");
    const auto entry = json_of(state);
    for (const auto& [key, value] : std::get<file::Json::Object>(entry.value())) object.set(key, value);
    return object;
}

std::string status_text(const Texts& texts, const file::Json& status, std::size_t columns) {
    const auto uptime = time_member(status, "uptime_ms");
    std::string text =
        texts("app.ctl.status", {{"health", word_text(texts, "app.health.", string_member(status, "health"))},
                                 {"time", texts.duration(uptime.value_or(Duration{}))},
                                 {"values", values_counted(texts, member(status, "values"))}}) +
        '\n';
    text += wrapped(problems_text(texts, member(status, "problems"), kMostProblems), columns);
    for (const auto& line : array_member(status, "lines"))
        text += '\n' + line_state_text(texts, line, columns);
    const auto outputs = outputs_text(texts, status);
    return outputs.empty() ? text : text + '\n' + wrapped(outputs, columns);
}

std::string list_text(const Texts& texts, const file::Json& list, std::size_t columns) {
    using enum TextTable::Align;
    TextTable table({left, whole, left, left, left});
    table.add({texts("app.device"), texts("app.variable"), texts("app.ctl.type"), texts("app.ctl.unit"),
               texts("app.ctl.access")});
    for (const auto& entry : array_member(list, "names")) {
        const auto is = [&](const char* key) { return member(entry, key) == file::Json(true); };
        const auto* const access = !is("writable")  ? "app.ctl.access.read"
                                   : is("readable") ? "app.ctl.access.both"
                                                    : "app.ctl.access.write";
        table.add({string_member(entry, "device"), string_member(entry, "name"), string_member(entry, "type"),
                   string_member(entry, "unit"), texts(access)});
    }
    return table.render("", columns);
}

std::string values_text(const Texts& texts, const file::Json& values, std::size_t columns) {
    using enum TextTable::Align;
    TextTable table({left, whole, right, right, whole});
    table.add({texts("app.device"), texts("app.variable"), texts("app.value"), texts("app.age"),
               texts("app.ctl.quality")});
    for (const auto& entry : array_member(values, "values"))
        table.add({string_member(entry, "device"), string_member(entry, "name"),
                   fitted(value_with_unit(entry), columns / 3), value_age(texts, entry),
                   quality_text(texts, entry)});
    return table.render("", columns);
}

std::string get_line(const file::Json& value) {
    std::string line = "ok";
    const auto quality = string_member(value, "quality");
    const bool good = quality == value::name(Quality::good);
    for (const auto& part : {string_member(value, "name"), string_member(value, "text"), good ? "" : quality,
                             good ? "" : string_member(value, "reason")})
        if (!part.empty()) line += ' ' + part;
    return line;
}

std::string quality_text(const Texts& texts, const file::Json& value) {
    auto text = word_text(texts, "app.quality.", string_member(value, "quality"));
    if (const auto reason = string_member(value, "reason"); !reason.empty())
        text += ", " + reason_word_text(texts, reason);
    return text + cause_text(texts, string_member(value, "cause"));
}

}  // namespace takt::report
