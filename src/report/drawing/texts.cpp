#include "takt/report/drawing/texts.hpp"

#include <algorithm>
#include <array>
#include <cerrno>

#include "takt/plan/guarantee_findings.hpp"
#include "takt/text/catalogue.hpp"
#include "takt/text/duration.hpp"

namespace takt::report {
namespace {

std::string filled_message(text::Language language, std::string_view code,
                           const Texts::Arguments& arguments) {
    std::vector<text::Argument> views;
    views.reserve(arguments.size());
    for (const auto& [name, value] : arguments) views.push_back({name, value});
    return text::message(language, code, views);
}

// Exact times of findings (plan::time_text()). Other arguments may be names and values of the user.
constexpr std::array<std::string_view, 4> kTimes{"response", "deadline", "over", "longest"};

Texts::Arguments finding_arguments(text::Language language, const model::Finding& finding) {
    Texts::Arguments arguments{
        {"value", finding.value}, {"allowed", finding.allowed}, {"path", finding.path}};
    const auto dot = finding.path.rfind('.');
    arguments.emplace_back("field", dot == std::string::npos ? finding.path : finding.path.substr(dot + 1));
    arguments.insert(arguments.begin(), finding.arguments.begin(), finding.arguments.end());
    for (auto& [name, value] : arguments)
        if (std::ranges::find(kTimes, name) != kTimes.end()) value = text::with_local_unit(language, value);
    return arguments;
}

// The code of the text for the finding's argument `variant`; without such a text `code`.
std::string variant_of(const model::Finding& finding, const std::string& code) {
    for (const auto& [name, text] : finding.arguments)
        if (const auto variant = code + '.' + text;
            name == "variant" && text::has(text::Language::english, variant))
            return variant;
    return code;
}

}  // namespace

std::string Texts::operator()(std::string_view code, const Arguments& arguments) const {
    return filled_message(language_, code, arguments);
}

std::string Texts::duration(Duration duration) const {
    return text::duration_text(language_, duration);
}

std::string Texts::bound(Duration bound) const {
    return duration(text::rounded_up(bound));
}

std::string Texts::exact(Duration duration) const {
    return text::with_local_unit(language_, plan::time_text(duration));
}

std::string Texts::message(const model::Finding& finding) const {
    return filled_message(language_, variant_of(finding, finding.code),
                          finding_arguments(language_, finding));
}

std::string Texts::advice(const model::Finding& finding) const {
    const std::string with_allowed = finding.code + ".advice_allowed";
    if (!finding.allowed.empty() && text::has(text::Language::english, with_allowed))
        return filled_message(language_, with_allowed, finding_arguments(language_, finding));
    const std::string code = variant_of(finding, finding.code + ".advice");
    if (!text::has(text::Language::english, code)) return {};
    auto arguments = finding_arguments(language_, finding);
    for (auto& [name, text] : arguments)
        if (name == "remedies") text = remedies(text, finding.arguments);
    return filled_message(language_, code, arguments);
}

std::string Texts::remedies(std::string_view words, const Arguments& arguments) const {
    std::string text;
    while (!words.empty()) {
        const auto end = std::min(words.find(','), words.size());
        text += (text.empty() ? "" : "; ") +
                (*this)("output.remedy." + std::string(words.substr(0, end)), arguments);
        words.remove_prefix(std::min(end + 1, words.size()));
    }
    return text;
}

std::string Texts::describe(const Error& error) const {
    return text::describe(language_, error);
}

std::string Texts::quality(value::Quality quality, value::Reason reason) const {
    std::string text = (*this)("app.quality." + std::string(value::name(quality)));
    if (reason == value::Reason::ok) return text;
    const auto code = value::status_code(reason);
    return text + ", " +
           (*this)("app.reason." + std::string(value::name(reason)),
                   {{"code", std::to_string(code >= 256 ? code - 256 : code)}});
}

std::string unwritten_text(const Texts& texts, const std::string& path, const Error& error) {
    const bool exists = error.code == Code::cannot_open && error.numbers[0] == EEXIST;
    return exists ? texts("app.convert.exists", {{"file", path}}) : texts.describe(error);
}

std::string without_stop(std::string sentence) {
    if (sentence.ends_with('.')) sentence.pop_back();
    return sentence;
}

}  // namespace takt::report
