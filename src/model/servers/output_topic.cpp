// Topics of an output as written in a project.
#include <algorithm>
#include <vector>

#include "servers/interpretation.hpp"
#include "servers/output_parts.hpp"
#include "takt/model/nearest.hpp"

namespace takt::model {
namespace {

Rule rule_of(TopicError error) {
    switch (error) {
        case TopicError::brace: return Rule::topic_brace;
        case TopicError::wildcard: return Rule::topic_wildcard;
        case TopicError::empty_level: return Rule::topic_empty_level;
        case TopicError::unknown_part: break;
    }
    return Rule::topic_unknown_part;
}

std::string in_braces(std::string_view part) {
    return std::string("{").append(part).append("}");
}

}  // namespace

std::optional<TopicTemplate> read_topic(Reader& reader, std::string_view key,
                                        std::span<const TopicPart> allowed) {
    const auto text = reader.text(key);
    if (!text) return std::nullopt;
    std::vector<std::string_view> names;
    std::string listed;
    for (const auto part : allowed) {
        names.push_back(topic_parts()[static_cast<std::size_t>(part)]);
        listed.append(listed.empty() ? "" : ", ").append(in_braces(names.back()));
    }
    const auto report = [&](Rule rule, std::string_view part) {
        const auto bare = part.size() > 2 ? part.substr(1, part.size() - 2) : std::string_view();
        const auto guess = nearest(bare, names);
        reader.report(rule, key, listed, {{"part", std::string(part)}, {"nearest", in_braces(guess)}});
    };
    auto topic = TopicTemplate::parse(*text);
    if (!topic) {
        report(rule_of(topic.error().error), topic.error().part);
        return std::nullopt;
    }
    for (std::size_t i = 0; i < topic_parts().size(); ++i)
        if (topic->has(static_cast<TopicPart>(i)) &&
            std::ranges::find(names, topic_parts()[i]) == names.end()) {
            report(Rule::topic_unknown_part, in_braces(topic_parts()[i]));
            return std::nullopt;
        }
    return *std::move(topic);
}

}  // namespace takt::model
