#include "states/problems.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <tuple>
#include <utility>

#include "takt/bus/release.hpp"
#include "takt/file/json_members.hpp"
#include "takt/host/event_message.hpp"
#include "takt/report/drawing/formatting.hpp"
#include "takt/report/states/event_report.hpp"
#include "takt/report/states/state_report.hpp"
#include "takt/text/catalogue.hpp"
#include "takt/text/escape.hpp"

namespace takt::report {
namespace {

using enum Problem::Kind;
using enum Problem::Severity;
using poll::DeviceState;
using value::Quality;
using value::Reason;

// A few responses of many may be lost or damaged on any line.
constexpr std::uint64_t kFewestFailures = 3;
constexpr std::uint64_t kFewestInRequests = 100;  // one in so many

bool is_not_good(const value::Slot& slot) {
    return slot.quality == Quality::bad || slot.quality == Quality::uncertain;
}

/// "Level, Speed and 3 more"
std::string names_text(const Texts& texts, const std::vector<std::string>& names) {
    constexpr std::size_t kMost = 4;
    std::string text;
    for (std::size_t i = 0; i < std::min(names.size(), kMost); ++i) text += (i == 0 ? "" : ", ") + names[i];
    if (names.size() > kMost)
        text += texts("problem.more_names", {{"count", std::to_string(names.size() - kMost)}});
    return text;
}

class ProblemFinder {
public:
    ProblemFinder(const Texts& texts, const host::Snapshot& snapshot)
        : texts_(texts),
          snapshot_(snapshot),
          configuration_(*snapshot.configuration),
          named_(snapshot.values.size()) {}

    std::vector<Problem> find() {
        for (line_ = 0; line_ < snapshot_.lines.size(); ++line_) {
            find_link();
            for (device_ = 0; device_ < line().devices.size(); ++device_) find_device();
        }
        find_values_without_device();
        const auto key = [](const Problem& p) { return std::tuple(p.severity, p.kind); };
        std::ranges::stable_sort(found_, {}, key);
        return std::move(found_);
    }

private:
    [[nodiscard]] const host::Snapshot::Line& line() const { return snapshot_.lines[line_]; }
    [[nodiscard]] const model::Line& line_settings() const { return configuration_.project().lines[line_]; }
    [[nodiscard]] const poll::DeviceStatistics& device() const { return line().devices[device_]; }
    [[nodiscard]] const model::Device& settings() const { return line_settings().devices[device_]; }
    [[nodiscard]] value::SlotId slot_of(std::size_t variable) const {
        return configuration_.slots().variable({line_, device_, variable});
    }
    [[nodiscard]] std::optional<Duration> before_snapshot(const std::optional<Instant>& t) const {
        return t ? std::optional(std::max(snapshot_.t - *t, Duration{})) : std::nullopt;
    }

    void find_link() {
        if (line().up || !line().why) return;
        found_.push_back({.severity = error,
                          .kind = link,
                          .line = line_settings().name,
                          .since = before_snapshot(line().statistics.availability.down_since()),
                          .text = line_settings().name + ": " + text::what(texts_.language(), *line().why),
                          .tried = texts_("problem.tried.link"),
                          .advice = text::advice(texts_.language(), *line().why)});
    }

    void find_device() {
        name_values_of_links();
        find_refused();
        if (fails_often(device())) {
            if (!refused_by_gateway()) found_.push_back(failing_often());
        } else if (device().state == DeviceState::not_answering) {
            found_.push_back(answers_late(device()) ? too_late() : unanswering());
            name_values([](Reason) { return true; });
        } else {
            find_late();
        }
        find_values();
        find_failures();
        find_measured();
    }

    [[nodiscard]] Problem of_device(Problem::Severity severity, Problem::Kind kind) const {
        return {.severity = severity, .kind = kind, .line = line_settings().name, .device = settings().name};
    }

    // ---- values

