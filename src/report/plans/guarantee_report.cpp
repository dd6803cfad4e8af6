#include "takt/report/plans/guarantee_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <span>
#include <string_view>
#include <system_error>

#include "takt/plan/guarantee_findings.hpp"
#include "takt/report/drawing/formatting.hpp"

namespace takt::report {
namespace {

constexpr std::size_t kMostChanges = 12;  // of a measure, as text

file::Json time_json(const std::optional<Duration>& time) {
    return time ? file::Json(whole_microseconds(*time)) : file::Json();
}

std::string time_or_none(const Texts& texts, const std::optional<Duration>& time) {
    return time ? texts.exact(*time) : texts("app.unbounded");
}

std::string kind_text(const Texts& texts, const plan::Measure& measure, plan::MeasureKind kind) {
    if (kind == plan::MeasureKind::periods && measure.largest_share > 0)
        return texts("app.measure.largest_share", {{"share", percent_text(measure.largest_share)}});
    return texts("app.measure." + std::string(plan::name(kind)));
}

std::string measure_title(const Texts& texts, const plan::Measure& measure) {
    std::string text;
    for (const auto kind : measure.kinds)
        text += (text.empty() ? "" : " + ") + kind_text(texts, measure, kind);
    if (measure.goal == plan::Goal::with_faults) text += " (" + texts("app.goal.with_faults") + ")";
    if (measure.goal == plan::Goal::with_dead_device) text += " (" + texts("app.goal.with_dead_device") + ")";
    return text;
}

/// @param known  the turnarounds of the line: else the figures before rest on time-outs
std::string measure_text(const Texts& texts, const plan::Measure& measure, bool known) {
    const auto figures = texts(known ? "app.plan.measure" : "app.plan.measure.then",
                               {{"variable", measure.variable},
                                {"before", time_or_none(texts, measure.before)},
                                {"after", time_or_none(texts, measure.after)},
                                {"deadline", texts.exact(measure.deadline)},
                                {"utilization_before", percent_text(measure.utilization_before)},
                                {"utilization_after", percent_text(measure.utilization_after)}});
    return fmt::format("  - {}\n      {}\n{}", measure_title(texts, measure), figures,
                       changes_text(texts, measure.changes));
}

std::string_view goal_word(plan::Goal goal) {
    if (goal == plan::Goal::with_faults) return "with_faults";
    return goal == plan::Goal::with_dead_device ? "with_dead_device" : "sound";
}

file::Json measure_json(const Texts& texts, const plan::Measure& measure) {
    auto kinds = file::Json::array();
    for (const auto kind : measure.kinds) kinds.push_back(plan::name(kind));
    auto object = file::Json::object();
    object.set("kinds", std::move(kinds));
    object.set("text", measure_title(texts, measure));
    object.set("goal", goal_word(measure.goal));
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

/// A path of an entry of a list: "lines[0].devices[1]" is entry 1 of "lines[0].devices".
struct Entry {
    std::string_view list;
    std::size_t index = 0;
};

std::optional<Entry> entry_of(std::string_view path) {
    const auto bracket = path.rfind('[');
    if (bracket == std::string_view::npos || !path.ends_with(']')) return std::nullopt;
    Entry entry{.list = path.substr(0, bracket)};
    const auto* const end = path.data() + path.size() - 1;
    const auto read = std::from_chars(path.data() + bracket + 1, end, entry.index);
    return read.ec == std::errc() && read.ptr == end ? std::optional(entry) : std::nullopt;
}

/// The number of changes from the first one on that are the same change of entries side by side in a list.
std::size_t length_of_run(std::span<const plan::Change> changes) {
    const auto first = entry_of(changes.front().path);
    std::size_t count = 1;
    for (; first && count < changes.size(); ++count) {
        const auto& change = changes[count];
        const auto next = entry_of(change.path);
        const bool same = change.key == changes[0].key && change.from == changes[0].from &&
                          change.to == changes[0].to && next && next->list == first->list &&
                          next->index == first->index + count;
        if (!same) break;
    }
    return count;
}

/// @param run  of length_of_run()
std::string change_text(const Texts& texts, std::span<const plan::Change> run) {
    const auto& first = run.front();
    std::string path = first.path;
    std::string name = first.name;
    if (run.size() > 1) {
        path = fmt::format("{}[{}..{}]", entry_of(first.path)->list, entry_of(first.path)->index,
                           entry_of(run.back().path)->index);
        name = fmt::format("{} … {}", first.name, run.back().name);
    }
    return texts(
        change_code(first),
        {{"path", path}, {"name", name}, {"key", first.key}, {"from", first.from}, {"to", first.to}});
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

std::string guarantee_text(const Texts& texts, const plan::LineGuarantee& line, plan::Verdict verdict,
                           const std::string& unknown) {
    const auto words = texts("app.verdict." + std::string(plan::name(verdict)));
    if (unknown.empty() || verdict == plan::Verdict::holds)
        return texts("app.plan.guarantee",
                     {{"utilization", percent_text(line.utilization)}, {"verdict", words}});
    const auto needed = texts("app.plan.turnaround_needed", {{"devices", unknown}});
    return verdict == plan::Verdict::response_unknown ? needed : needed + "; " + words;
}

std::string measures_text(const Texts& texts, const model::Project& project, const plan::Proof& proof) {
    std::string text;
    for (const auto& line : proof.lines) {
        const bool known = plan::unknown_turnarounds(project.lines[line.line]).empty();
        std::string listed;
        for (const auto& measure : plan::measures_of(proof.measures.found, line.line))
            listed += measure_text(texts, measure, known);
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
    std::size_t shown = 0;
    for (std::size_t i = 0; i < changes.size(); ++shown) {
        if (shown == kMostChanges - 1 && changes.size() - i > 1) {
            const auto more = std::to_string(changes.size() - i);
            return text + "      " + texts("app.change.more", {{"count", more}}) + '\n';
        }
        const std::size_t count = length_of_run(std::span(changes).subspan(i));
        text += "      " + change_text(texts, std::span(changes).subspan(i, count)) + '\n';
        i += count;
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
