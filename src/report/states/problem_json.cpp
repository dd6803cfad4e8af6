#include <array>
#include <string>

#include "states/problems.hpp"
#include "takt/report/drawing/formatting.hpp"

namespace takt::report {

std::string_view name(Problem::Severity severity) {
    constexpr std::array<std::string_view, 3> kNames{"error", "warning", "note"};
    return kNames[static_cast<std::size_t>(severity)];
}

std::string_view name(Problem::Kind kind) {
    using enum Problem::Kind;
    switch (kind) {
        case link: return "link";
        case silent: return "silent";
        case damaged: return "damaged";
        case unfitting: return "unfitting";
        case refused: return "refused";
        case output: return "output";
        case values: return "values";
        case shifted: return "shifted";
        case repeated: return "repeated";
        case unanswered: return "unanswered";
        case slow: return "slow";
        case noise: return "noise";
        case late: break;
    }
    return "late";
}

file::Json problem_json(const Problem& problem) {
    auto object = file::Json::object();
    object.set("severity", name(problem.severity));
    object.set("kind", name(problem.kind));
    const auto set = [&](std::string_view key, const std::string& text) {
        if (!text.empty()) object.set(key, text);
    };
    set("line", problem.line);
    set("device", problem.device);
    set("output", problem.output);
    set("request", problem.request);
    auto variables = file::Json::array();
    for (const auto& variable : problem.variables) variables.push_back(variable);
    object.set("variables", std::move(variables));
    if (problem.count) object.set("count", *problem.count);
    if (problem.of) object.set("of", *problem.of);
    if (problem.since) object.set("since_ms", milliseconds(*problem.since));
    set("text", problem.text);
    set("tried", problem.tried);
    set("advice", problem.advice);
    return object;
}

}  // namespace takt::report