    /// Values that a problem has named are not listed again. @returns the names of those not named before
    template <class Matches>
    std::vector<std::string> name_values(const Matches& matches) {
        std::vector<std::size_t> all(settings().variables.size());
        for (std::size_t v = 0; v < all.size(); ++v) all[v] = v;
        return name_values(all, matches);
    }
    template <class Matches>
    std::vector<std::string> name_values(const std::vector<std::size_t>& variables, const Matches& matches) {
        std::vector<std::string> names;
        for (const auto v : variables) {
            const auto slot = slot_of(v).value;
            if (named_[slot] || !is_not_good(snapshot_.values[slot]) ||
                !matches(snapshot_.values[slot].reason))
                continue;
            named_[slot] = true;
            names.push_back(settings().variables[v].name);
        }
        return names;
    }

    /// A link that is down is a problem of the line; a device that is switched off is none.
    void name_values_of_links() {
        if (device().state == DeviceState::link_down || device().state == DeviceState::switched_off)
            name_values([](Reason) { return true; });
    }

    /// Since the oldest last good value of these; else since the start.
    [[nodiscard]] Duration since_good(const std::vector<std::size_t>& variables) const {
        Duration longest{};
        for (const auto v : variables) {
            const auto& slot = snapshot_.values[slot_of(v).value];
            if (is_not_good(slot))
                longest = std::max(longest, snapshot_.t - slot.good_at.value_or(snapshot_.started));
        }
        return longest;
    }

    /// Values that are not good though the device answers, by reason.
    void find_values() {
        std::map<Reason, std::vector<std::size_t>> by_reason;
        for (std::size_t v = 0; v < settings().variables.size(); ++v) {
            const auto slot = slot_of(v).value;
            if (is_not_good(snapshot_.values[slot]) && !named_[slot])
                by_reason[snapshot_.values[slot].reason].push_back(v);
        }
        for (const auto& [reason, variables] : by_reason) {
            auto problem = failing(reason);
            problem.severity = warning;
            problem.since = since_good(variables);
            problem.variables = name_values(variables, [](Reason) { return true; });
            found_.push_back(std::move(problem));
        }
    }

    void find_values_without_device() {
        for (std::uint32_t id = 0; id < snapshot_.values.size(); ++id) {
            const auto& slot = snapshot_.values[id];
            if (named_[id] || !is_not_good(slot) || configuration_.device_of({id})) continue;
            const auto& name = configuration_.info({id}).name;
            found_.push_back({.kind = values,
                              .variables = {name},
                              .since = before_snapshot(slot.good_at.value_or(snapshot_.started)),
                              .text = name + ": " + texts_.quality(slot.quality, slot.reason)});
        }
    }

    // ---- devices

    /// The failures of one kind.
    struct Failures {
        Problem::Kind kind;
        std::uint64_t count;
        std::string text;
        std::string advice;
    };
    [[nodiscard]] Failures failures_of(Reason reason) const {
        const auto& counters = device().counters;
        const auto of_kind = [&](Problem::Kind kind, std::uint64_t count, std::string_view text) {
            return Failures{kind, count, texts_(text, {{"device", settings().name}}),
                            advice_on(code_of(reason))};
        };
        switch (reason) {
            case Reason::bad_checksum:
                if (2 * device().cut_short > counters.checksums)
                    return misfit(damaged, counters.checksums, *device().last_cut_short);
                return of_kind(damaged, counters.checksums, "problem.damaged");
            case Reason::unexpected_reply:
            case Reason::ambiguous:
                if (const auto others = counters.unexpected + counters.ambiguous; device().foreign > others)
                    return misfit(unfitting, others + device().foreign, *device().last_foreign);
                return of_kind(unfitting, counters.unexpected + counters.ambiguous, "problem.unfitting");
            case Reason::link_lost:
            case Reason::closed: return of_kind(unanswered, counters.link_lost, "problem.closed");
            default: return of_kind(unanswered, counters.timeouts - device().foreign, "problem.unanswered");
        }
    }

    [[nodiscard]] static Code code_of(Reason reason) {
        switch (reason) {
            case Reason::bad_checksum: return Code::bad_checksum;
            case Reason::unexpected_reply:
            case Reason::ambiguous: return Code::unexpected_reply;
            case Reason::link_lost:
            case Reason::closed: return Code::closed_by_peer;
            default: return Code::timed_out;
        }
    }

