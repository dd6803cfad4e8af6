#include "takt/report/guarantee_report.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "takt/plan/guarantee_findings.hpp"
#include "takt/report/formatting.hpp"

namespace takt::report {
namespace {

constexpr std::size_t kMostChanges = 12;  // of a measure, as text

file::Json time_json(const std::optional<Duration>& time) {
    return time ? file::Json(whole_microseconds(*time)) : file::Json();
}

std::string time_or_none(const Texts& texts, const std::optional<Duration>& time) {
    return time ? plan::time_text(*time) : texts("app.unbounded");
}

std::string title(const Texts& texts, const plan::Measure& measure) {
    std::string text;
    for (const auto kind : measure.kinds)
        text += (text.empty() ? "" : " + ") + texts("app.measure." + std::string(plan::name(kind)));
    if (measure.goal == plan::Goal::with_faults) text += " (" + texts("app.goal.with_faults") + ")";
    if (measure.goal == plan::Goal::with_dead_device) text += " (" + texts("app.goal.with_dead_device") + ")";
    return text;
}

std::string measure_text(const Texts& texts, const plan::Measure& measure) {
    const auto figures =
        texts("app.plan.measure", {{"variable", measure.variable},
                                   {"before", time_or_none(texts, measure.before)},
                                   {"after", time_or_none(texts, measure.after)},
                                   {"deadline", plan::time_text(measure.deadline)},
                                   {"utilization_before", percent_text(measure.utilization_before)},
                                   {"utilization_after", percent_text(measure.utilization_after)}});
    return fmt::format("  - {}\n      {}\n{}", title(texts, measure), figures,
                       changes_text(texts, measure.changes));
}

std::string_view name(plan::Goal goal) {
    if (goal == plan::Goal::with_faults) return "with_faults";
    return goal == plan::Goal::with_dead_device ? "with_dead_device" : "sound";
}

file::Json measure_json(const Texts& texts, const plan::Measure& measure) {
    auto kinds = file::Json::array();
    for (const auto kind : measure.kinds) kinds.push_back(plan::name(kind));
    auto object = file::Json::object();
    object.set("kinds", std::move(kinds));
    object.set("text", title(texts, measure));
    object.set("goal", name(measure.goal));
    object.set("only_plan", measure.only_plan());
    object.set("changes", changes_json(measure.changes));
    object.set("variable", measure.variable);
    object.set("response_before_us", time_json(measure.before));
    object.set("response_after_us", time_json(measure.after));
    object.set("deadline_us", time_json(measure.deadline));
    object.set("utilization_before", measure.utilization_before);
    object.set("utilization_after", measure.utilization_after);
    return object;
}

std::string_view change_code(const plan::Change& change) {
    if (change.path.empty()) return "app.change.project";
    return change.from.empty() ? "app.change.new" : "app.change";
}

}  // namespace

void set_bound(file::Json& request, const plan::Bound& bound) {
    request.set("c_us", whole_microseconds(bound.transaction));
    request.set("f_us", whole_microseconds(bound.failure));
    request.set("response_us", time_json(bound.response));
    request.set("response_fault_us", time_json(bound.response_with_fault));
    request.set("response_dead_us", time_json(bound.response_with_dead));
    request.set("deadline_us", time_json(bound.deadline));
    request.set("age_us", time_json(bound.age));
}

file::Json ages_json(const plan::LineGuarantee& guarantee, const plan::Request& request) {
    auto ages = file::Json::array();
    for (const std::size_t v : request.variables)
        ages.push_back(time_json(guarantee.ages[request.device][v]));
    return ages;
}

std::string bound_text(const plan::Bound& bound) {
    const auto cell = [](const std::optional<Duration>& time) {
        return time ? milliseconds_text(*time) : std::string("–");
    };
    return fmt::format("{} | {} | {} | {}", milliseconds_text(bound.transaction), cell(bound.response),
                       cell(bound.deadline), cell(bound.age));
}

std::string guarantee_text(const Texts& texts, const plan::LineGuarantee& line, plan::Verdict verdict) {
    return texts("app.plan.guarantee",
                 {{"utilization", percent_text(line.utilization)},
                  {"verdict", texts("app.verdict." + std::string(plan::name(verdict)))}});
}

std::string measures_text(const Texts& texts, const model::Project& project, const plan::Proof& proof) {
    std::string text;
    for (const auto& line : proof.lines) {
        std::string listed;
        for (const auto& measure : plan::measures_of(proof.measures.found, line.line))
            listed += measure_text(texts, measure);
        const auto& name = project.lines[line.line].name;
        if (!listed.empty())
            text += texts("app.plan.measures", {{"line", name}}) + '\n' + listed;
        else if (!line.feasible)
            text += texts("app.plan.no_measure", {{"line", name}}) + '\n';
        if (!line.feasible && std::ranges::binary_search(proof.measures.unfinished, line.line))
            text += texts("app.plan.search_limit", {{"line", name}}) + '\n';
    }
    return text;
}

file::Json measures_json(const Texts& texts, const std::vector<plan::Measure>& measures, std::size_t line) {
    auto list = file::Json::array();
    for (const auto& measure : plan::measures_of(measures, line))
        list.push_back(measure_json(texts, measure));
    return list;
}

std::string changes_text(const Texts& texts, const std::vector<plan::Change>& changes) {
    std::string text;
    for (std::size_t i = 0; i < changes.size(); ++i) {
        if (i == kMostChanges - 1 && changes.size() > kMostChanges) {
            text +=
                "      " + texts("app.change.more", {{"count", std::to_string(changes.size() - i)}}) + '\n';
            break;
        }
        const auto& change = changes[i];
        text += "      " +
                texts(change_code(change), {{"path", change.path},
                                            {"name", change.name},
                                            {"key", change.key},
                                            {"from", change.from},
                                            {"to", change.to}}) +
                '\n';
    }
    return text;
}

file::Json changes_json(const std::vector<plan::Change>& changes) {
    auto list = file::Json::array();
    for (const auto& change : changes) {
        auto object = file::Json::object();
        object.set("path", change.path);
        object.set("name", change.name);
        object.set("key", change.key);
        object.set("from", change.from);
        object.set("to", change.to);
        list.push_back(std::move(object));
    }
    return list;
}

}  // namespace takt::report
