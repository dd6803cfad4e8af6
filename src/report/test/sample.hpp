// Fixtures of the report tests: small projects, all languages, and the properties of every report.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <string>
#include <variant>
#include <vector>

#include "takt/file/json.hpp"
#include "takt/file/load.hpp"
#include "takt/model/project.hpp"
#include "takt/report/drawing/texts.hpp"

/// Compares JSON by its text, so that a failure shows it and 7 equals 7U.
#define EXPECT_JSON(actual, expected) EXPECT_EQ((actual).dump(), takt::file::Json(expected).dump())

namespace takt::report::test {

inline constexpr std::array kLanguages{text::Language::english, text::Language::russian,
                                       text::Language::ukrainian};

inline const Texts& english() {
    static const Texts kEnglish(text::Language::english);
    return kEnglish;
}

/// The project of a YAML text without errors.
inline model::Project project_of(const std::string& yaml) {
    const auto read = file::load_text("sample.yaml", yaml);
    EXPECT_TRUE(read.readable);
    auto checked = model::interpret(read.document);
    for (const auto& finding : read.findings) ADD_FAILURE() << finding.code;
    for (const auto& finding : checked.findings)
        EXPECT_NE(finding.severity, model::Severity::error) << finding.code << ' ' << finding.path;
    return std::move(checked.project);
}

/// A line with one device: a coil that is written by a trigger, three values in one request, a value that is
/// written on change, and one that is read by a trigger; in the order of the requests.
inline const std::string kBoiler = R"(takt: 1
lines:
  - name: rs485-1
    transport: serial
    port: /dev/ttyUSB0
    baud: 19200
    devices:
      - name: Котёл
        address: 16
        poll_period: 500ms
        turnaround: 5ms
        group_requests: true
        strategy: classic
        variables:
          - {name: Supply, type: float, register: 0, read: 0x03}
          - {name: Return, type: float, register: 2, read: 0x03}
          - {name: Setpoint, type: float, register: 4, read: 0x03}
          - {name: Limit, type: int16, register: 10, read: 0x03, write: 0x06, write_on_change: true}
          - {name: Serial, type: uint32, register: 100, read: 0x03, period: 0ms, read_trigger: go}
          - {name: Pump, type: bool, coil: 3, read: 0x01, write: 0x05, write_trigger: go, period: 1s}
locals:
  - {name: go, type: bool}
)";

/// A line of a TCP device without variables.
inline const std::string kEmptyLine = R"(takt: 1
lines:
  - name: net
    transport: tcp
    host: 10.0.0.7
    devices:
      - {name: Meter, address: 1, variables: []}
)";

/// Twelve devices, each polled every 20 ms at 9600 bit/s, which the line cannot hold.
inline std::string overloaded() {
    std::string yaml = R"(takt: 1
lines:
  - name: slow
    transport: serial
    port: /dev/ttyS1
    baud: 9600
    devices:
)";
    for (int i = 1; i <= 12; ++i)
        yaml += "      - {name: D" + std::to_string(i) + ", address: " + std::to_string(i) +
                ", poll_period: 20ms, turnaround: 5ms, variables: [{name: V" + std::to_string(i) +
                ", type: int16, register: 0, read: 0x03}]}\n";
    return yaml;
}

/// No message code without a text, and no placeholder without its argument.
inline void expect_complete(const std::string& text) {
    for (const char* code : {"app.", "plan.gap", "plan.limit", "guarantee."})
        EXPECT_EQ(text.find(code), std::string::npos) << text;
    EXPECT_EQ(text.find('{'), std::string::npos) << text;
    EXPECT_EQ(text.find('}'), std::string::npos) << text;
}

inline void expect_contains(const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << "'" << part << "' is not in:\n" << text;
}

/// The value at a path of keys and indices: at(json, "lines", 0, "name").
inline const file::Json& at(const file::Json& json) {
    return json;
}
template <class Key, class... Rest>
const file::Json& at(const file::Json& json, Key key, Rest... rest) {
    static const file::Json kNone;
    if constexpr (std::is_integral_v<Key>) {
        const auto* list = std::get_if<file::Json::Array>(&json.value());
        if (list && static_cast<std::size_t>(key) < list->size())
            return at((*list)[static_cast<std::size_t>(key)], rest...);
    } else if (const auto* found = json.find(key)) {
        return at(*found, rest...);
    }
    ADD_FAILURE() << "no " << key << " in " << json.dump();
    return kNone;
}

inline std::size_t size_of(const file::Json& json) {
    const auto* list = std::get_if<file::Json::Array>(&json.value());
    return list ? list->size() : 0;
}

inline std::size_t count_of(const std::string& text, const std::string& part) {
    std::size_t count = 0;
    for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size())) ++count;
    return count;
}

/// Every element of an XML document is closed in its order, and no text has bare markup.
inline bool well_formed(const std::string& xml) {
    std::vector<std::string> open;
    for (std::size_t i = xml.find('<'); i != std::string::npos; i = xml.find('<', i + 1)) {
        const auto end = xml.find('>', i);
        if (end == std::string::npos) return false;
        const std::string tag = xml.substr(i + 1, end - i - 1);
        if (tag.find('<') != std::string::npos) return false;
        if (tag.starts_with('?') || tag.ends_with('/')) continue;
        const std::string name = tag.substr(0, tag.find(' '));
        if (!name.starts_with('/')) {
            open.push_back(name);
        } else if (open.empty() || open.back() != name.substr(1)) {
            return false;
        } else {
            open.pop_back();
        }
    }
    return open.empty();
}

}  // namespace takt::report::test
