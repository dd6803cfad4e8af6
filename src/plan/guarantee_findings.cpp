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

constexpr std::array<std::string_view, 8> kCodes{
    "guarantee.late",           "guarantee.unbounded", "guarantee.overload", "guarantee.late_with_fault",
    "guarantee.late_with_dead", "guarantee.unlimited", "guarantee.rough",    "guarantee.more"};

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

bool turnarounds_known(const model::Line& line) {
    return std::all_of(line.devices.begin(), line.devices.end(),
                       [](const model::Device& device) { return device.turnaround.has_value(); });
}

class LineVerdict {
public:
    LineVerdict(const model::Project& project, const LinePlan& plan, const LineGuarantee& guarantee,
                bool prove, std::vector<Finding>& findings)
        : project_(project),
          line_(project.lines[plan.line]),
          plan_(plan),
          guarantee_(guarantee),
          certain_(prove || turnarounds_known(line_)),
          findings_(findings) {}

    void judge();

private:
    [[nodiscard]] std::vector<Late> late(Time Bound::* response) const;
    void add(const Late& late, const char* code, bool may_be_error);
    void add_all(std::vector<Late> late, const char* code, bool may_be_error);
    [[nodiscard]] bool is_certain(const Late& late) const {
        return certain_ || line_.devices[late.device].variables[late.variable].deadline.has_value();
    }
    void add_overload();
    void add_unlimited();
    [[nodiscard]] Finding line_finding(const char* code, Severity severity) const;

    const model::Project& project_;
    const model::Line& line_;
    const LinePlan& plan_;
    const LineGuarantee& guarantee_;
    bool certain_;
    std::vector<Finding>& findings_;
};

void LineVerdict::judge() {
    if (guarantee_.utilization > 1) add_overload();
    const auto plain = late(&Bound::response);
    auto reported = plain;
    // An overload that rests on estimated turnarounds proves nothing about single values.
    if (guarantee_.utilization > 1)
        std::erase_if(reported, [&](const Late& one) { return !is_certain(one); });
    add_all(std::move(reported), "guarantee.late", true);
    if (plain.empty() && project_.faults_set)
        add_all(late(&Bound::response_with_fault), "guarantee.late_with_fault", false);
    if (plain.empty() && certain_)
        add_all(late(&Bound::response_with_dead), "guarantee.late_with_dead", false);
    if (guarantee_.unlimited > 0) add_unlimited();
    if (!guarantee_.exact) findings_.push_back(line_finding("guarantee.rough", Severity::warning));
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

void LineVerdict::add(const Late& late, const char* code, bool may_be_error) {
    const model::Device& device = line_.devices[late.device];
    const model::Variable& variable = device.variables[late.variable];
    Finding finding;
    finding.severity = may_be_error && is_certain(late) ? Severity::error : Severity::warning;
    finding.code = late.response || !may_be_error ? code : "guarantee.unbounded";
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

void LineVerdict::add_all(std::vector<Late> late, const char* code, bool may_be_error) {
    const auto is_error = [&](const Late& one) { return may_be_error && is_certain(one); };
    std::stable_partition(late.begin(), late.end(), is_error);
    const bool errors = !late.empty() && is_error(late.front());
    const std::size_t most = errors ? kMostErrors : kMostWarnings;
    const std::size_t reported = late.size() > most ? most - 1 : late.size();
    for (std::size_t i = 0; i < reported; ++i) add(late[i], code, may_be_error);
    if (reported == late.size()) return;
    Finding more = line_finding("guarantee.more", errors ? Severity::error : Severity::warning);
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

void LineVerdict::add_overload() {
    Finding finding = line_finding("guarantee.overload", certain_ ? Severity::error : Severity::warning);
    finding.value = fmt::format("{:.1f} %", guarantee_.utilization * 100);
    finding.allowed = "100 %";
    finding.arguments.emplace_back("utilization", finding.value);
    findings_.push_back(std::move(finding));
}

void LineVerdict::add_unlimited() {
    Finding finding = line_finding("guarantee.unlimited", Severity::warning);
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

std::span<const std::string_view> guarantee_finding_codes() {
    return kCodes;
}

std::string time_text(Duration time) {
    const auto us = std::chrono::ceil<std::chrono::microseconds>(time).count();
    return fmt::format("{} ms", static_cast<double>(us) / 1000);
}

}  // namespace takt::plan
