#include "options/option_error.hpp"

#include <optional>
#include <vector>

namespace takt::app {
namespace {

/// Matches `text` against a pattern whose `*` stand for its variable parts.
std::optional<std::vector<std::string>> parts(std::string_view text, std::string_view pattern) {
    std::vector<std::string> found;
    while (!pattern.empty()) {
        const auto star = pattern.find('*');
        const auto fixed = pattern.substr(0, star);
        if (!text.starts_with(fixed)) return std::nullopt;
        text.remove_prefix(fixed.size());
        if (star == std::string_view::npos) break;
        pattern.remove_prefix(star + 1);
        const auto next = pattern.substr(0, pattern.find('*'));
        const auto end = next.empty() ? text.size() : text.find(next);
        if (end == std::string_view::npos) return std::nullopt;
        found.emplace_back(text.substr(0, end));
        text.remove_prefix(end);
    }
    if (!text.empty()) return std::nullopt;
    return found;
}

bool is_number(const std::string& text) {
    const auto digits = text.find_first_not_of('-');
    return digits != std::string::npos && text.find_first_not_of("0123456789.", digits) == std::string::npos;
}

struct Form {
    std::string_view pattern;
    std::string_view code;
    std::vector<std::string_view> names;  // of the variable parts
};

// What CLI11 2.1 says, and what main.cpp throws in the same manner. The first that fits counts.
const std::vector<Form>& forms() {
    static const std::vector<Form> kForms{
        {"A subcommand is required", "app.option.no_command", {}},
        {"* is required", "app.option.required", {"option"}},
        {"The following argument was not expected: *", "app.option.extra", {"value"}},
        {"The following arguments were not expected: *", "app.option.extra", {"value"}},
        {"Could not convert: * = *", "app.option.unreadable", {"option", "value"}},
        {"*: Value * not in range * to *", "app.option.range", {"option", "value", "least", "greatest"}},
        {"*: * not in {*}", "app.option.word", {"option", "value", "allowed"}},
        {"*: '*' is not known, allowed: *", "app.option.word", {"option", "value", "allowed"}},
        {"*: '*' is not of the form *", "app.option.form", {"option", "value", "form"}},
        {"*: '*' is no duration: *", "app.option.duration", {"option", "value", "form"}},
        {"*: the least is *", "app.option.least", {"option", "least"}},
        {"*: * required * missing", "app.option.no_value", {"option", "count", "kind"}},
        {"*: At least * required but received *", "app.option.no_value", {"option", "count", "received"}},
        {"* excludes *", "app.option.excludes", {"option", "other"}},
        {"* requires *", "app.option.requires", {"option", "other"}},
    };
    return kForms;
}

}  // namespace

std::string option_error(const Texts& texts, std::string_view what) {
    for (const auto& form : forms()) {
        const auto found = parts(what, form.pattern);
        if (!found) continue;
        Texts::Arguments arguments;
        for (std::size_t i = 0; i < found->size() && i < form.names.size(); ++i)
            arguments.emplace_back(form.names[i], (*found)[i]);
        const bool no_number = form.code == "app.option.range" && !is_number(found->at(1));
        return texts(no_number ? "app.option.number" : form.code, arguments);
    }
    return std::string(what);
}

}  // namespace takt::app
