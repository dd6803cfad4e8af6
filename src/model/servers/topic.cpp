#include "takt/model/topic.hpp"

#include <algorithm>
#include <array>
#include <optional>

namespace takt::model {
namespace {

constexpr std::array<std::string_view, 4> kParts{"output", "line", "device", "variable"};
constexpr std::string_view kWildcards = "+#";

/// A level that is a placeholder is never empty: names have at least one character.
bool has_empty_level(std::string_view text) {
    if (text.ends_with('/')) text.remove_suffix(1);
    return text.empty() || text.starts_with('/') || text.ends_with('/') ||
           text.find("//") != std::string_view::npos;
}

void append_level(std::string& topic, std::string_view name) {
    for (const char c : name) {
        const bool control = static_cast<unsigned char>(c) < 0x20 || c == 0x7F;
        topic += control || c == '/' || kWildcards.find(c) != std::string_view::npos ? '_' : c;
    }
}

std::string_view name_in_topic(const TopicNames& names, TopicPart part) {
    switch (part) {
        case TopicPart::output: return names.output;
        case TopicPart::line: return names.line;
        case TopicPart::device: return names.device;
        case TopicPart::variable: break;
    }
    return names.variable;
}

std::optional<TopicPart> part_of(std::string_view name) {
    const auto* const found = std::ranges::find(kParts, name);
    if (found == kParts.end()) return std::nullopt;
    return static_cast<TopicPart>(found - kParts.begin());
}

}  // namespace

std::span<const std::string_view> topic_parts() {
    return kParts;
}

std::expected<TopicTemplate, TopicTemplate::Failure> TopicTemplate::parse(std::string_view text) {
    const auto fail = [](TopicError error, std::string_view part = {}) {
        return std::unexpected(Failure{error, part});
    };
    if (text.find_first_of(kWildcards) != std::string_view::npos) return fail(TopicError::wildcard);
    if (has_empty_level(text)) return fail(TopicError::empty_level);
    TopicTemplate made;
    while (true) {
        const auto open = text.find_first_of("{}");
        if (open == std::string_view::npos) break;
        const auto close = text.find_first_of("{}", open + 1);
        if (text[open] != '{' || close == std::string_view::npos || text[close] != '}')
            return fail(TopicError::brace);
        const auto part = part_of(text.substr(open + 1, close - open - 1));
        if (!part) return fail(TopicError::unknown_part, text.substr(open, close - open + 1));
        made.parts_.emplace_back(text.substr(0, open), *part);
        text.remove_prefix(close + 1);
    }
    made.rest_ = text;
    return made;
}

bool TopicTemplate::has(TopicPart part) const {
    return std::ranges::any_of(parts_, [part](const auto& each) { return each.second == part; });
}

std::string TopicTemplate::expand(const TopicNames& names) const {
    std::string topic;
    for (const auto& [text, part] : parts_) {
        topic += text;
        append_level(topic, name_in_topic(names, part));
    }
    return topic += rest_;
}

}  // namespace takt::model