    /// Other responses came than those to the requests, or parts of them.
    /// @param mismatch  of the last one
    [[nodiscard]] Failures misfit(Problem::Kind kind, std::uint64_t count, const Mismatch& mismatch) const {
        const auto error = misdirected(settings().name, mismatch);
        return {kind, count, text::what(texts_.language(), error),
                mismatch.part == Mismatch::Part::unit ? advice_on_unit(mismatch.came)
                                                      : text::advice(texts_.language(), error)};
    }

    [[nodiscard]] std::string advice_on_unit(std::int64_t came) const {
        const auto& devices = line_settings().devices;
        const auto owner =
            std::ranges::find(devices, came, [](const auto& its) { return its.address.value; });
        const auto unit = std::to_string(came);
        if (owner == devices.end()) return texts_("problem.advice.misdirected.unit", {{"other", unit}});
        return texts_("problem.advice.misdirected.taken",
                      {{"other", unit}, {"owner", owner->name}, {"device", settings().name}});
    }

    [[nodiscard]] std::string advice_on(Code code) const {
        Error failure{code, std::string_view(settings().name), {}};
        const bool serial_over_tcp = line_settings().transport == model::Transport::tcp &&
                                     line_settings().framing != wire::Framing::tcp;
        if (serial_over_tcp) failure.subject = "rtu+tcp://";
        return text::advice(texts_.language(), failure);
    }

    [[nodiscard]] Problem counted(const Failures& failures) const {
        Problem problem = of_device(note, failures.kind);
        problem.count = failures.count;
        problem.of = device().counters.sent;
        problem.text = failures.text;
        problem.advice = failures.advice;
        return problem;
    }

    [[nodiscard]] Problem failing_often() {
        Failures most = failures_of(Reason::timeout);
        for (const auto reason : {Reason::bad_checksum, Reason::unexpected_reply, Reason::closed})
            if (auto failures = failures_of(reason); failures.count > most.count) most = std::move(failures);
        const bool may_be_late =
            most.kind == unanswered || (most.kind == unfitting && has_other_id(device()));
        Problem problem = may_be_late && mostly_late(device()) ? too_late() : counted(most);
        problem.severity = warning;
        problem.since = before_snapshot(device().share.since());
        problem.variables = name_values([](Reason reason) { return !value::is_exception(reason); });
        return problem;
    }

    /// Of values with that reason.
    [[nodiscard]] Problem failing(Reason reason) const {
        constexpr std::array kFailures{Reason::bad_checksum, Reason::unexpected_reply, Reason::ambiguous,
                                       Reason::timeout,      Reason::link_lost,        Reason::closed};
        const bool is_failure = std::ranges::find(kFailures, reason) != kFailures.end();
        if (is_failure) return counted(failures_of(reason));
        Problem problem = of_device(warning, values);
        const bool stale = reason == Reason::stale;
        problem.text =
            settings().name + ": " + texts_.quality(stale ? Quality::uncertain : Quality::bad, reason);
        if (stale) problem.advice = texts_("problem.advice.stale");
        return problem;
    }

    /// The last failure of a device that does not answer.
    [[nodiscard]] Error failure_of(Reason reason, Code code) const {
        const std::string_view name = settings().name;
        if (value::is_exception(reason)) {
            const auto number = value::status_code(reason);
            return {Code::modbus_exception, name, {number >= 256 ? number - 256 : number}};
        }
        if (code != Code::timed_out) return {code, name, {}};
        const auto wait = settings().wait(configuration_.project().derive_timeouts);
        return {code, name, {wait / std::chrono::milliseconds(1)}};
    }

    /// The device does not answer, or no response can be used.
    [[nodiscard]] Problem unanswering() const {
        const auto reason = device().failure;
        const auto failures = failures_of(reason);
        Problem problem = counted(failures);
        if (failures.kind == unanswered) {
            problem.kind = silent;
            const auto failure = failure_of(reason, code_of(reason));
            if (failure.code == Code::modbus_exception) problem.count = device().counters.exceptions;
            problem.text = text::what(texts_.language(), failure);
            problem.advice = text::advice(texts_.language(), failure);
        }
        problem.severity = error;
        problem.since = before_snapshot(device().availability.down_since());
        problem.tried = tried();
        return problem;
    }

