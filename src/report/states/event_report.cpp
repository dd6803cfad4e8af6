#include "takt/report/states/event_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "takt/host/event_message.hpp"
#include "takt/poll/statistics.hpp"
#include "takt/report/drawing/formatting.hpp"
#include "takt/report/drawing/value_json.hpp"
#include "takt/report/states/command_report.hpp"
#include "takt/report/states/learnt_report.hpp"
#include "takt/report/states/state_report.hpp"
#include "takt/text/catalogue.hpp"
#include "takt/text/escape.hpp"

namespace takt::report {
namespace {

using host::Configuration;

const model::Device& device_of(const Configuration& configuration, const host::RequestKey& key) {
    return configuration.project().lines[key.line].devices[key.device];
}

std::string_view notice_severity_name(host::Notice::Severity severity) {
    switch (severity) {
        case host::Notice::Severity::status: return "status";
        case host::Notice::Severity::warning: return "warning";
        case host::Notice::Severity::error: break;
    }
    return "error";
}

void set_finding(file::Json& object, const poll::DelayFinding& finding) {
    object.set("setting", poll::name(finding.setting));
    object.set("delay_ms", milliseconds(finding.delay));
    object.set("limit_ms", milliseconds(finding.limit));
    const bool advised = finding.advised > Duration::zero();
    object.set("advised_ms", advised ? file::Json(milliseconds(finding.advised)) : file::Json());
    object.set("count", finding.count);
    object.set("later", finding.later);
}

void set_finding(file::Json& object, const poll::NoiseFinding& finding) {
    object.set("least_bytes", finding.least);
    object.set("most_bytes", finding.most);
}

template <class Finding>
file::Json json_of(const std::optional<Finding>& finding) {
    if (!finding) return {};
    auto object = file::Json::object();
    set_finding(object, *finding);
    return object;
}

/// The text of each kind of event.
class TextOf {
public:
    TextOf(const Texts& of, const Configuration& on) : texts_(of), configuration_(on) {}

    // A service variable changes each second or more often: a line for each change would bury the others.
    std::string operator()(const host::ValueChanged& changed) const {
        if (configuration_.info(changed.slot).service) return {};
        const std::string device = device_name(configuration_, changed.slot);
        const auto& name = configuration_.info(changed.slot).name;
        // Variables of a template have the name of their device already.
        std::string line = device.empty() || name.starts_with(device + '.') ? "" : device + ' ';
        line += name + " = " + value_text(configuration_, changed.slot, changed.value);
        if (changed.quality != value::Quality::good)
            line += " (" + texts_.quality(changed.quality, changed.reason) + ")";
        return line;
    }
    std::string operator()(const host::LinkChanged& changed) const {
        return texts_(changed.up             ? "app.link_up"
                      : changed.repeated > 0 ? "app.link_down.repeated"
                                             : "app.link_down",
                      {{"line", configuration_.project().lines[changed.line].name},
                       {"why", changed.why ? texts_.describe(*changed.why) : std::string()},
                       {"count", std::to_string(changed.repeated)},
                       {"age", texts_.duration(changed.in)}});
    }
    std::string operator()(const host::WriteFinished& finished) const {
        if (finished.outcome.result == value::CommandResult::done) return {};
        return filled(host::event_message(configuration_, finished.outcome));
    }
    std::string operator()(const host::Notice& notice) const { return notice_text(texts_, notice); }
    std::string operator()(const host::EventsLost& lost) const { return missed_text(texts_, lost.count); }
    std::string operator()(const host::ConfigurationChanged&) const { return texts_("app.applied"); }
    std::string operator()(const host::AuditRecorded&) const { return {}; }
    /// Any other one: the program and the log have the same message.
    template <class Body>
    std::string operator()(const Body& body) const {
        return filled(host::event_message(configuration_, body));
    }

private:
    const Texts& texts_;
    const Configuration& configuration_;

