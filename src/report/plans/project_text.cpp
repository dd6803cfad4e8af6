#include "plans/project_text.hpp"

#include <fmt/format.h>

#include "takt/file/convert.hpp"

namespace takt::report {

std::string quoted_yaml(const std::string& text) {
    std::string made = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') made += '\\';
        made += c;
    }
    return made + '"';
}

std::string connection_yaml(const model::Line& line) {
    std::string text;
    for (const auto& [key, value] : file::connection_keys(line)) {
        const bool free_text = key == "port" || key == "host";
        text += fmt::format("    {}: {}\n", key, free_text ? quoted_yaml(value) : value);
    }
    return text;
}

}  // namespace takt::report
