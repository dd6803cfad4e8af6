// `tags` of a variable: a list, or in the cell of a table words with commas or blanks between them.
#include <algorithm>

#include "servers/interpretation.hpp"
#include "takt/base/ascii.hpp"
#include "takt/base/utf8.hpp"

namespace takt::model {
namespace {

constexpr std::size_t kMostTags = 32;
constexpr std::size_t kLongestTag = 32;
constexpr std::string_view kBetween = ",; \t";

/// Letters of any language.
bool is_tag(std::string_view word) {
    return !word.empty() && count_characters(word) <= kLongestTag && std::ranges::all_of(word, [](char c) {
        return is_digit(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '-' || c == '_' ||
               static_cast<unsigned char>(c) >= 0x80;
    });
}

std::vector<std::string> tag_words(std::string_view text) {
    std::vector<std::string> words;
    while (true) {
        text.remove_prefix(std::min(text.find_first_not_of(kBetween), text.size()));
        if (text.empty()) return words;
        const auto end = std::min(text.find_first_of(kBetween), text.size());
        words.emplace_back(text.substr(0, end));
        text.remove_prefix(end);
    }
}

}  // namespace

std::vector<std::string> read_tags(Interpretation& state, Reader& reader) {
    std::vector<std::string> tags;
    const auto add = [&](const std::string& word, const SourceLocation& location, const std::string& path) {
        if (std::ranges::find(tags, word) != tags.end()) return;
        if (is_tag(word))
            tags.push_back(word);
        else
            state.findings.add(Rule::tag_malformed, location, path, word,
                               "1.." + std::to_string(kLongestTag));
    };
    const Node* const node = reader.value("tags");
    if (node == nullptr) return tags;
    if (node->cell && node->kind == Node::Kind::scalar) {
        for (const auto& word : tag_words(node->text)) add(word, node->location, reader.path_of("tags"));
    } else if (reader.list("tags") != nullptr) {
        for (std::size_t i = 0; i < node->items.size(); ++i)
            add(node->items[i].text, node->items[i].location,
                reader.path_of("tags") + "[" + std::to_string(i) + "]");
    }
    if (tags.size() > kMostTags)
        reader.report(Rule::field_out_of_range, "tags", "0.." + std::to_string(kMostTags));
    return tags;
}

}  // namespace takt::model