    [[nodiscard]] std::string tried() const {
        const auto back_off = settings().backoff.value_or(configuration_.project().backoff);
        return texts_("problem.tried.probe", {{"attempts", std::to_string(settings().attempts)},
                                              {"pause", texts_.duration(device().back_off)},
                                              {"limit", texts_.duration(back_off.limit)}});
    }

    [[nodiscard]] Problem slower(Problem::Severity severity) const {
        Problem problem = of_device(severity, slow);
        problem.text = event_text(
            texts_, configuration_,
            {.body = host::DelaysFound{.line = line_, .device = device_, .finding = *device().delays}});
        return problem;
    }

    /// The device answers, but never in time.
    [[nodiscard]] Problem too_late() const {
        Problem problem = slower(error);
        problem.count = device().late;
        problem.of = device().counters.sent;
        problem.since = before_snapshot(device().availability.down_since());
        if (device().state == DeviceState::not_answering) problem.tried = tried();
        return problem;
    }

    /// Of the device.
    [[nodiscard]] bool is_listed(Problem::Kind kind) const {
        return std::ranges::any_of(found_, [&](const Problem& problem) {
            return problem.kind == kind && problem.device == settings().name &&
                   problem.line == line_settings().name;
        });
    }

    /// Failures that left no value bad.
    void find_failures() {
        if (device().state == DeviceState::not_answering && !fails_often(device())) return;
        const auto& sent = device().counters.sent;
        for (const auto reason : {Reason::bad_checksum, Reason::unexpected_reply, Reason::timeout}) {
            const auto failures = failures_of(reason);
            const bool late = is_listed(slow) && (reason == Reason::timeout || has_other_id(device()));
            if (late || is_listed(failures.kind) || !is_frequent(failures.count, sent)) continue;
            found_.push_back(counted(failures));
        }
        // A device that is slow over TCP answers requests that the engine has forgotten: they look repeated.
        const bool tcp = line_settings().framing == wire::Framing::tcp;
        if (!device().shifted && !(tcp && device().delays) && is_frequent(device().surplus, sent)) {
            Problem problem = of_device(note, repeated);
            problem.count = device().surplus;
            problem.of = sent;
            problem.text = texts_("problem.repeated", {{"device", settings().name}});
            problem.advice = texts_("problem.advice.repeated");
            found_.push_back(std::move(problem));
        }
        if (!device().shifted) return;
        Problem problem = of_device(warning, shifted);
        problem.count = device().surplus;
        problem.text = event_text(texts_, configuration_,
                                  {.body = host::SurplusFound{.line = line_, .device = device_}});
        found_.push_back(std::move(problem));
    }

    void find_measured() {
        if (device().delays && !is_listed(slow)) found_.push_back(slower(note));
        if (const auto& finding = device().noise) {
            Problem problem = of_device(note, noise);
            problem.text =
                event_text(texts_, configuration_,
                           {.body = host::NoiseFound{.line = line_, .device = device_, .finding = *finding}});
            found_.push_back(std::move(problem));
        }
    }

    // ---- requests

    [[nodiscard]] const plan::LinePlan* plan() const { return line().plan.get(); }

    template <class Visit>
    void for_each_request(const Visit& visit) {
        if (!plan()) return;
        for (std::size_t r = 0; r < plan()->requests.size() && r < line().requests.size(); ++r)
            if (plan()->requests[r].device == device_) visit(plan()->requests[r], line().requests[r]);
    }

