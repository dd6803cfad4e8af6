#include "takt/plan/guarantee_findings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <tuple>
#include <utility>

#include "takt/plan/shares.hpp"

namespace takt::plan {
namespace {

using model::Finding;
using model::Severity;
using Time = std::optional<Duration>;

constexpr std::size_t kMostErrors = 10;
constexpr std::size_t kMostWarnings = 3;
constexpr std::size_t kMostNames = 3;

constexpr std::array<std::string_view, 13> kCodes{
    "guarantee.late",
    "guarantee.unbounded",
    "guarantee.overload",
    "guarantee.overload_grouped",
    "guarantee.late_with_fault",
    "guarantee.late_with_dead",
    "guarantee.response_unknown",
    "guarantee.response_not_learnt",
    "guarantee.unlimited",
    "guarantee.rough",
    "guarantee.more",
    "guarantee.response_measured",
    "guarantee.response_learning",
};

/// The late variables of one request, or of requests that take turns. The figures are those of the first one.
struct Late {
    std::size_t device = 0;
    std::size_t stream = 0;
    std::vector<std::size_t> variables;
    Time response;  // nothing: unbounded
    Duration deadline{};
    // Lateness is a failure of what the project demands, not only of what can be proved.
    bool demanded = false;

    [[nodiscard]] Duration over() const { return response ? *response - deadline : Duration::max(); }
};

/// The first one by demand, then by lateness.
bool is_worse(const Late& a, const Late& b) {
    const auto key = [](const Late& late) {
        return std::tuple(!late.demanded, -late.over().count(), late.device, late.variables.front(),
                          late.stream);
    };
    return key(a) < key(b);
}

/// The time that a variable allows: its own deadline, or else that of its cause.
Duration allowed(const model::Variable& variable, const JobBound& job) {
    if (variable.deadline) return *variable.deadline;
    if (job.cause == Cause::period && variable.period > Duration::zero()) return variable.period;
    return *job.bound.deadline;
}

std::string percent(double share) {
    return fmt::format("{:.1f} %", share * 100);
}

std::vector<std::size_t> devices_without_turnaround(const model::Line& line) {
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < line.devices.size(); ++i)
        if (!line.devices[i].expected_turnaround() && !line.is_broadcast(line.devices[i])) found.push_back(i);
    return found;
}

std::vector<std::size_t> measured_devices(const model::Line& line) {
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < line.devices.size(); ++i)
        if (line.devices[i].measured_exchanges() > 0) found.push_back(i);
    return found;
}

/// "A, B, C, … (7)"
std::string device_names(const model::Line& line, const std::vector<std::size_t>& devices) {
    std::string names;
    for (std::size_t i = 0; i < std::min(devices.size(), kMostNames); ++i)
        names += (i == 0 ? "" : ", ") + line.devices[devices[i]].name;
    if (devices.size() > kMostNames) names += fmt::format(", … ({})", devices.size());
    return names;
}

class LineVerdict {
public:
    LineVerdict(const model::Project& project, const LinePlan& plan, const LineGuarantee& guarantee,
                bool prove, std::vector<Finding>& findings)
        : project_(project),
          line_(project.lines[plan.line]),
          plan_(plan),
          guarantee_(guarantee),
          prove_(prove),
          unknown_(devices_without_turnaround(line_)),
          measured_(measured_devices(line_)),
          findings_(findings) {}

    void judge();
    [[nodiscard]] Verdict verdict() const;

private:
    [[nodiscard]] std::vector<Late> late(Time Bound::* response) const;
    [[nodiscard]] std::vector<Late> late_variables(Time Bound::* response) const;
    void add(const Late& late, const char* code, Severity severity);
    void add_all(const std::vector<Late>& late, const char* code, Severity severity);
    void judge_unproved(const std::vector<Late>& late);
    void judge_failures();
    void add_overload();
    void add_response_unknown();
    void add_response_measured();
    void add_unlimited();
    [[nodiscard]] Finding line_finding(const char* code, Severity severity) const;

    [[nodiscard]] Verdict unproved() const {
        return turnarounds_known() ? Verdict::not_proved : Verdict::response_unknown;
    }
    [[nodiscard]] bool turnarounds_known() const { return unknown_.empty() && measured_.empty(); }

    const model::Project& project_;
    const model::Line& line_;
    const LinePlan& plan_;
    const LineGuarantee& guarantee_;
    bool prove_;
    std::vector<std::size_t> unknown_;   ///< devices of the line
    std::vector<std::size_t> measured_;  ///< likewise
    std::vector<Finding>& findings_;
};

Verdict LineVerdict::verdict() const {
    if (plan_.utilization > 1) return Verdict::cannot_hold;
    if (guarantee_.feasible) return Verdict::holds;
    const bool demanded = std::ranges::any_of(late(&Bound::response), &Late::demanded);
    return demanded ? Verdict::cannot_hold : unproved();
}

