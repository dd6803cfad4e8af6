#include "options/option_error.hpp"

#include <algorithm>
#include <optional>
#include <vector>

#include "takt/model/fields.hpp"
#include "takt/model/synonyms.hpp"
#include "takt/model/target_url.hpp"

namespace takt::app {
namespace {

/// Matches `text` against a pattern whose `*` stand for its variable parts.
std::optional<std::vector<std::string>> matched_parts(std::string_view text, std::string_view pattern) {
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

struct Form {
    std::string_view pattern;
    std::string_view code;
    std::vector<std::string_view> names;  // of the variable parts
};

// The words of CLI11 2.1. The first pattern that fits counts.
const std::vector<Form>& forms() {
    static const std::vector<Form> kForms{
        {"A subcommand is required", "app.option.no_command", {}},
        {"* is required", "app.option.required", {"option"}},
        {"Could not convert: * = *", "app.option.unreadable", {"option", "value"}},
        {"*: * required * missing", "app.option.no_value", {"option"}},
        {"*: At least * required but received *", "app.option.no_value", {"option"}},
        {"* excludes *", "app.option.excludes", {"option", "other"}},
        {"* requires *", "app.option.requires", {"option", "other"}},
    };
    return kForms;
}

}  // namespace

OptionError option_error(std::string_view words) {
    for (const auto& form : forms()) {
        const auto found = matched_parts(words, form.pattern);
        if (!found) continue;
        OptionError error{std::string(form.code), {}};
        for (std::size_t i = 0; i < found->size() && i < form.names.size(); ++i)
            error.arguments.emplace_back(form.names[i], (*found)[i]);
        return error;
    }
    return {"app.option.other", {{"words", std::string(words)}}};
}

OptionError word_error(std::string_view option, std::string_view value, std::string_view allowed) {
    std::vector<std::string_view> words;
    for (auto rest = allowed; !rest.empty();) {
        const auto comma = std::min(rest.find(", "), rest.size());
        words.push_back(rest.substr(0, comma));
        rest.remove_prefix(std::min(comma + 2, rest.size()));
    }
    const auto key = option.substr(std::min(option.find_first_not_of('-'), option.size()));
    const auto nearest = model::meant_word(key, words, value);
    OptionError error{
        nearest.empty() ? "app.option.word" : "app.option.word.nearest",
        {{"option", std::string(option)}, {"value", std::string(value)}, {"allowed", std::string(allowed)}}};
    if (!nearest.empty()) error.arguments.emplace_back("nearest", nearest);
    return error;
}

OptionError unknown_option(const std::string& name, std::span<const std::string_view> options) {
    const auto word_of = [](std::string_view option) {
        return option.substr(std::min(option.find_first_not_of('-'), option.size()));
    };
    std::vector<std::string_view> words;
    for (const auto option : options) words.push_back(word_of(option));
    const auto has = [&](std::string_view word) { return std::ranges::find(words, word) != words.end(); };
    const auto nearest_is = [&](std::string_view word) {
        const auto option = options[static_cast<std::size_t>(std::ranges::find(words, word) - words.begin())];
        const bool argument = !option.starts_with('-');
        return OptionError{argument ? "app.option.unknown.argument" : "app.option.unknown",
                           {{"value", name}, {"nearest", std::string(option)}}};
    };
    std::string key(word_of(name));
    std::ranges::replace(key, '-', '_');
    const auto key_in = [&](model::Object object) {
        const auto* const field = model::find_field(object, key);
        return field != nullptr ? field->key : model::synonym(object, key);
    };
    // Options that `serve` had before its blank device was a unit of a project.
    if (has("fill"))
        for (const auto object : {model::Object::unit, model::Object::bank})
            if (const auto meant = key_in(object); !meant.empty() && meant != "address")
                return {"app.option.unknown.key",
                        {{"value", name},
                         {"key", std::string(model::location(object)).append(".").append(meant)}}};
    if (key == "address" && has("unit") && has("START"))
        return {"app.option.unknown.address", {{"value", name}}};
    if (const auto meant = model::value_synonym("option", words, key); !meant.empty())
        return nearest_is(meant);
    for (const auto object : model::kObjects) {
        const auto meant = key_in(object);
        if (meant.empty()) continue;
        if (has(meant)) return nearest_is(meant);
        if (const auto option = model::value_synonym("option", words, meant); !option.empty())
            return nearest_is(option);
    }
    const auto of_line = key_in(model::Object::line);
    const bool serial = std::ranges::find(model::kPortKeys, of_line) != model::kPortKeys.end();
    if (serial || of_line == "host" || of_line == "tcp_port" || of_line == "port")
        for (const auto* const target : {"TARGET", "TARGETS", "SOURCE", "PORT", "--target", "--port"})
            if (std::ranges::find(options, target) != options.end())
                return {"app.option.unknown.target",
                        {{"value", name},
                         {"option", target},
                         {"example", serial ? "rtu:///dev/ttyUSB0?baud=19200&parity=even&stop_bits=1"
                                            : "tcp://host:502"}}};
    if (const auto near = model::meant_word("option", words, word_of(name)); !near.empty())
        return nearest_is(near);
    const bool known = std::ranges::any_of(
        model::kObjects, [&](model::Object object) { return model::find_field(object, key) != nullptr; });
    if (known) return {"app.option.unknown.key", {{"value", name}, {"key", key}}};
    return {"app.option.unknown.unlike", {{"value", name}}};
}

OptionError target_error(std::string_view option, std::string_view url, const Error& why) {
    return {"app.option.target", {{"option", std::string(option)}, {"value", std::string(url)}}, why};
}

std::string option_error_text(const Texts& texts, const OptionError& error) {
    auto arguments = error.arguments;
    if (error.why) arguments.emplace_back("why", texts.describe(*error.why));
    return texts(error.code, arguments);
}

}  // namespace takt::app
