// The field table (fields.hpp) has the kind, the range and the words of each key. The constructor reports
// keys that are unknown or missing; a getter reports an invalid value of its key and returns nothing, so that
// reading continues and all findings are reported at once.
//
// A misspelt key gives one finding: check_key() remembers the key that it surely means, and check_missing()
// does not report that key as missing. In a table the key is the heading of a column, which is the same for
// all rows: it is reported for the first row only.
#include "reading/reader.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "reading/field_ranges.hpp"
#include "takt/base/ascii.hpp"
#include "takt/base/assert.hpp"
#include "takt/base/utf8.hpp"
#include "takt/model/nearest.hpp"
#include "takt/model/synonyms.hpp"

namespace takt::model {
namespace {

bool is_cell(const Node& node) {
    return node.cell;
}

std::string_view scalar_text(const Node* node) {
    return node != nullptr && node->kind == Node::Kind::scalar ? std::string_view(node->text)
                                                               : std::string_view();
}

bool has_control_character(std::string_view text) {
    return std::ranges::any_of(text,
                               [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; });
}

std::string bounds(const Range& range) {
    return std::to_string(range.least) + ".." + std::to_string(range.greatest);
}

/// The reason why a word is not allowed: the profile if it forbids the word itself, else the transport.
std::string condition(const Field& field, std::size_t word, Context context) {
    const auto transport = "transport: " + std::string(name(context.transport));
    context.profile = Profile::generic;
    return field.fits(word, context) ? "profile: " + std::string(name(Profile::owen_kc1)) : transport;
}

bool may_hold(const Field& field, const Node* value) {
    if (value == nullptr) return true;
    if (value->kind == Node::Kind::mapping) return field.kind == Kind::mapping || field.object;
    const bool list = value->kind == Node::Kind::list;
    if (field.kind == Kind::ranges) return true;
    return list ? field.kind == Kind::list : field.kind != Kind::list && field.kind != Kind::mapping;
}

bool is_number(const Node* value) {
    return value != nullptr && value->kind == Node::Kind::scalar && all_digits(value->text);
}

/// A number is no text: `unit: 3` is not the unit of a variable, and `port: 502` is not a serial port.
bool has_key(Object object, std::string_view word, const Node* value) {
    const auto* const field = find_field(object, word);
    return field != nullptr && !(field->kind == Kind::text && is_number(value));
}

/// `lines[].host`: the key that a key of `object` with this value means in another object. That is one that
/// encloses `object`, the innermost first, else one inside it, else any other one; the project at last. Of
/// equally near ones the first that has the word itself. Empty if there is none.
std::string owner_of(std::string_view word, const Node* value, Object object) {
    std::string owner;
    std::size_t best = 0;
    const auto here = location(object);
    for (const auto candidate : kObjects) {
        const bool has = has_key(candidate, word, value);
        const auto key = has ? word : synonym_elsewhere(candidate, word);
        if (candidate == object || key.empty() || !may_hold(*find_field(candidate, key), value)) continue;
        const auto where = location(candidate);
        const auto holds = [](std::string_view outer, std::string_view inner) {
            return !outer.empty() && inner.starts_with(std::string(outer) + '.');
        };
        const std::size_t nearness = holds(where, here)   ? where.size() + 3
                                     : holds(here, where) ? 3
                                     : where.empty()      ? 1
                                                          : 2;
        const std::size_t rank = 2 * nearness + (has ? 1 : 0);
        if (rank <= best) continue;
        owner.assign(where).append(where.empty() ? "" : ".").append(key);
        best = rank;
    }
    return owner;
}

/// The finding about a number or a duration with commas.
std::optional<std::pair<Rule, Arguments>> comma_finding(const Field* field, std::string_view text) {
    const bool duration = field != nullptr && field->kind == Kind::duration;
    const auto number = duration ? text.substr(0, text.find_first_not_of("0123456789,")) : text;
    const std::string unit(text.substr(number.size()));
    const auto point = with_point(number);
    const auto whole = without_thousands(number);
    const bool integer = field != nullptr && field->kind == Kind::integer;
    const auto& meant = !whole.empty() && (integer || point.empty()) ? whole : point;
    if (meant.empty() || (duration && !parse_duration(meant + unit))) return std::nullopt;
    if (&meant == &whole) return {{Rule::number_thousands, {{"meant", whole + unit}}}};
    Arguments arguments{{"meant", point + unit}};
    if (!whole.empty())
        arguments.insert(arguments.end(), {{"variant", "two_meanings"}, {"other", whole + unit}});
    return {{Rule::number_comma, std::move(arguments)}};
}

/// `4ms, 4us`: at most two durations of the range that a number without unit may mean.
std::string with_units(const std::string& number, const Range& range) {
    constexpr std::array<std::string_view, 5> kUnits{"ms", "s", "us", "min", "h"};
    std::string texts;
    int count = 0;
    for (const auto unit : kUnits) {
        const auto text = number + std::string(unit);
        const auto meant = parse_duration(text);
        if (!meant || meant->count() < range.least || meant->count() > range.greatest || count == 2) continue;
        texts.append(count++ == 0 ? "" : ", ").append(text);
    }
    return texts.empty() ? number + "ms" : texts;
}

bool begins_with_letter(std::string_view text) {
    return !text.empty() && ((text[0] >= 'a' && text[0] <= 'z') || (text[0] >= 'A' && text[0] <= 'Z'));
}

/// The number of a function that is named as `fc16`, `FC 16` or `fc_016`: "16"; empty: it is none.
std::string function_number(std::string_view name) {
    std::string number;
    for (const char c : name)
        if (c != '_' && c != '-' && c != ' ') number += lower_case(c);
    if (!number.starts_with("fc")) return {};
    number.erase(0, number.find_first_not_of('0', 2));
    return all_digits(number) ? number : std::string();
}

/// The arguments of the key or value that names a function: its key of a variable. Empty: it names none, or
/// one that has a key of its own.
Arguments function_arguments(std::string_view named) {
    auto number = function_number(named);
    if (number.empty() || number == "22" || number == "23") return {};
    for (const auto& [name, words] :
         {std::pair{"read: ", std::span<const std::string_view>(kReadFunctions)},
          std::pair{"write: ", std::span<const std::string_view>(kWriteFunctions)}})
        for (const auto word : words.subspan(1))
            if (std::to_string(parse_integer(word)->magnitude) == number)
                return {{"variant", "function"},
                        {"function", std::string(name).append(word)},
                        {"number", std::move(number)}};
    return {{"variant", "other_function"}, {"number", std::move(number)}};
}

/// `1/10` as `0.1`; empty: it is no fraction.
std::string decimal_of(std::string_view fraction) {
    const auto slash = std::min(fraction.find('/'), fraction.size());
    const auto above = parse_number(fraction.substr(0, slash));
    const auto below = parse_number(fraction.substr(std::min(slash + 1, fraction.size())));
    return above && below && *below != 0 ? to_text(*above / *below) : std::string();
}

}  // namespace

bool is_quoted(const Node& node) {
    return node.quoted && !is_cell(node);
}

Reader::Reader(Findings& findings, const Node& node, std::string path, Object object, const Context& context)
    : findings_(findings), node_(node), path_(std::move(path)), object_(object), context_(context) {
    TAKT_ASSERT(node.kind == Node::Kind::mapping);
    check_keys();
    check_missing();
}

std::string Reader::path_of(std::string_view key) const {
    std::string path = path_;
    if (!path.empty()) path += '.';
    return path.append(key);
}

void Reader::report(Rule rule, std::string_view key, std::string allowed, Arguments arguments) {
    const Node* const there = value(key);
    findings_.add(rule, there != nullptr ? there->location : node_.location, path_of(key), scalar_text(there),
                  std::move(allowed), std::move(arguments));
}

void Reader::report_without_effect(std::string_view key, std::string condition) {
    report(Rule::field_without_effect, key, {},
           {{"key", std::string(key)}, {"condition", std::move(condition)}});
}

void Reader::report_needs(std::string_view key, std::string condition) {
    if (given(key))
        report(Rule::field_needs, key, {}, {{"key", std::string(key)}, {"condition", std::move(condition)}});
}

void Reader::check_keys() {
    for (const auto& [key, value] : node_.entries) check_key(key);
}

void Reader::check_key(const Node& key) {
    if (find_field(object_, key.text) != nullptr) return;
    if (const auto* const meant = is_cell(key) ? findings_.known_column(key.location) : nullptr) {
        if (!meant->empty()) misspelt_.push_back(*meant);
        return;
    }
    if (findings_.full(Rule::key_unknown)) {
        findings_.add(Rule::key_unknown, key.location, {}, {});
        return;
    }
    if (check_slip(key) || check_password(key)) return;
    auto list = keys_of(object_);
    if (object_ == Object::device || object_ == Object::variable)
        if (auto arguments = function_arguments(key.text); !arguments.empty())
            return findings_.add(Rule::key_unlike, key.location, path_of(key.text), key.text, std::move(list),
                                 std::move(arguments));
    std::vector<std::string_view> known;
    for (const auto& field : fields(object_)) known.push_back(field.key);
    constexpr std::size_t kSurelyATypo = 2;
    const auto near = nearest(key.text, known);
    const bool own = typing_distance(key.text, near) <= kSurelyATypo;
    // `tag: Level` without a name is the name, although it is near to `tags`.
    auto other = synonym(object_, key.text);
    if (other == "host" && find_field(object_, other)->kind == Kind::mapping) other = {};  // in the project
    const bool lacks_it = !other.empty() && find_field(object_, other)->required && value(other) == nullptr;
    const auto meant = own && !lacks_it ? std::string_view() : other;
    const auto guess = meant.empty() ? near : meant;
    if (!meant.empty() && value(meant) != nullptr) {
        findings_.add(Rule::key_twice, key.location, path_of(key.text), key.text, std::move(list),
                      {{"key", std::string(meant)}});
        return;
    }
    const bool typo = !meant.empty() || typing_distance(key.text, guess) <= kSurelyATypo;
    if (typo) misspelt_.push_back(guess);
    if (is_cell(key)) findings_.remember_column(key.location, typo ? guess : std::string_view());
    // `timeout` may mean this object's `response_timeout`, even if another object has the key `timeout`.
    const bool part = guess.find(key.text) != std::string_view::npos;
    auto owner =
        typo || object_ == Object::firmware ? std::string() : owner_of(key.text, value(key.text), object_);
    const bool encloses = location(object_).starts_with(owner.substr(0, owner.rfind('.') + 1));
    if (!owner.empty() && (encloses || !part || !owner.ends_with('.' + key.text))) {
        findings_.add(Rule::key_elsewhere, key.location, path_of(key.text), key.text, std::move(list),
                      {{"location", std::move(owner)}});
        return;
    }
    if (!typo && is_unlike(key.text, guess)) {
        findings_.add(Rule::key_unlike, key.location, path_of(key.text), key.text, std::move(list));
        return;
    }
    findings_.add(Rule::key_unknown, key.location, path_of(key.text), key.text, std::move(list),
                  {{"nearest", std::string(guess)}});
}

// YAML reads `name:l1` as a key without a value, and `{scale: 0,1}` as two keys.
bool Reader::check_slip(const Node& key) {
    const Node* const there = node_.find(key.text);
    if (is_cell(key) || there == nullptr || there->kind != Node::Kind::null) return false;
    const auto colon = key.text.find(':');
    if (const Field* const meant = find_field(object_, key.text.substr(0, colon)); meant != nullptr) {
        misspelt_.push_back(meant->key);
        findings_.add(Rule::key_no_space, key.location, path_of(key.text), key.text, {},
                      {{"key", std::string(meant->key)}, {"rest", key.text.substr(colon + 1)}});
        return true;
    }
    const auto at =
        std::ranges::find_if(node_.entries, [&](const Node::Entry& entry) { return &entry.key == &key; });
    if (at == node_.entries.begin() || !divided_by_comma(std::prev(at)->key.text)) return false;
    const auto& [owner, whole] = *std::prev(at);
    const auto text = whole.text + ',' + key.text;
    auto [rule, arguments] = *comma_finding(find_field(object_, owner.text), text);
    findings_.add(rule, whole.location, path_of(owner.text), text, {}, std::move(arguments));
    return true;
}

// A password does not belong into a file that is shown, copied and kept in versions. Its value is not
// reported.
bool Reader::check_password(const Node& key) {
    constexpr std::array<std::string_view, 5> kWords{"password", "passwd", "pass", "pwd", "secret"};
    if (object_ != Object::output || std::ranges::find(kWords, key.text) == kWords.end()) return false;
    findings_.add(Rule::output_password, key.location, path_of(key.text), key.text, {}, {{"key", key.text}});
    return true;
}

bool Reader::misspelt(std::string_view key) const {
    return std::ranges::find(misspelt_, key) != misspelt_.end();
}

void Reader::check_missing() {
    for (const auto& field : fields(object_)) {
        const Node* const there = node_.find(field.key);
        const Arguments key{{"key", std::string(field.key)}};
        const bool cell = there != nullptr && there->kind == Node::Kind::null && is_cell(*there);
        if (there == nullptr || cell) {
            if (field.required && !misspelt(field.key))
                findings_.add(Rule::field_missing, cell ? there->location : node_.location,
                              path_of(field.key), {}, allowed(field, context_), key);
        } else if (there->kind == Node::Kind::null && (field.kind != Kind::list || field.required)) {
            findings_.add(Rule::field_empty, there->location, path_of(field.key), {},
                          allowed(field, context_), key);
        }
    }
}

const Field& Reader::field(std::string_view key) const {
    const Field* const found = find_field(object_, key);
    TAKT_ASSERT(found != nullptr);
    return *found;
}

const Node* Reader::value(std::string_view key) const {
    const Node* const found = node_.find(key);
    return found == nullptr || found->kind == Node::Kind::null ? nullptr : found;
}

const Node* Reader::scalar(std::string_view key) {
    const Node* const found = value(key);
    if (found == nullptr || found->kind == Node::Kind::scalar) return found;
    report(Rule::field_not_a_value, key, allowed_text(key));
    return nullptr;
}

const Node* Reader::list(std::string_view key) {
    const Node* const found = value(key);
    if (found == nullptr || found->kind == Node::Kind::list) return found;
    report(Rule::field_not_a_list, key);
    return nullptr;
}

const Node* Reader::mapping(std::string_view key) {
    const Node* const found = value(key);
    if (found == nullptr || found->kind == Node::Kind::mapping) return found;
    // `host: 10.0.0.5` beside the lines is that of a line.
    const bool word = object_ == Object::project && !parse_duration(scalar_text(found));
    if (auto owner = owner_of(key, found, object_); word && !owner.empty()) {
        findings_.add(Rule::key_elsewhere, found->location, path_of(key), std::string(key), allowed_text(key),
                      {{"location", std::move(owner)}});
        return nullptr;
    }
    report(Rule::field_not_a_group, key, allowed_text(key), {{"key", std::string(key)}});
    return nullptr;
}

// `{scale: 0,1}`: YAML reads a key without a value after the number.
bool Reader::divided_by_comma(std::string_view key) const {
    const auto at =
        std::ranges::find_if(node_.entries, [&](const Node::Entry& entry) { return entry.key.text == key; });
    if (at == node_.entries.end() || std::next(at) == node_.entries.end()) return false;
    const auto& [rest, nothing] = *std::next(at);
    return at->value.kind == Node::Kind::scalar && nothing.kind == Node::Kind::null && !is_cell(rest) &&
           comma_finding(find_field(object_, key), at->value.text + ',' + rest.text);
}

const Node* Reader::number_scalar(std::string_view key) {
    const Node* const found = scalar(key);
    if (found == nullptr) return found;
    if (divided_by_comma(key)) return nullptr;  // reported with its second part
    if (auto finding = comma_finding(&field(key), found->text)) {
        report(finding->first, key, allowed_text(key), std::move(finding->second));
        return nullptr;
    }
    if (!is_quoted(*found) || !(parse_number(found->text) || parse_integer(found->text))) return found;
    report(Rule::field_quoted_number, key, allowed_text(key));
    return nullptr;
}

void Reader::report_scalar(ScalarError error, const Field& field, Rule malformed) {
    const auto rule = [&] {
        switch (error) {
            case ScalarError::malformed: return malformed;
            case ScalarError::fraction:
                return field.kind == Kind::duration ? Rule::duration_malformed : Rule::integer_fraction;
            case ScalarError::leading_zero: return Rule::integer_leading_zero;
            case ScalarError::no_unit: return Rule::duration_no_unit;
            case ScalarError::too_large: return Rule::field_out_of_range;
        }
        std::unreachable();
    }();
    Arguments arguments;
    if (rule == Rule::duration_no_unit)
        arguments.emplace_back("meant",
                               with_units(std::string(scalar_text(value(field.key))), field.range(context_)));
    const auto decimal = rule == Rule::number_malformed ? decimal_of(scalar_text(value(field.key))) : "";
    if (!decimal.empty()) arguments = {{"variant", "fraction"}, {"meant", decimal}};
    report(rule, field.key, allowed(field, context_), std::move(arguments));
}

std::optional<std::int64_t> Reader::in_range(const Field& field, std::int64_t value) {
    const auto range = field.range(context_);
    if (value == 0 && range.least > 0 && field.zero_means != nullptr) {
        const std::int64_t meant = field.zero_means(context_);
        const auto used = field.kind == Kind::duration ? to_text(Duration(meant)) : std::to_string(meant);
        report(Rule::field_zero_replaced, field.key, allowed(field, context_), {{"used", used}});
        return meant;
    }
    if (value < range.least || value > range.tolerated) {
        report(Rule::field_out_of_range, field.key, allowed(field, context_));
        return std::nullopt;
    }
    if (value > range.greatest) {
        const bool address = field.key == "address";
        report(address ? Rule::address_reserved : Rule::device_registers_cut, field.key,
               allowed(field, context_),
               {{"limit", std::to_string(range.greatest)},
                {"written", std::to_string(most_written_registers(context_))}});
    }
    return value;
}

std::optional<std::int64_t> Reader::integer(std::string_view key) {
    const auto& field = this->field(key);
    const Node* const found = number_scalar(key);
    if (found == nullptr) return std::nullopt;
    const auto parsed = parse_integer(found->text);
    const auto value = parsed ? parsed->as_int64() : std::nullopt;
    if (value) return in_range(field, *value);
    report_scalar(parsed ? ScalarError::too_large : parsed.error(), field, Rule::integer_malformed);
    return std::nullopt;
}

std::optional<Duration> Reader::duration(std::string_view key) {
    const auto& field = this->field(key);
    const Node* const found = scalar(key);
    if (found == nullptr) return std::nullopt;
    if (word_instead(key)) return std::nullopt;
    const auto parsed = parse_duration(found->text);
    if (!parsed && !field.words.empty() && begins_with_letter(found->text)) {
        report_unknown_word(field, found->text);
        return std::nullopt;
    }
    if (divided_by_comma(key)) return std::nullopt;  // reported with its second part
    if (auto finding = comma_finding(&field, found->text)) {
        report(finding->first, key, allowed_text(key), std::move(finding->second));
        return std::nullopt;
    }
    if (!parsed) {
        report_scalar(parsed.error(), field, Rule::duration_malformed);
        return std::nullopt;
    }
    const auto value = in_range(field, parsed->count());
    if (!value) return std::nullopt;
    return Duration(*value);
}

bool Reader::word_instead(std::string_view key) const {
    const auto& words = field(key).words;
    return std::ranges::find(words, scalar_text(value(key))) != words.end();
}

std::optional<bool> Reader::boolean(std::string_view key) {
    const Node* const found = scalar(key);
    if (found == nullptr) return std::nullopt;
    const auto parsed = is_quoted(*found) ? std::nullopt : parse_bool(found->text);
    if (!parsed) report(Rule::boolean_malformed, key, allowed_text(key));
    return parsed;
}

std::optional<double> Reader::number(std::string_view key) {
    const Node* const found = number_scalar(key);
    if (found == nullptr) return std::nullopt;
    const auto parsed = parse_number(found->text);
    if (parsed) return *parsed;
    report_scalar(parsed.error(), field(key), Rule::number_malformed);
    return std::nullopt;
}

std::optional<std::string> Reader::text(std::string_view key) {
    const auto& field = this->field(key);
    const Node* const found = scalar(key);
    if (found == nullptr) return std::nullopt;
    const auto range = field.range(context_);
    const auto length = static_cast<std::int64_t>(count_characters(found->text));
    if (length < range.least || length > range.greatest) {
        report(Rule::field_length, key, bounds(range), {{"length", std::to_string(length)}});
        return std::nullopt;
    }
    if (has_control_character(found->text)) {
        report(Rule::field_control_character, key);
        return std::nullopt;
    }
    return found->text;
}

void Reader::report_unknown_word(const Field& field, std::string_view text) {
    const auto meant = meant_word(field.key, field.words, text);
    if (meant.empty()) return report(Rule::field_unlike_word, field.key, allowed(field, context_));
    report(Rule::field_unknown_word, field.key, allowed(field, context_), {{"nearest", std::string(meant)}});
}

std::optional<std::size_t> Reader::word_index(std::string_view key) {
    const auto& field = this->field(key);
    const Node* const found = scalar(key);
    if (found == nullptr) return std::nullopt;
    const auto at = std::ranges::find(field.words, std::string_view(found->text));
    if (at == field.words.end()) {
        report_unknown_word(field, found->text);
        return std::nullopt;
    }
    const auto index = static_cast<std::size_t>(at - field.words.begin());
    if (field.fits != nullptr && !field.fits(index, context_)) {
        report(Rule::field_not_here, key, allowed(field, context_),
               {{"condition", condition(field, index, context_)}});
        return std::nullopt;
    }
    return index;
}

std::optional<std::string_view> Reader::word(std::string_view key) {
    const auto index = word_index(key);
    if (!index) return std::nullopt;
    return field(key).words[*index];
}

std::optional<FunctionChoice> Reader::function(std::string_view key) {
    const auto& field = this->field(key);
    const Node* const found = scalar(key);
    if (found == nullptr) return std::nullopt;
    if (found->text == field.words[0]) return FunctionChoice{};
    if (number_scalar(key) == nullptr) return std::nullopt;
    const auto parsed = parse_integer(found->text);
    if (!parsed && parsed.error() == ScalarError::leading_zero) {
        report(Rule::integer_leading_zero, key, allowed(field, context_));
        return std::nullopt;
    }
    if (parsed && !parsed->negative)
        for (const auto word : field.words.subspan(1))
            if (parse_integer(word)->magnitude == parsed->magnitude)
                return FunctionChoice{static_cast<wire::Function>(parsed->magnitude)};
    const auto named = parse_integer(function_number(found->text));
    const auto number = parsed ? parsed->magnitude : named ? named->magnitude : 0;
    constexpr std::uint64_t kMask = 0x16;
    constexpr std::uint64_t kReadWrite = 0x17;
    auto arguments = function_arguments(found->text);
    if (key == "write" && (number == kMask || number == kReadWrite))
        arguments = {{"variant", number == kMask ? "mask" : "read_write"}};
    report(Rule::function_not_allowed, key, allowed(field, context_), std::move(arguments));
    return std::nullopt;
}

}  // namespace takt::model