    /// Requests that are refused often, but not always, are one problem of the device.
    void find_refused() {
        std::vector<std::string> requests;
        std::vector<std::size_t> variables;
        bus::TransactionCounters sum;
        for_each_request([&](const plan::Request& request, const poll::RequestStatistics& statistics) {
            const auto& counters = statistics.counters;
            if (counters.exceptions == 0) return;
            const auto code = host::most_frequent_exception(counters);
            if (fails_with(code)) return;  // the problem of the device
            if (refuses_often() && counters.answered > 0 &&
                counters.exceptions * kFewestInRequests >= counters.sent) {
                requests.push_back(request_text(request));
                variables.insert(variables.end(), request.variables.begin(), request.variables.end());
                for (std::size_t i = 0; i < counters.exceptions_by_code.size(); ++i)
                    sum.exceptions_by_code[i] += counters.exceptions_by_code[i];
                return;
            }
            Problem problem = refusal(request_text(request), code);
            problem.variables = name_values(request.variables, &value::is_exception);
            if (!problem.variables.empty()) {
                problem.severity = warning;
                problem.since = since_good(request.variables);
            }
            problem.count = counters.exceptions;
            problem.of = counters.sent;
            found_.push_back(std::move(problem));
        });
        if (requests.empty()) return;
        const auto& share = device().refusals;
        const auto exception = host::most_frequent_exception(sum);
        Problem problem = refusal(names_text(texts_, requests), exception);
        problem.severity = warning;
        problem.variables = name_values(
            variables, [&](Reason reason) { return value::is_exception(reason) || refused_by_gateway(); });
        problem.since = before_snapshot(share.since());
        problem.count = share.failed();
        problem.of = share.transactions();
        // These say that the device cannot do it at all, but it has done it.
        constexpr auto kLastOfTheRequest = static_cast<std::uint8_t>(wire::ExceptionCode::illegal_data_value);
        if (exception >= 1 && exception <= kLastOfTheRequest) problem.advice.clear();
        problem.advice += (problem.advice.empty() ? "" : " ") + texts_("problem.advice.refused_often");
        found_.push_back(std::move(problem));
    }

    [[nodiscard]] Problem refusal(std::string requests, std::uint8_t exception) const {
        const Error failure{Code::modbus_exception, {}, {exception}};
        Problem problem = of_device(note, refused);
        problem.text = texts_("problem.refused", {{"device", settings().name},
                                                  {"request", requests},
                                                  {"what", text::what(texts_.language(), failure)}});
        problem.request = std::move(requests);
        problem.advice = text::advice(texts_.language(), failure);
        return problem;
    }

    [[nodiscard]] bool refuses_often() const {
        return device().refusals.state() == poll::FailureShare::State::failing;
    }

    /// Most of what makes the device fail often are the exceptions of a gateway, which find_refused() lists.
    [[nodiscard]] bool refused_by_gateway() const {
        const auto& counters = device().counters;
        const std::uint64_t exceptions =
            std::uint64_t{counters.exceptions_by_code[10]} + counters.exceptions_by_code[11];
        return fails_often(device()) && refuses_often() &&
               exceptions > counters.timeouts + counters.checksums + counters.unexpected;
    }

    [[nodiscard]] bool fails_with(std::uint8_t exception) const {
        return device().state == DeviceState::not_answering && !fails_often(device()) &&
               value::is_exception(device().failure) &&
               value::status_code(device().failure) % 256 == exception;
    }

    [[nodiscard]] static bool is_frequent(std::uint64_t failures, std::uint64_t sent) {
        return failures >= kFewestFailures && failures * kFewestInRequests >= sent;
    }

    /// What delays a request: the device is busy, the line waits for responses that do not come in time, or
    /// there is more to send than the line takes.
    [[nodiscard]] std::string advice_on_late(const bus::TransactionCounters& counters) const {
        const std::uint64_t busy =
            std::uint64_t{counters.exceptions_by_code[5]} + counters.exceptions_by_code[6];
        if (is_frequent(busy, counters.sent))
            return texts_("problem.advice.late.busy", {{"device", settings().name}});
        for (const auto& [missed, text] :
             {std::pair{&bus::TransactionCounters::timeouts, "problem.advice.late.waiting"},
              {&bus::TransactionCounters::link_lost, "problem.advice.late.connecting"}}) {
            const auto worst = std::ranges::max_element(
                line().devices, {}, [&](const auto& its) { return its.counters.*missed; });
            if (!is_frequent(worst->counters.*missed, worst->counters.sent)) continue;
            const auto index = static_cast<std::size_t>(worst - line().devices.begin());
            return texts_(text, {{"device", line_settings().devices[index].name}});
        }
        return texts_(line_settings().is_serial() ? "problem.advice.late" : "problem.advice.late.network");
    }