// Where polling alone overloads the line, that one finding is the cause of all others.
void LineVerdict::judge() {
    if (plan_.utilization > 1) add_overload();
    const auto all = late(&Bound::response);
    const auto others = std::ranges::find(all, false, &Late::demanded);
    add_all({all.begin(), others}, "guarantee.late", Severity::error);
    if (!all.empty() && plan_.utilization <= 1) judge_unproved({others, all.end()});
    if (all.empty()) judge_failures();
    if (!measured_.empty()) add_response_measured();
    if (guarantee_.unlimited > 0) add_unlimited();
    if (!guarantee_.exact) findings_.push_back(line_finding("guarantee.rough", Severity::warning));
}

// `late` has the values without a deadline of their own. A late value with one has the same cause to name.
void LineVerdict::judge_unproved(const std::vector<Late>& late) {
    if (!unknown_.empty())
        add_response_unknown();
    else if (measured_.empty())
        add_all(late, "guarantee.late", Severity::warning);
    else
        add_all(late, "guarantee.late", Severity::note);
}

void LineVerdict::judge_failures() {
    const auto with_faults = project_.faults_set ? late(&Bound::response_with_fault) : std::vector<Late>();
    if (!turnarounds_known() && !prove_) {
        if (!with_faults.empty() && !unknown_.empty()) add_response_unknown();
        return;
    }
    add_all(with_faults, "guarantee.late_with_fault", Severity::warning);
    add_all(late(&Bound::response_with_dead), "guarantee.late_with_dead", Severity::warning);
}

std::vector<Late> LineVerdict::late_variables(Time Bound::* response) const {
    std::vector<Late> found;
    for (const JobBound& job : guarantee_.jobs) {
        const Time& longest = job.bound.*response;
        if (!job.limited || !job.bound.deadline || (longest && *longest <= *job.bound.deadline)) continue;
        const Request& request = plan_.requests[job.request];
        for (const std::size_t v : request.variables) {
            const model::Variable& variable = line_.devices[request.device].variables[v];
            const Duration deadline = allowed(variable, job);
            if (longest && *longest <= deadline) continue;
            found.push_back({.device = request.device,
                             .stream = request.stream,
                             .variables = {v},
                             .response = longest,
                             .deadline = deadline,
                             .demanded = prove_ || variable.deadline});
        }
    }
    return found;
}

// A variable counts once, with the response that exceeds its limit most, and so does a request.
std::vector<Late> LineVerdict::late(Time Bound::* response) const {
    auto found = late_variables(response);
    std::sort(found.begin(), found.end(), is_worse);
    std::vector<Late> requests;
    std::map<std::pair<std::size_t, std::size_t>, std::size_t> known;  // device and stream
    std::vector<std::vector<bool>> seen;
    for (const auto& device : line_.devices) seen.emplace_back(device.variables.size(), false);
    for (Late& one : found) {
        const std::size_t variable = one.variables.front();
        if (seen[one.device][variable]) continue;
        seen[one.device][variable] = true;
        const auto [entry, is_new] = known.try_emplace({one.device, one.stream}, requests.size());
        if (is_new)
            requests.push_back(std::move(one));
        else
            requests[entry->second].variables.push_back(variable);
    }
    return requests;
}

void LineVerdict::add(const Late& late, const char* code, Severity severity) {
    const model::Device& device = line_.devices[late.device];
    Finding finding;
    finding.severity = severity;
    const bool unbounded = !late.response && std::string_view(code) == "guarantee.late";
    finding.code = unbounded ? "guarantee.unbounded" : code;
    finding.location = device.variables[late.variables.front()].location;
    finding.path =
        fmt::format("lines[{}].devices[{}].variables[{}]", plan_.line, late.device, late.variables.front());
    finding.value = late.response ? time_text(*late.response) : "∞";
    finding.allowed = time_text(late.deadline);
    finding.arguments = {{"variable", names_text(device, late.variables)},
                         {"device", device.name},
                         {"response", finding.value},
                         {"deadline", finding.allowed},
                         {"over", late.response ? time_text(late.over()) : "∞"}};
    findings_.push_back(std::move(finding));
}

void LineVerdict::add_all(const std::vector<Late>& late, const char* code, Severity severity) {
    const std::size_t most = severity == Severity::error ? kMostErrors : kMostWarnings;
    const std::size_t reported = late.size() > most ? most - 1 : late.size();
    for (std::size_t i = 0; i < reported; ++i) add(late[i], code, severity);
    if (reported == late.size()) return;
    Finding more = line_finding("guarantee.more", severity);
    more.arguments.emplace_back("count", std::to_string(late.size() - reported));
    findings_.push_back(std::move(more));
}

