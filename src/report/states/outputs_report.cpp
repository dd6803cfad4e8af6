#include "takt/report/states/outputs_report.hpp"

#include <algorithm>
#include <chrono>
#include <string_view>
#include <variant>

#include "states/problems.hpp"
#include "takt/base/iso_time.hpp"
#include "takt/file/json_members.hpp"
#include "takt/publish/message_format.hpp"
#include "takt/report/drawing/formatting.hpp"
#include "takt/report/drawing/value_json.hpp"
#include "takt/report/states/state_report.hpp"

namespace takt::report {
namespace {

Duration waiting_since(const publish::OutputStatus& status, std::int64_t wall_ns) {
    return Duration(std::max<std::int64_t>(0, wall_ns - status.oldest_waiting_ns.value_or(wall_ns)));
}

file::Json mqtt_json(const publish::MqttStatus& status) {
    auto object = file::Json::object();
    object.set("state", publish::name(status.state));
    if (status.version) object.set("version", *status.version == publish::MqttVersion::v5 ? "5" : "3.1.1");
    object.set("window", status.window);
    object.set("round_trip_ms",
               status.round_trip ? file::Json(milliseconds(*status.round_trip)) : file::Json());
    object.set("in_flight", status.in_flight);
    object.set("published", status.counters.published);
    object.set("acknowledged", status.counters.acknowledged);
    object.set("repeated", status.counters.repeated);
    object.set("no_subscribers", status.counters.no_subscribers);
    object.set("unproved", status.counters.unproved);
    object.set("refused", status.counters.refused);
    object.set("connects", status.counters.connects);
    object.set("lost_connections", status.counters.lost_connections);
    object.set("oversized", status.counters.oversized);
    if (status.counters.oversized == 0) return object;
    auto last = file::Json::object();
    last.set("topic", status.last_oversized.topic);
    last.set("bytes", status.last_oversized.bytes);
    object.set("last_oversized", std::move(last));
    return object;
}

std::string behind_advice(const Texts& texts, const publish::OutputStatus& status) {
    return texts("problem.advice.falls_behind", {{"remedies", texts.remedies(status.remedies)}});
}

/// Null unless it falls behind.
file::Json behind_json(const Texts& texts, const publish::OutputStatus& status) {
    if (status.behind_per_s == 0 || !status.mqtt) return {};
    const auto round_trip = status.mqtt->round_trip.value_or(Duration{});
    auto object = file::Json::object();
    object.set("samples_per_s", status.behind_per_s);
    object.set("text",
               texts("app.output.behind",
                     {{"rate", std::to_string(status.behind_per_s)},
                      {"window", std::to_string(status.mqtt->window)},
                      {"round_trip",
                       std::to_string(std::chrono::round<std::chrono::milliseconds>(round_trip).count())}}));
    object.set("advice", behind_advice(texts, status));
    return object;
}

file::Json journal_json(const Texts& texts, const publish::OutputStatus& status) {
    auto object = file::Json::object();
    object.set("epoch", status.journal.epoch);
    object.set("disk_bytes", status.journal.disk_bytes);
    object.set("buffer_bytes", status.journal.buffer_bytes);
    object.set("buffer_samples", status.journal.buffer_samples);
    object.set("samples_lost", status.journal.samples_lost);
    object.set("dropped_segments", status.journal.dropped_segments);
    object.set("torn_bytes", status.journal.torn_bytes);
    object.set("set_aside",
               status.journal.set_aside.empty() ? file::Json() : file::Json(status.journal.set_aside));
    object.set("disk_waits_ms", milliseconds(status.disk_waits));
    object.set("failure", status.journal_failure ? error_json(texts, *status.journal_failure) : file::Json());
    return object;
}

/// The line of an object of output_json(); keys that are missing are left out.
std::string output_line(const Texts& texts, const file::Json& output) {
    const auto* const behind = output.find("falls_behind");
    const auto behind_text =
        behind != nullptr && !behind->is_null() ? scalar_text(member(*behind, "text")) : std::string();
    auto text = texts(
        "app.output.state",
        {{"name", scalar_text(member(output, "name"))},
         {"state", texts("app.output." + scalar_text(member(output, "state")), {{"behind", behind_text}})},
         {"destination", scalar_text(member(output, "destination"))},
         {"delivered", scalar_text(member(output, "delivered"))},
         {"waiting", scalar_text(member(output, "waiting"))}});
    if (const auto* const age = output.find("oldest_waiting_ms"); age != nullptr && !age->is_null())
        text +=
            texts("app.output.oldest",
                  {{"age", texts.duration(time_member(output, "oldest_waiting_ms").value_or(Duration{}))}});
    if (const auto dropped = scalar_text(member(output, "dropped")); !dropped.empty() && dropped != "0")
        text += texts("app.output.dropped", {{"count", dropped}});
    if (const auto gaps = scalar_text(member(output, "gaps")); !gaps.empty() && gaps != "0")
        text += texts("app.output.gaps", {{"count", gaps}});
    if (const auto failure = scalar_text(member(output, "failure")); !failure.empty())
        text += texts("app.output.failure", {{"failure", failure}});
    if (const auto count = scalar_text(member(output, "commands_unrecorded")); !count.empty() && count != "0")
        text += texts("app.output.unrecorded", {{"count", count}});
    if (const auto count = scalar_text(member(output, "too_large")); !count.empty() && count != "0")
        text += texts("app.output.too_large", {{"count", count}});
    if (const auto count = scalar_text(member(output, "damaged")); !count.empty() && count != "0")
        text += texts("app.output.damaged", {{"count", count}});
    if (const auto aside = scalar_text(member(output, "set_aside")); !aside.empty())
        text += texts("app.output.set_aside", {{"file", aside}});
    const auto* const mqtt = output.find("mqtt");
    const auto* const oversized = mqtt != nullptr ? mqtt->find("last_oversized") : nullptr;
    if (oversized != nullptr)
        text += texts("app.output.oversized", {{"count", scalar_text(member(*mqtt, "oversized"))},
                                               {"topic", scalar_text(member(*oversized, "topic"))},
                                               {"bytes", scalar_text(member(*oversized, "bytes"))}});
    const auto* const journal = output.find("journal");
    const auto torn = journal != nullptr ? scalar_text(member(*journal, "torn_bytes")) : std::string();
    if (!torn.empty() && torn != "0") text += texts("app.output.torn", {{"count", torn}});
    const auto waits =
        journal != nullptr ? time_member(*journal, "disk_waits_ms").value_or(Duration{}) : Duration{};
    if (waits > Duration{}) text += texts("app.output.disk_waits", {{"age", texts.duration(waits)}});
    if (const auto aside = journal != nullptr ? scalar_text(member(*journal, "set_aside")) : std::string();
        !aside.empty())
        text += texts("app.output.journal_set_aside", {{"file", aside}});
    const auto* const failure = journal != nullptr ? journal->find("failure") : nullptr;
    if (failure == nullptr || failure->is_null()) return text;
    // While the disk works, what is in memory is there for the time of a sync.
    if (const auto count = scalar_text(member(*journal, "buffer_samples")); !count.empty() && count != "0")
        text += texts("app.output.in_memory", {{"count", count}});
    return text +
           texts("app.output.journal", {{"failure", without_stop(scalar_text(member(*failure, "text")))}});
}

}  // namespace

std::string output_text(const Texts& texts, const publish::OutputStatus& status, std::int64_t wall_ns) {
    return output_line(texts, output_json(texts, status, wall_ns));
}

std::string outputs_text(const Texts& texts, const file::Json& object) {
    std::string text;
    const auto* const outputs = object.find("outputs");
    if (outputs == nullptr) return text;
    for (const auto& output : std::get<file::Json::Array>(outputs->value()))
        text += output_line(texts, output) + '\n';
    return text;
}

std::string outputs_text(const Texts& texts, std::span<const publish::OutputStatus> outputs,
                         std::int64_t wall_ns) {
    std::string text;
    for (const auto& status : outputs) text += output_text(texts, status, wall_ns) + '\n';
    return text;
}

file::Json output_json(const Texts& texts, const publish::OutputStatus& status, std::int64_t wall_ns) {
    auto object = file::Json::object();
    object.set("name", status.name);
    object.set("state", publish::name(status.state));
    object.set("destination", status.destination);
    object.set("sampled", status.samples.sampled);
    object.set("delivered", status.samples.delivered);
    object.set("waiting", status.samples.waiting);
    object.set("dropped", status.samples.dropped);
    object.set("lost", status.lost);
    object.set("gaps", status.gaps);
    object.set("oldest_waiting", status.oldest_waiting_ns
                                     ? file::Json(utc_time_text(*status.oldest_waiting_ns))
                                     : file::Json());
    object.set("oldest_waiting_ms", status.oldest_waiting_ns
                                        ? file::Json(milliseconds(waiting_since(status, wall_ns)))
                                        : file::Json());
    object.set("failure", status.failure.empty() ? file::Json() : file::Json(status.failure));
    object.set("falls_behind", behind_json(texts, status));
    object.set("commands", status.commands);
    object.set("commands_refused", status.commands_refused);
    object.set("answers_dropped", status.answers_dropped);
    object.set("commands_unrecorded", status.commands_unrecorded);
    object.set("too_large", status.too_large);
    object.set("damaged", status.damaged);
    object.set("set_aside", status.set_aside.empty() ? file::Json() : file::Json(status.set_aside));
    object.set("journal", journal_json(texts, status));
    if (status.mqtt) object.set("mqtt", mqtt_json(*status.mqtt));
    return object;
}

void add_outputs(const Texts& texts, file::Json& status, std::span<const publish::OutputStatus> outputs,
                 std::int64_t wall_ns) {
    const auto in_trouble = [](const publish::OutputStatus& output) {
        using enum publish::OutputState;
        return output.journal_failure || output.disk_waits > Duration{} || output.lost > 0 ||
               output.commands_unrecorded > 0 || output.state == stopped || output.state == removed;
    };
    file::Json::Array problems;
    for (const auto& output : outputs) {
        Problem problem{.kind = Problem::Kind::output, .output = output.name};
        problem.severity = in_trouble(output) ? Problem::Severity::error : Problem::Severity::warning;
        const bool is_behind = output.behind_per_s > 0;
        if (!is_behind && !in_trouble(output)) continue;
        problem.text = output_text(texts, output, wall_ns);
        if (is_behind) {
            problem.tried = texts("problem.tried.journal");
            problem.advice = behind_advice(texts, output);
        }
        problems.push_back(problem_json(problem));
    }
    if (!problems.empty() && string_member(status, "health") == "ok") status.set("health", "degraded");
    const auto& others = array_member(status, "problems");
    problems.insert(problems.end(), others.begin(), others.end());
    status.set("problems", file::Json(std::move(problems)));
    status.set("outputs", outputs_json(texts, outputs, wall_ns));
}

file::Json outputs_json(const Texts& texts, std::span<const publish::OutputStatus> outputs,
                        std::int64_t wall_ns) {
    auto array = file::Json::array();
    for (const auto& status : outputs) array.push_back(output_json(texts, status, wall_ns));
    return array;
}

}  // namespace takt::report
