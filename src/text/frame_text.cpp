#include "takt/text/frame_text.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include "takt/base/ascii.hpp"
#include "takt/text/catalogue.hpp"

namespace takt::text {
namespace {

struct Phrase {
    std::string_view english;
    std::string_view code;
};

/// Longest first: "read coils" before "read". A noun with its plural, "{count|value|values}", is two phrases.
const std::vector<Phrase>& phrases() {
    static const std::vector<Phrase> kPhrases = [] {
        std::vector<Phrase> made;
        for (const auto code : codes(Language::english)) {
            if (!code.starts_with("frame.") && !code.starts_with("exception.")) continue;
            constexpr std::string_view kCount = "{count|";
            auto english = pattern(Language::english, code);
            if (english.starts_with(kCount)) {
                english.remove_prefix(kCount.size());
                english.remove_suffix(1);
                made.push_back({english.substr(english.find('|') + 1), code});
                english = english.substr(0, english.find('|'));
            }
            made.push_back({english, code});
        }
        std::ranges::sort(made, std::ranges::greater(), [](const Phrase& p) { return p.english.size(); });
        return made;
    }();
    return kPhrases;
}

bool is_of_word(char c) {
    return is_digit(c) || (lower_case(c) >= 'a' && lower_case(c) <= 'z') || c == '_' || c == '/';
}

std::size_t word_length(std::string_view text) {
    return static_cast<std::size_t>(std::ranges::find_if_not(text, is_of_word) - text.begin());
}

}  // namespace

std::string frame_text(Language language, std::string_view words) {
    if (language == Language::english) return std::string(words);
    std::string text;
    std::string_view number;  // the last one
    while (!words.empty()) {
        const auto begins = [&](const Phrase& phrase) {
            return words.starts_with(phrase.english) &&
                   (words.size() == phrase.english.size() || !is_of_word(words[phrase.english.size()]));
        };
        auto taken = std::max<std::size_t>(word_length(words), 1);
        if (words[0] == '"') taken = std::min(words.find('"', 1), words.size() - 1) + 1;
        if (is_digit(words[0])) number = words.substr(0, taken);
        if (const auto phrase = std::ranges::find_if(phrases(), begins); phrase != phrases().end()) {
            text += message(language, phrase->code, std::array{Argument{"count", number}});
            taken = phrase->english.size();
        } else {
            text += words.substr(0, taken);
        }
        words.remove_prefix(taken);
    }
    return text;
}

}  // namespace takt::text