    [[nodiscard]] std::string filled(const host::EventMessage& message) const {
        if (message.code.empty()) return {};
        Texts::Arguments known;
        for (const auto& argument : message.arguments) {
            const bool unknown =
                !argument.otherwise.empty() && !text::has(text::Language::english, argument.text);
            const auto& code = unknown ? argument.otherwise : argument.text;
            if (argument.name == "device") known.emplace_back("where", argument.text);
            known.emplace_back(argument.name, argument.is_code ? texts_(code, known) : argument.text);
        }
        return texts_(message.code, known);
    }
};

/// The members of each kind of event after `event` and `time_ms`.
class JsonOf {
public:
    JsonOf(const Texts& texts, const Configuration& configuration, Instant started, Instant t)
        : texts_(texts), configuration_(configuration), time_ms_(milliseconds(t - started)), t_(t) {}

    file::Json operator()(const host::ValueChanged& changed) const {
        const auto& info = configuration_.info(changed.slot);
        auto object = begin("value");
        set_owner(object, changed.slot);
        object.set("name", info.name);
        object.set("value", to_json(info.type, info.scaled, changed.value));
        if (auto words = configuration_.value_words(changed.slot, changed.value); !words.empty())
            object.set("words", std::move(words));
        if (const auto utc = utc_text(info, changed.value); !utc.empty()) object.set("utc", utc);
        object.set("quality", value::name(changed.quality));
        object.set("reason", reason_word(changed.reason));
        object.set("age_ms", changed.sampled_at
                                 ? file::Json(milliseconds(std::max(Duration{}, t_ - *changed.sampled_at)))
                                 : file::Json());
        return object;
    }
    file::Json operator()(const host::DeviceStateChanged& changed) const {
        using Shown = host::DeviceStateChanged::Shown;
        if (changed.shown == Shown::counted) return {};
        auto object = begin("device", changed.line, changed.device);
        object.set("state", poll::name(changed.state));
        if (changed.state == poll::DeviceState::not_answering && changed.failure != value::Reason::ok)
            object.set("cause", reason_word(changed.failure));
        if (changed.shown == Shown::each) return object;
        object.set("changes_often", changed.shown == Shown::often);
        object.set("changes", changed.changes);
        object.set("in_ms", milliseconds(changed.in));
        object.set("text", TextOf(texts_, configuration_)(changed));
        return object;
    }
    file::Json operator()(const host::LinkChanged& changed) const {
        auto object = begin("link");
        object.set("line", configuration_.project().lines[changed.line].name);
        object.set("up", changed.up);
        if (changed.why) object.set("text", texts_.describe(*changed.why));
        if (changed.repeated == 0) return object;
        object.set("repeated", changed.repeated);
        object.set("in_ms", milliseconds(changed.in));
        return object;
    }
    file::Json operator()(const host::PeriodOverrun& overrun) const {
        auto object = begin("overrun", overrun.request);
        object.set("period_ms", milliseconds(overrun.period));
        object.set("real_period_ms", milliseconds(overrun.real));
        object.set("overrun", overrun.overrun);
        return object;
    }
    file::Json operator()(const host::DelaysFound& found) const {
        auto object = begin("delays", found.line, found.device);
        set_finding(object, found.finding);
        object.set("text", TextOf(texts_, configuration_)(found));
        return object;
    }
    file::Json operator()(const host::NoiseFound& found) const {
        auto object = begin("noise", found.line, found.device);
        set_finding(object, found.finding);
        object.set("text", TextOf(texts_, configuration_)(found));
        return object;
    }
    file::Json operator()(const host::SurplusFound& found) const {
        auto object = begin("surplus", found.line, found.device);
        object.set("text", TextOf(texts_, configuration_)(found));
        return object;
    }
    file::Json operator()(const host::WriteWaiting& waiting) const {
        auto object = begin("write_waiting", waiting.request);
        object.set("name", device_of(configuration_, waiting.request).variables[waiting.variable].name);
        return object;
    }
    file::Json operator()(const host::VerifyFailed& failed) const {
        const auto& info = configuration_.info(failed.slot);
        auto object = begin("verify_failed");
        set_owner(object, failed.slot);
        object.set("name", info.name);
        object.set("written", to_json(info.type, info.scaled, failed.written));
        object.set("read", to_json(info.type, info.scaled, failed.read_back));
        return object;
    }
    file::Json operator()(const host::GapLearnt& learnt) const {
        const auto& gap_event = learnt.gap_event;
        auto object = begin("learnt", learnt.line, gap_event.device);
        object.set("function", static_cast<int>(gap_event.read));
        object.set("first", gap_event.items.first);
        object.set("last", gap_event.items.last);
        object.set("result", poll::name(gap_event.kind));
        object.set("exception", gap_event.exception > 0 ? file::Json(gap_event.exception) : file::Json());
        return object;
    }
    file::Json operator()(const host::WriteFinished& finished) const {
        if (finished.outcome.result == value::CommandResult::done) return {};
        auto object = outcome_json(texts_, configuration_, finished.outcome);
        object.set("time_ms", time_ms_);
        return object;
    }
    file::Json operator()(const host::Notice& notice) const {
        auto object = begin("notice");
        object.set("severity", notice_severity_name(notice.severity));
        object.set("code", notice.code);
        object.set("text", notice_text(texts_, notice));
        return object;
    }
    file::Json operator()(const host::EventsLost& lost) const { return missed_json(lost.count); }
    file::Json operator()(const host::ConfigurationChanged& changed) const {
        auto object = begin("applied");
        object.set("generation", changed.generation);
        return object;
    }
    file::Json operator()(const host::AuditRecorded&) const { return {}; }

private:
    [[nodiscard]] file::Json begin(const char* event) const {
        auto object = file::Json::object();
        object.set("event", event);
        object.set("time_ms", time_ms_);
        return object;
    }
    [[nodiscard]] file::Json begin(const char* event, std::size_t line, std::size_t device) const {
        const auto& settings = configuration_.project().lines[line];
        auto object = begin(event);
        object.set("line", settings.name);
        object.set("device", settings.devices[device].name);
        return object;
    }
    [[nodiscard]] file::Json begin(const char* event, const host::RequestKey& key) const {
        auto object = begin(event, key.line, key.device);
        object.set("function", static_cast<int>(key.read ? *key.read : *key.write));
        object.set("start", key.start);
        return object;
    }
    void set_owner(file::Json& object, value::SlotId slot) const {
        const auto* const line = configuration_.line_of(slot);
        object.set("line", line ? line->name : std::string());
        object.set("device", device_name(configuration_, slot));
    }

