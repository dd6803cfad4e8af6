// Documents and findings as one line of text, for comparison.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "takt/file/load.hpp"
#include "takt/model/findings.hpp"
#include "takt/text/catalogue.hpp"

namespace takt::file {

inline std::string at(const model::SourceLocation& location) {
    const auto position = std::to_string(location.line) + ":" + std::to_string(location.column);
    return location.file == 0 ? position : std::to_string(location.file) + "/" + position;
}

/// `{name@1:1: "x"@1:7, b@2:1: [1@2:5, null@2:8]@2:4}@1:1`
inline std::string outline(const model::Node& node) {
    using Kind = model::Node::Kind;
    std::string text;
    switch (node.kind) {
        case Kind::null: text = "null"; break;
        case Kind::scalar: text = node.quoted ? '"' + node.text + '"' : node.text; break;
        case Kind::list:
            for (const auto& item : node.items) text += (text.empty() ? "" : ", ") + outline(item);
            text = '[' + text + ']';
            break;
        case Kind::mapping:
            for (const auto& [key, value] : node.entries)
                text += (text.empty() ? "" : ", ") + outline(key) + ": " + outline(value);
            text = '{' + text + '}';
            break;
    }
    return text + "@" + at(node.location);
}

/// `2:1 duplicate_key`, the leading "file." left out. Also checks that every finding has its text in all
/// languages.
inline std::vector<std::string> locations_and_codes(const Loaded& loaded) {
    std::vector<std::string> lines;
    for (const auto& finding : loaded.findings) {
        EXPECT_LT(finding.location.file, loaded.document.files.size());
        EXPECT_TRUE(finding.code.starts_with("file.")) << finding.code;
        std::vector<text::Argument> arguments{
            {"value", finding.value}, {"allowed", finding.allowed}, {"path", finding.path}};
        for (const auto& [name, value] : finding.arguments) arguments.push_back({name, value});
        for (const auto language : text::kLanguages) {
            EXPECT_TRUE(text::has(language, finding.code)) << finding.code;
            for (auto template_text = text::pattern(language, finding.code); const auto& argument : arguments)
                EXPECT_FALSE(argument.text.empty() &&
                             template_text.contains("{" + std::string(argument.name) + "}"))
                    << finding.code << " lacks its " << argument.name;
            std::vector<text::Argument> blank = arguments;
            for (auto& argument : blank) argument.text = "-";
            EXPECT_EQ(text::message(language, finding.code, blank).find('{'), std::string::npos)
                << text::message(language, finding.code, blank);
        }
        lines.push_back(at(finding.location) + " " + finding.code.substr(5));
    }
    return lines;
}

/// The errors of a document and of the project in it: `file.csv.unknown_column Kind`.
inline std::vector<std::string> errors_of(const Loaded& loaded) {
    std::vector<std::string> errors;
    for (const auto& finding : loaded.findings)
        if (finding.severity == model::Severity::error) errors.push_back(finding.code + " " + finding.value);
    for (const auto& finding : model::interpret(loaded.document).findings)
        if (finding.severity == model::Severity::error)
            errors.push_back(finding.code + " " + finding.path + " " + finding.value);
    return errors;
}

}  // namespace takt::file
