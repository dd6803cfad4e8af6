// Words for the numbers of a variable, and names for its bits: a mapping `{0: off, 1: on}`, or in the cell of
// a table the text `0=off, 1=on`.
#include "takt/model/value_words.hpp"

#include <algorithm>
#include <set>
#include <string>
#include <utility>

#include "servers/interpretation.hpp"
#include "takt/base/ascii.hpp"
#include "takt/base/utf8.hpp"

namespace takt::model {
namespace {

constexpr std::size_t kMostWords = 256;
constexpr std::size_t kLongestWord = 64;

constexpr std::string_view kWordBlanks = " \t";

/// The numbers that the type of a variable can hold, as far as words have numbers.
Range numbers_of(DataType type) {
    constexpr std::int64_t kMost = 0xFFFF'FFFF;
    switch (type) {
        case DataType::boolean: return {0, 1, 1};
        case DataType::int16: return {-32768, 32767, 32767};
        case DataType::uint16: return {0, 65535, 65535};
        case DataType::uint32:
        case DataType::uint64: return {0, kMost, kMost};
        default: return {-2147483648, 2147483647, 2147483647};
    }
}

/// Reads the words behind one key.
class Words {
public:
    Words(Interpretation& state, Reader& reader, std::string_view key, const Range& range)
        : state_(state), reader_(reader), key_(key), range_(range) {}

    std::vector<ValueWord> read() {
        const Node& node = *reader_.value(key_);
        if (node.kind == Node::Kind::mapping) {
            for (const auto& [number, word] : node.entries) {
                const bool valid = number.kind == Node::Kind::scalar && word.kind == Node::Kind::scalar;
                if (valid)
                    add(number.text, word.text, number.location);
                else
                    refuse(number.location, number.text);
            }
        } else if (node.kind == Node::Kind::scalar) {
            read_text(node);
        } else {
            reader_.report(Rule::field_not_a_value, key_);
        }
        std::ranges::sort(words_, {}, &ValueWord::number);
        return std::move(words_);
    }

private:
    void read_text(const Node& node) {
        for (std::string_view rest = node.text; !trimmed(rest, kWordBlanks).empty();) {
            const auto end = std::min(rest.find_first_of(",;"), rest.size());
            const auto entry = trimmed(rest.substr(0, end), kWordBlanks);
            const auto sign = entry.find_first_of("=:");
            if (sign == std::string_view::npos)
                refuse(node.location, entry);
            else
                add(trimmed(entry.substr(0, sign), kWordBlanks), trimmed(entry.substr(sign + 1), kWordBlanks),
                    node.location);
            rest.remove_prefix(std::min(end + 1, rest.size()));
        }
    }

    void add(std::string_view number, std::string_view word, const SourceLocation& location) {
        const auto parsed = parse_integer(number);
        const auto value = parsed ? parsed->as_int64() : std::nullopt;
        const bool control =
            std::ranges::any_of(word, [](char c) { return static_cast<unsigned char>(c) < 0x20; });
        if (!value || word.empty() || count_characters(word) > kLongestWord || control)
            return refuse(location, std::string(number) + ": " + std::string(word));
        if (*value < range_.least || *value > range_.greatest || words_.size() >= kMostWords)
            return report(Rule::field_out_of_range, location, number,
                          std::to_string(range_.least) + ".." + std::to_string(range_.greatest));
        if (!numbers_.insert(*value).second) return report(Rule::words_twice, location, number, {});
        words_.push_back({*value, std::string(word)});
    }

    void refuse(const SourceLocation& location, std::string_view text) {
        report(Rule::words_malformed, location, text, "1.." + std::to_string(kLongestWord));
    }

    void report(Rule rule, const SourceLocation& location, std::string_view value, std::string allowed) {
        state_.findings.add(rule, location, reader_.path_of(key_), value, std::move(allowed),
                            {{"key", std::string(key_)}});
    }

    Interpretation& state_;
    Reader& reader_;
    std::string_view key_;
    Range range_;
    std::vector<ValueWord> words_;
    std::set<std::int64_t> numbers_;
};

}  // namespace

void read_value_words(Interpretation& state, Reader& reader, Variable& variable,
                      std::optional<DataType> type) {
    for (const std::string_view key : {"enumeration", "bits"}) {
        if (!reader.given(key)) continue;
        const bool bits = key == "bits";
        const bool number = type && *type != DataType::string && *type != DataType::float32 &&
                            *type != DataType::float64 && !variable.scaled() &&
                            !(bits && *type == DataType::boolean);
        if (type && !number) {
            reader.report(Rule::words_type, key, {},
                          {{"key", std::string(key)}, {"type", std::string(name(*type))}});
        } else if (type) {
            const std::int64_t last = variable.registers * 16 - 1;
            const auto range = bits ? Range{0, last, last} : numbers_of(*type);
            (bits ? variable.bits : variable.enumeration) = Words(state, reader, key, range).read();
        }
    }
}

std::string words_of(const Variable& variable, std::int64_t number) {
    const auto word = std::ranges::find(variable.enumeration, number, &ValueWord::number);
    if (word != variable.enumeration.end()) return word->word;
    std::string names;
    const auto pattern = static_cast<std::uint64_t>(number);
    for (const auto& [bit, name] : variable.bits)
        if ((pattern >> static_cast<unsigned>(bit) & 1U) != 0)
            names.append(names.empty() ? "" : ", ").append(name);
    return names;
}

std::string text_of(const std::vector<ValueWord>& words) {
    std::string text;
    for (const auto& [number, word] : words)
        text.append(text.empty() ? "" : ", ").append(std::to_string(number)).append("=").append(word);
    return text;
}

}  // namespace takt::model