Finding LineVerdict::line_finding(const char* code, Severity severity) const {
    Finding finding;
    finding.severity = severity;
    finding.code = code;
    finding.location = line_.location;
    finding.path = fmt::format("lines[{}]", plan_.line);
    finding.arguments = {{"line", line_.name}};
    return finding;
}

// The source of owen-kc1 defines what its master does with too short a period: it polls without pause.
void LineVerdict::add_overload() {
    const bool tolerated = project_.profile == model::Profile::owen_kc1 && !prove_;
    const bool grouped = std::ranges::all_of(line_.devices, &model::Device::group_requests);
    Finding finding = line_finding(grouped ? "guarantee.overload_grouped" : "guarantee.overload",
                                   tolerated ? Severity::warning : Severity::error);
    finding.value = percent(plan_.utilization);
    finding.allowed = "100 %";
    const StreamShare largest = largest_shares(plan_, 1).front();
    const model::Device& device = line_.devices[largest.device];
    finding.arguments.insert(finding.arguments.end(), {{"utilization", finding.value},
                                                       {"variable", names_text(device, largest.variables)},
                                                       {"device", device.name},
                                                       {"share", percent(largest.share)}});
    findings_.push_back(std::move(finding));
}

void LineVerdict::add_response_unknown() {
    const bool learning = std::ranges::all_of(
        unknown_, [&](std::size_t device) { return line_.devices[device].learn_turnaround; });
    const bool learns = project_.profile != model::Profile::owen_kc1;
    const auto* const code = learning ? "guarantee.response_learning"
                             : learns ? "guarantee.response_unknown"
                                      : "guarantee.response_not_learnt";
    Finding finding = line_finding(code, prove_ ? Severity::error : Severity::note);
    finding.arguments.emplace_back("devices", device_names(line_, unknown_));
    finding.arguments.emplace_back("utilization", percent(busy(plan_)));
    findings_.push_back(std::move(finding));
}

// A measured maximum is no bound: the figures hold as long as no response takes longer.
void LineVerdict::add_response_measured() {
    std::uint64_t least = UINT64_MAX;
    Duration longest{};
    for (const std::size_t d : measured_) {
        least = std::min(least, line_.devices[d].measured_exchanges());
        longest = std::max(longest, *line_.devices[d].expected_turnaround(requests_in_flight(line_)));
    }
    Finding finding = line_finding("guarantee.response_measured", Severity::note);
    finding.value = time_text(longest);
    finding.arguments.emplace_back("devices", device_names(line_, measured_));
    finding.arguments.emplace_back("count", std::to_string(least));
    finding.arguments.emplace_back("one_in", std::to_string(least / 3));
    finding.arguments.emplace_back("longest", finding.value);
    findings_.push_back(std::move(finding));
}

// What has no limit of its own passes the rate limit of the line: it delays, but it cannot stop the polling.
void LineVerdict::add_unlimited() {
    Finding finding = line_finding("guarantee.unlimited", Severity::note);
    finding.value = std::to_string(guarantee_.unlimited);
    finding.arguments.emplace_back("count", finding.value);
    findings_.push_back(std::move(finding));
}

}  // namespace

std::vector<Finding> guarantee_findings(const model::Project& project, const Plan& plan,
                                        std::span<const LineGuarantee> guarantees, bool prove) {
    std::vector<Finding> findings;
    for (std::size_t i = 0; i < plan.lines.size(); ++i)
        LineVerdict(project, plan.lines[i], guarantees[i], prove, findings).judge();
    return findings;
}

std::string_view name(Verdict verdict) {
    constexpr std::array<std::string_view, 4> kNames{"holds", "response_unknown", "not_proved",
                                                     "cannot_hold"};
    return kNames[static_cast<std::size_t>(verdict)];
}

Verdict verdict(const model::Project& project, const LinePlan& plan, const LineGuarantee& guarantee) {
    std::vector<Finding> none;
    return LineVerdict(project, plan, guarantee, false, none).verdict();
}

std::string unknown_turnarounds(const model::Line& line) {
    return device_names(line, devices_without_turnaround(line));
}

std::span<const std::string_view> guarantee_finding_codes() {
    return kCodes;
}

std::string names_text(const model::Device& device, std::span<const std::size_t> variables) {
    constexpr std::size_t kMost = 4;
    std::string names;
    for (std::size_t i = 0; i < variables.size(); ++i) {
        if (i == kMost - 1 && variables.size() > kMost) {
            const auto& last = device.variables[variables.back()].name;
            return fmt::format("{}, … {} ({})", names, last, variables.size());
        }
        names += (i == 0 ? "" : ", ") + device.variables[variables[i]].name;
    }
    return names;
}

std::string time_text(Duration time) {
    const auto us = std::chrono::ceil<std::chrono::microseconds>(time).count();
    return fmt::format("{} ms", static_cast<double>(us) / 1000);
}

}  // namespace takt::plan