    const Texts& texts_;
    const Configuration& configuration_;
    double time_ms_;
    Instant t_;
};

}  // namespace

std::string event_text(const Texts& texts, const Configuration& configuration, const host::Event& event) {
    return text::escape_line(std::visit(TextOf(texts, configuration), event.body));
}

file::Json event_json(const Texts& texts, const Configuration& configuration, Instant started,
                      const host::Event& event) {
    return std::visit(JsonOf(texts, configuration, started, event.t), event.body);
}

file::Json finding_json(const std::optional<poll::DelayFinding>& finding) {
    return json_of(finding);
}

file::Json finding_json(const std::optional<poll::NoiseFinding>& finding) {
    return json_of(finding);
}

std::string missed_text(const Texts& texts, std::uint64_t count) {
    return texts("app.missed", {{"count", std::to_string(count)}});
}

file::Json missed_json(std::uint64_t count) {
    auto object = file::Json::object();
    object.set("event", "gap");
    object.set("missed", count);
    return object;
}

// A state file of another program is one of the reasons why the file cannot be used.
std::string notice_text(const Texts& texts, const host::Notice& notice) {
    auto arguments = notice.arguments;
    if (notice.code == "host.retain.foreign")
        return texts("host.retain.unavailable", {{"error", texts(notice.code, arguments)}});
    const bool continues = notice.code.starts_with("host.");
    if (notice.error) {
        auto error = texts.describe(*notice.error);
        arguments.emplace_back("error", continues ? without_stop(std::move(error)) : std::move(error));
    }
    return texts(notice.code, arguments);
}

std::string value_text(const Configuration& configuration, value::SlotId slot, const value::Value& value) {
    return configuration.value_text(slot, value);
}

std::string device_name(const Configuration& configuration, value::SlotId slot) {
    const auto* const device = configuration.device_of(slot);
    return device ? device->name : std::string();
}

}  // namespace takt::report