    void find_late() {
        for_each_request([&](const plan::Request& request, const poll::RequestStatistics& statistics) {
            if (!statistics.overrun || !line().up || statistics.recent_period == Duration{}) return;
            const auto planned = statistics.period.value_or(Duration{});
            const auto real = host::milliseconds_number(statistics.recent_period);
            const auto period = host::milliseconds_number(planned);
            if (statistics.recent_period <= bus::tolerated_period(planned)) return;  // as it is shown
            Problem problem = of_device(warning, late);
            problem.request = request_text(request);
            if (statistics.skipped > 0) problem.count = statistics.skipped;
            problem.text = texts_("app.overrun", {{"where", settings().name},
                                                  {"request", problem.request},
                                                  {"real", real},
                                                  {"period", period}});
            problem.advice = advice_on_late(statistics.counters);
            found_.push_back(std::move(problem));
        });
    }

    const Texts& texts_;
    const host::Snapshot& snapshot_;
    const host::Configuration& configuration_;
    std::vector<bool> named_;  // by slot: a problem names it
    std::vector<Problem> found_;
    std::size_t line_ = 0;
    std::size_t device_ = 0;
};

}  // namespace

DeviceTrouble device_trouble(const Texts& texts, const host::Snapshot& snapshot, std::size_t line,
                             std::size_t device) {
    const auto& settings = snapshot.configuration->project().lines[line];
    for (const auto& problem : find_problems(texts, snapshot))
        if (problem.severity == error && problem.line == settings.name &&
            problem.device == settings.devices[device].name)
            return {problem.text, problem.tried};
    return {};
}

std::vector<Problem> find_problems(const Texts& texts, const host::Snapshot& snapshot) {
    return ProblemFinder(texts, snapshot).find();
}

std::string_view health_word(const host::Snapshot& snapshot, const std::vector<Problem>& problems) {
    std::size_t answering = 0;
    std::size_t silent_devices = 0;
    for (const auto& line : snapshot.lines)
        for (const auto& device : line.devices) {
            const bool often = fails_often(device);
            answering += often || device.state == DeviceState::answering ? 1U : 0U;
            silent_devices += !often && (device.state == DeviceState::not_answering ||
                                         device.state == DeviceState::link_down)
                                  ? 1U
                                  : 0U;
        }
    if (silent_devices > 0 && answering == 0) return "failed";
    const bool trouble =
        std::ranges::any_of(problems, [](const Problem& problem) { return problem.severity != note; });
    return trouble ? "degraded" : "ok";
}

std::string problem_line(const Texts& texts, const file::Json& problem) {
    auto text = texts("app." + string_member(problem, "severity")) + ": " + string_member(problem, "text");
    const auto count = number_member(problem, "count");
    const auto of = number_member(problem, "of");
    if (count && of)
        text += texts("problem.count_of", {{"count", count_member(problem, "count")},
                                           {"of", count_member(problem, "of")},
                                           {"percent", percent_text(*of > 0 ? *count / *of : 0)}});
    if (const auto since = time_member(problem, "since_ms"))
        text += texts("problem.since", {{"age", texts.duration(*since)}});
    std::vector<std::string> names;
    for (const auto& name : array_member(problem, "variables"))
        names.push_back(std::get<std::string>(name.value()));
    if (!names.empty()) text += ": " + names_text(texts, names);
    return text::escape_line(text);
}

std::string problems_text(const Texts& texts, const file::Json& problems, std::size_t most) {
    const auto* const list = std::get_if<file::Json::Array>(&problems.value());
    if (list == nullptr) return {};
    std::string text;
    for (std::size_t i = 0; i < std::min(list->size(), most); ++i) {
        text += "  " + problem_line(texts, (*list)[i]) + '\n';
        for (const auto* const key : {"tried", "advice"})
            if (const auto more = string_member((*list)[i], key); !more.empty())
                text += "    " + text::escape_line(more) + '\n';
    }
    if (list->size() > most)
        text += "  " + texts("problem.more", {{"count", std::to_string(list->size() - most)}}) + '\n';
    return text;
}

}  // namespace takt::report
