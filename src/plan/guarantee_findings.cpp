#include "takt/plan/guarantee_findings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <tuple>

namespace takt::plan {
namespace {

using model::Finding;
using model::Severity;
using Time = std::optional<Duration>;

constexpr std::size_t kMostErrors = 10;
constexpr std::size_t kMostWarnings = 3;
constexpr std::size_t kMostNames = 3;

constexpr std::array<std::string_view, 9> kCodes{
    "guarantee.late",           "guarantee.unbounded",
    "guarantee.overload",       "guarantee.late_with_fault",
    "guarantee.late_with_dead", "guarantee.response_unknown",
    "guarantee.unlimited",      "guarantee.rough",
    "guarantee.more",
};

/// A variable whose response is late, by the kind of response.
struct Late {
    std::size_t device = 0;
    std::size_t variable = 0;
    Time response;  // nothing: unbounded
    Duration deadline{};

    [[nodiscard]] Duration over() const { return response ? *response - deadline : Duration::max(); }
};

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
        if (!line.devices[i].turnaround) found.push_back(i);
    return found;
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
          findings_(findings) {}

    void judge();
    [[nodiscard]] Verdict verdict() const;

private:
    [[nodiscard]] std::vector<Late> late(Time Bound::* response) const;
    void add(const Late& late, const char* code, Severity severity);
    void add_all(const std::vector<Late>& late, const char* code, Severity severity);
    /// Whether lateness is a failure of what the project demands, not only of what can be proved.
    [[nodiscard]] bool is_demanded(const Late& late) const {
        return prove_ || line_.devices[late.device].variables[late.variable].deadline.has_value();
    }
    void judge_unproved(const std::vector<Late>& late);
    void judge_failures();
    void add_overload();
    void add_response_unknown();
    void add_unlimited();
    [[nodiscard]] Finding line_finding(const char* code, Severity severity) const;

    [[nodiscard]] Verdict unproved() const {
        return unknown_.empty() ? Verdict::not_proved : Verdict::response_unknown;
    }

    const model::Project& project_;
    const model::Line& line_;
    const LinePlan& plan_;
    const LineGuarantee& guarantee_;
    bool prove_;
    std::vector<std::size_t> unknown_;  ///< devices of the line
    std::vector<Finding>& findings_;
};

Verdict LineVerdict::verdict() const {
    if (plan_.utilization > 1) return Verdict::cannot_hold;
    if (guarantee_.feasible) return Verdict::holds;
    const auto all = late(&Bound::response);
    const bool demanded = std::ranges::any_of(all, [&](const Late& one) { return is_demanded(one); });
    return demanded ? Verdict::cannot_hold : unproved();
}

// Where polling alone overloads the line, that one finding is the cause of all others.
void LineVerdict::judge() {
    if (plan_.utilization > 1) add_overload();
    auto all = late(&Bound::response);
    const auto others =
        std::stable_partition(all.begin(), all.end(), [&](const Late& one) { return is_demanded(one); });
    add_all({all.begin(), others}, "guarantee.late", Severity::error);
    if (!all.empty() && plan_.utilization <= 1) judge_unproved({others, all.end()});
    if (all.empty()) judge_failures();
    if (guarantee_.unlimited > 0) add_unlimited();
    if (!guarantee_.exact) findings_.push_back(line_finding("guarantee.rough", Severity::warning));
}

// `late` has the values without a deadline of their own. A late value with one has the same cause to name.
void LineVerdict::judge_unproved(const std::vector<Late>& late) {
    if (unproved() == Verdict::response_unknown)
        add_response_unknown();
    else
        add_all(late, "guarantee.late", Severity::warning);
}

void LineVerdict::judge_failures() {
    const auto with_faults = project_.faults_set ? late(&Bound::response_with_fault) : std::vector<Late>();
    if (!unknown_.empty() && !prove_) {
        if (!with_faults.empty()) add_response_unknown();
        return;
    }
    add_all(with_faults, "guarantee.late_with_fault", Severity::warning);
    add_all(late(&Bound::response_with_dead), "guarantee.late_with_dead", Severity::warning);
}

// A variable counts once, with the response that exceeds its limit most.
std::vector<Late> LineVerdict::late(Time Bound::* response) const {
    std::vector<Late> found;
    for (const JobBound& job : guarantee_.jobs) {
        const Time& longest = job.bound.*response;
        if (!job.limited || !job.bound.deadline || (longest && *longest <= *job.bound.deadline)) continue;
        const Request& request = plan_.requests[job.request];
        for (const std::size_t v : request.variables) {
            const Duration deadline = allowed(line_.devices[request.device].variables[v], job);
            if (!longest || *longest > deadline) found.push_back({request.device, v, longest, deadline});
        }
    }
    std::sort(found.begin(), found.end(), [](const Late& a, const Late& b) {
        return std::tuple(-a.over().count(), a.device, a.variable) <
               std::tuple(-b.over().count(), b.device, b.variable);
    });
    std::vector<Late> once;
    std::vector<std::vector<bool>> seen;
    for (const auto& device : line_.devices) seen.emplace_back(device.variables.size(), false);
    for (const Late& one : found)
        if (!seen[one.device][one.variable]) {
            seen[one.device][one.variable] = true;
            once.push_back(one);
        }
    return once;
}

void LineVerdict::add(const Late& late, const char* code, Severity severity) {
    const model::Device& device = line_.devices[late.device];
    const model::Variable& variable = device.variables[late.variable];
    Finding finding;
    finding.severity = severity;
    const bool unbounded = !late.response && std::string_view(code) == "guarantee.late";
    finding.code = unbounded ? "guarantee.unbounded" : code;
    finding.location = variable.location;
    finding.path = fmt::format("lines[{}].devices[{}].variables[{}]", plan_.line, late.device, late.variable);
    finding.value = late.response ? time_text(*late.response) : "∞";
    finding.allowed = time_text(late.deadline);
    finding.arguments = {{"variable", variable.name},
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
    Finding finding = line_finding("guarantee.overload", tolerated ? Severity::warning : Severity::error);
    finding.value = percent(plan_.utilization);
    finding.allowed = "100 %";
    finding.arguments.emplace_back("utilization", finding.value);
    findings_.push_back(std::move(finding));
}

void LineVerdict::add_response_unknown() {
    Finding finding = line_finding("guarantee.response_unknown", prove_ ? Severity::error : Severity::note);
    std::string devices;
    for (std::size_t i = 0; i < std::min(unknown_.size(), kMostNames); ++i)
        devices += (i == 0 ? "" : ", ") + line_.devices[unknown_[i]].name;
    if (unknown_.size() > kMostNames) devices += fmt::format(", … ({})", unknown_.size());
    finding.arguments.emplace_back("devices", std::move(devices));
    finding.arguments.emplace_back("utilization", percent(plan_.utilization));
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

std::span<const std::string_view> guarantee_finding_codes() {
    return kCodes;
}

std::string time_text(Duration time) {
    const auto us = std::chrono::ceil<std::chrono::microseconds>(time).count();
    return fmt::format("{} ms", static_cast<double>(us) / 1000);
}

}  // namespace takt::plan
