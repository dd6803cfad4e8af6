#include "tables/cell_words.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>
#include <vector>

#include "tables/headings.hpp"
#include "takt/base/ascii.hpp"
#include "takt/model/byte_order.hpp"
#include "takt/model/fields.hpp"
#include "takt/model/scalar.hpp"

namespace takt::file {
namespace {

// A word as folded() returns it, with its meaning.
struct Word {
    std::string_view text;
    std::string_view meaning;
};

// clang-format off
constexpr Word kNothing[] = {
    {"none", ""}, {"no", ""}, {"нет", ""}, {"немає", ""}, {"ні", ""}, {"отсутствует", ""}, {"відсутня", ""},
};

constexpr Word kTypeWords[] = {
    {"bool", "bool"}, {"boolean", "bool"}, {"bit", "bool"}, {"logical", "bool"}, {"discrete", "bool"},
    {"логическии", "bool"}, {"логическая", "bool"}, {"логическое", "bool"}, {"булевскии", "bool"},
    {"булевское", "bool"}, {"булевская", "bool"}, {"булево", "bool"}, {"логічне", "bool"},
    {"булівське", "bool"}, {"булевыи", "bool"}, {"бит", "bool"},
    {"дискретныи", "bool"}, {"логічнии", "bool"}, {"логічна", "bool"}, {"булевии", "bool"}, {"біт", "bool"},
    {"дискретнии", "bool"}, {"булів", "bool"}, {"булівськии", "bool"},
    {"int", "int16"}, {"integer", "int16"}, {"int16", "int16"}, {"short", "int16"}, {"s16", "int16"},
    {"i16", "int16"},
    {"signed16", "int16"}, {"целочисленныи", "int16"}, {"целочисленная", "int16"}, {"целочисленное", "int16"},
    {"цілочисельне", "int16"}, {"цілочислове", "int16"},
    {"целая", "int16"}, {"целое", "int16"},
    {"целыи", "int16"}, {"цілочисельнии", "int16"}, {"цілочислова", "int16"}, {"цілочисловии", "int16"},
    {"ціле", "int16"}, {"цілии", "int16"}, {"signedinteger", "int16"}, {"знаковоецелое", "int16"},
    {"целоесознаком", "int16"}, {"знаковеціле", "int16"}, {"цілезізнаком", "int16"},
    {"uint", "uint16"}, {"uint16", "uint16"}, {"word", "uint16"}, {"u16", "uint16"}, {"unsigned", "uint16"},
    {"unsignedint", "uint16"}, {"unsignedshort", "uint16"}, {"unsigned16", "uint16"}, {"слово", "uint16"},
    {"беззнаковыи", "uint16"}, {"целочисленныибеззнака", "uint16"}, {"беззнаковии", "uint16"},
    {"цілочисельниибеззнака", "uint16"}, {"unsignedinteger", "uint16"},
    {"беззнаковоецелое", "uint16"}, {"целоебеззнаковое", "uint16"}, {"целоебеззнака", "uint16"},
    {"беззнаковое", "uint16"}, {"целочисленноебеззнака", "uint16"}, {"беззнаковеціле", "uint16"},
    {"цілебеззнакове", "uint16"}, {"цілебеззнака", "uint16"}, {"беззнакове", "uint16"},
    {"цілочисельнебеззнака", "uint16"},
    {"dint", "int32"}, {"int32", "int32"}, {"s32", "int32"}, {"i32", "int32"}, {"signed32", "int32"},
    {"udint", "uint32"}, {"uint32", "uint32"}, {"dword", "uint32"}, {"u32", "uint32"},
    {"unsigned32", "uint32"},
    {"lint", "int64"}, {"int64", "int64"}, {"s64", "int64"}, {"i64", "int64"},
    {"ulint", "uint64"}, {"uint64", "uint64"}, {"lword", "uint64"}, {"u64", "uint64"},
    {"float", "float"}, {"real", "float"}, {"float32", "float"}, {"real32", "float"}, {"single", "float"},
    {"f32", "float"}, {"floatingpoint", "float"}, {"сплавающеизапятои", "float"},
    {"сплавающеиточкои", "float"},
    {"вещественныи", "float"}, {"вещественная", "float"}, {"вещественное", "float"}, {"діисне", "float"},
    {"зплаваючоюкомою", "float"}, {"зплаваючоюточкою", "float"},
    {"зрухомоюкомою", "float"}, {"зрухомоюкрапкою", "float"}, {"зплаваючоюкрапкою", "float"},
    {"діиснии", "float"},
    {"double", "double"}, {"lreal", "double"}, {"float64", "double"}, {"real64", "double"}, {"f64", "double"},
    {"двоинаяточность", "double"}, {"двоиноиточности", "double"}, {"подвіиноіточності", "double"},
    {"string", "string"}, {"text", "string"}, {"строка", "string"}, {"строковыи", "string"},
    {"строковая", "string"},
    {"рядок", "string"}, {"рядковии", "string"}, {"текст", "string"},
};

constexpr std::string_view kRegisterStems[] = {"register", "reg", "регистр", "регістр", "рег"};
constexpr std::pair<std::string_view, int> kCountStems[] = {
    {"1", 1}, {"one", 1}, {"одно", 1}, {"2", 2}, {"two", 2}, {"двух", 2}, {"дво", 2}, {"4", 4}, {"four", 4},
    {"четырех", 4}, {"чотири", 4},
};

constexpr std::array<std::string_view, 5> kFamilies[] = {  // in 1, 2, 3, 4 registers
    {"int16", "int32", "", "int64"}, {"uint16", "uint32", "", "uint64"}, {"", "float", "", "double"},
    {"bool"},
};

constexpr std::pair<std::string_view, int> kFunctionNames[] = {
    {"readcoil", 1}, {"readcoils", 1}, {"readcoilstatus", 1}, {"чтениефлагов", 1}, {"читанняпрапорців", 1},
    {"readdiscreteinput", 2}, {"readdiscreteinputs", 2}, {"readinputstatus", 2},
    {"чтениедискретныхвходов", 2},
    {"читаннядискретнихвходів", 2},
    {"readholdingregister", 3}, {"readholdingregisters", 3}, {"чтениерегистровхранения", 3},
    {"читаннярегістрівзберігання", 3},
    {"readinputregister", 4}, {"readinputregisters", 4}, {"чтениевходныхрегистров", 4},
    {"читаннявхіднихрегістрів", 4},
    {"writesinglecoil", 5}, {"writecoil", 5}, {"forcesinglecoil", 5}, {"записьодногофлага", 5},
    {"записодногопрапорця", 5},
    {"writesingleregister", 6}, {"writeregister", 6}, {"presetsingleregister", 6},
    {"записьодногорегистра", 6},
    {"записодногорегістра", 6},
    {"writemultiplecoils", 15}, {"writecoils", 15}, {"forcemultiplecoils", 15},
    {"записьнесколькихфлагов", 15},
    {"записдекількохпрапорців", 15},
    {"writemultipleregisters", 16}, {"writeregisters", 16}, {"presetmultipleregisters", 16},
    {"записьнесколькихрегистров", 16}, {"записдекількохрегістрів", 16},
};

constexpr Word kBooleans[] = {
    {"true", "true"}, {"yes", "true"}, {"y", "true"}, {"on", "true"}, {"1", "true"}, {"x", "true"},
    {"х", "true"},
    {"да", "true"}, {"вкл", "true"}, {"истина", "true"}, {"так", "true"}, {"істина", "true"},
    {"увімк", "true"},
    {"false", "false"}, {"no", "false"}, {"n", "false"}, {"off", "false"}, {"0", "false"}, {"нет", "false"},
    {"выкл", "false"}, {"ложь", "false"}, {"ні", "false"}, {"хибність", "false"}, {"вимк", "false"},
};

// The check boxes of a window.
constexpr Word kBoxes[] = {
    {"☑", "true"}, {"☒", "true"}, {"✅", "true"}, {"✓", "true"}, {"✔", "true"}, {"■", "true"},
    {"[x]", "true"}, {"[X]", "true"}, {"[х]", "true"}, {"[Х]", "true"}, {"[v]", "true"}, {"[V]", "true"},
    {"☐", "false"}, {"□", "false"}, {"[ ]", "false"}, {"[]", "false"},
};

constexpr Word kAreaWords[] = {
    {"coils", "coil"}, {"coil", "coil"}, {"флаги", "coil"}, {"дискретныевыходы", "coil"},
    {"дискретнівиходи", "coil"},
    {"discreteinputs", "discrete_input"}, {"discreteinput", "discrete_input"},
    {"дискретныевходы", "discrete_input"},
    {"дискретнівходи", "discrete_input"},
    {"inputregisters", "input_register"}, {"inputregister", "input_register"},
    {"входныерегистры", "input_register"}, {"вхіднірегістри", "input_register"},
    {"holdingregisters", "holding_register"}, {"holdingregister", "holding_register"},
    {"регистрыхранения", "holding_register"}, {"регістризберігання", "holding_register"},
};
// clang-format on

// The entry of a list of choices that chooses nothing.
constexpr std::string_view kPlaceholders[] = {"невыбрана", "невыбрано",  "невыбран",    "невибрана",
                                              "невибрано", "невибрании", "notselected", "notchosen"};

template <std::size_t n>
std::string_view meaning(const Word (&words)[n], std::string_view text) {
    const auto* const found = std::ranges::find(words, text, &Word::text);
    return found == std::end(words) ? std::string_view() : found->meaning;
}

bool is_cut(std::string_view text) {
    return text.ends_with("...") || text.ends_with("…");
}

// The meaning of the shortest word that begins with a text.
template <std::size_t n>
std::string_view meaning_of_cut(const Word (&words)[n], std::string_view text) {
    constexpr std::size_t kLeast = std::size_t{2} * 3;  // three Cyrillic letters
    const Word* best = nullptr;
    for (const auto& word : words)
        if (text.size() >= kLeast && word.text.starts_with(text) &&
            (best == nullptr || word.text.size() < best->text.size()))
            best = &word;
    return best == nullptr ? std::string_view() : best->meaning;
}

std::string_view without_blanks(std::string_view text) {
    constexpr std::string_view kBlanks = " \t,;.";
    text.remove_prefix(std::min(text.find_first_not_of(kBlanks), text.size()));
    return text.substr(0, text.find_last_not_of(kBlanks) + 1);
}

// The first check box of a text from an offset.
std::size_t find_box(std::string_view text, std::size_t from) {
    auto first = std::string_view::npos;
    for (const auto& box : kBoxes) first = std::min(first, text.find(box.text, from));
    return first;
}

// `☒ Старшим байтом вперед ☐ Старшим регистром вперед`: the order of the bytes in two registers. Nothing
// if the text has another part.
std::optional<ByteOrder> order_of_boxes(std::string_view text) {
    ByteOrder order;
    bool known = false;
    for (text = without_blanks(text); !text.empty(); known = true) {
        const auto labelled = split_box(text.substr(0, find_box(text, 1)));
        if (!labelled) return std::nullopt;
        const auto key = read_heading(labelled->label).key;
        const bool ticked = labelled->state == "true";
        if (key == "high_byte_first")
            order.high_byte_first = ticked;
        else if (key == "high_register_first")
            order.high_register_first = ticked;
        else
            return std::nullopt;
        text.remove_prefix(std::min(find_box(text, 1), text.size()));
    }
    return known ? std::optional(order) : std::nullopt;
}

template <class Words>
bool holds(const Words& words, std::string_view text) {
    return std::ranges::find(words, text) != std::end(words);
}

bool all_hexadecimal(std::string_view text) {
    return !text.empty() && text.find_first_not_of("0123456789abcdefABCDEF") == std::string_view::npos;
}

std::string_view without_zeros(std::string_view digits) {
    return digits.substr(std::min(digits.find_first_not_of('0'), digits.size() - 1));
}

std::optional<int> parsed(std::string_view digits, int base) {
    int number = 0;
    const auto read = std::from_chars(digits.data(), digits.data() + digits.size(), number, base);
    if (read.ec != std::errc{} || read.ptr != digits.data() + digits.size()) return std::nullopt;
    return number;
}

std::string lower(std::string_view text) {
    std::string result(text);
    for (char& c : result)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c + 0x20);
    return result;
}

// The number of a function in one word: 3, 03, 0x03, 03h, 0F, FC3.
std::optional<int> function_number(std::string_view word) {
    for (const std::string_view prefix : {"fc", "f"})
        if (word.starts_with(prefix) && all_digits(word.substr(prefix.size())))
            return parsed(word.substr(prefix.size()), 10);
    if (word.starts_with("0x")) return parsed(word.substr(2), 16);
    if (all_digits(word)) return parsed(word, 10);
    if (word.ends_with('h') && all_hexadecimal(word.substr(0, word.size() - 1)))
        return parsed(word.substr(0, word.size() - 1), 16);
    if (word.size() == 2 && word[0] == '0' && all_hexadecimal(word)) return parsed(word, 16);
    return std::nullopt;
}

bool is_word_character(char c) {
    return is_digit(c) || (c >= 'a' && c <= 'z') || static_cast<unsigned char>(c) >= 0x80;
}

std::vector<std::string> split_words(std::string_view whole) {
    std::vector<std::string> words;
    const auto text = lower(whole);
    for (std::size_t at = 0; at < text.size();) {
        auto end = at;
        while (end < text.size() && is_word_character(text[end])) ++end;
        if (end > at) words.push_back(folded(std::string_view(text).substr(at, end - at)));
        at = std::max(end, at + 1);
    }
    return words;
}

bool begins_with_register(std::string_view word) {
    return std::ranges::any_of(kRegisterStems, [&](auto stem) { return word.starts_with(stem); });
}

// A type in words, without the count of registers that may be among them: `2-register int`,
// `двухрегистровый целочисленный`, `INT (2 рег.)`. 0: no count.
struct TypeText {
    std::string name;
    int registers = 0;
};

TypeText split_type(std::string_view text) {
    TypeText type;
    const auto words = split_words(text);
    for (std::size_t i = 0; i < words.size(); ++i) {
        const auto word = std::string_view(words[i]);
        const bool counted = std::ranges::any_of(kCountStems, [&](const auto& stem) {
            const auto& [count, registers] = stem;
            if (!word.starts_with(count)) return false;
            const auto rest = word.substr(count.size());
            const bool apart = rest.empty() && i + 1 < words.size() && begins_with_register(words[i + 1]);
            if (!apart && !begins_with_register(rest)) return false;
            if (apart) ++i;
            type.registers = registers;
            return true;
        });
        if (!counted) type.name += word;
    }
    return type;
}

// The parts of a function's description: the numbers in it, and the remaining words.
struct FunctionText {
    std::vector<int> numbers;
    std::string name;
};

FunctionText take_apart(std::string_view text) {
    FunctionText result;
    for (const auto& word : split_words(text)) {
        if (const auto number = function_number(word))
            result.numbers.push_back(*number);
        else
            result.name += word;
    }
    return result;
}

}  // namespace

bool is_placeholder(std::string_view text) {
    while (text.starts_with(' ')) text.remove_prefix(1);
    const auto name = folded(text);
    if (holds(kPlaceholders, std::string_view(name))) return true;
    constexpr std::string_view kBrackets[] = {"<", "‹", "«", "(", "[", "{", "„", "“", "\"", "&lt;"};
    const bool opened =
        std::ranges::any_of(kBrackets, [&](std::string_view bracket) { return text.starts_with(bracket); });
    // Cut within the words, or with a bracket as text: `&lt;`.
    const auto words = text.starts_with("&lt;") ? folded(text.substr(4, text.find("&gt;") - 4)) : name;
    if (opened && holds(kPlaceholders, std::string_view(words))) return true;
    const auto end = text.find_last_not_of(" >›»)]}”“\"");
    const bool cut = end != std::string_view::npos && is_cut(text.substr(0, end + 1));
    return opened && cut && words.size() >= 2 &&
           std::ranges::any_of(kPlaceholders, [&](auto whole) { return whole.starts_with(words); });
}

bool means_nothing(std::string_view text) {
    if (is_placeholder(text)) return true;
    if (text == "-" || text == "--" || text == "–" || text == "—") return true;
    return std::ranges::find(kNothing, std::string_view(folded(text)), &Word::text) != std::end(kNothing);
}

std::optional<std::string> type_word(std::string_view text) {
    if (holds(model::kTypes, text)) return std::nullopt;
    const auto [name, registers] = split_type(text);
    const auto type = is_cut(text) ? meaning_of_cut(kTypeWords, name) : meaning(kTypeWords, name);
    if (type.empty()) return std::nullopt;
    if (registers == 0) return std::string(type);
    const auto sized = type_of_registers(type, registers);
    if (!sized) return std::nullopt;
    return std::string(*sized);
}

std::optional<std::string_view> type_of_registers(std::string_view type, int registers) {
    if (type == "int") type = "int16";
    if (type == "real") type = "float";
    for (const auto& family : kFamilies)
        if (!type.empty() && holds(family, type) && registers >= 1 && registers <= 4) {
            const auto sized = family[static_cast<std::size_t>(registers - 1)];
            if (!sized.empty()) return sized;
        }
    return std::nullopt;
}

std::optional<std::string> function_word(std::string_view text) {
    if (text == "none" || model::parse_integer(text)) return std::nullopt;
    if (means_nothing(text)) return "none";
    auto [numbers, name] = take_apart(text);
    const auto* const named =
        std::ranges::find(kFunctionNames, std::string_view(name), &std::pair<std::string_view, int>::first);
    if (named != std::end(kFunctionNames)) numbers.push_back(named->second);
    if (numbers.empty() || std::ranges::count(numbers, numbers[0]) != std::ssize(numbers))
        return std::nullopt;
    return fmt::format("0x{:02X}", numbers[0]);
}

std::optional<std::string> boolean_word(std::string_view text) {
    if (model::parse_bool(text)) return std::nullopt;
    if (text == "+") return "true";
    if (const auto box = meaning(kBoxes, text); !box.empty()) return std::string(box);
    if (text == "-" || text == "–" || text == "—") return "false";
    const auto found = meaning(kBooleans, folded(text));
    if (found.empty()) return std::nullopt;
    return std::string(found);
}

std::optional<LabelledBox> split_box(std::string_view text) {
    text = without_blanks(text);
    for (const auto& box : kBoxes) {
        if (text.starts_with(box.text))
            return LabelledBox{box.meaning, without_blanks(text.substr(box.text.size()))};
        if (text.ends_with(box.text))
            return LabelledBox{box.meaning, without_blanks(text.substr(0, text.size() - box.text.size()))};
    }
    return std::nullopt;
}

std::optional<std::string> byte_order_word(std::string_view text) {
    const auto digits = text.substr(text.find_first_of(':') + 1);  // npos + 1 is 0
    const auto permutation = model::parse_byte_order(digits);
    if (!permutation) {
        const auto order = order_of_boxes(text);
        if (!order) return std::nullopt;
        return std::string(model::byte_order_text(*order, 2));
    }
    std::string word(digits);
    std::erase(word, ' ');
    if (word == text) return std::nullopt;
    return word;
}

std::optional<std::string> area_word(std::string_view text) {
    if (holds(model::kAreas, text)) return std::nullopt;
    const auto found = meaning(kAreaWords, folded(text));
    if (found.empty()) return std::nullopt;
    return std::string(found);
}

std::optional<std::string> address_word(std::string_view text, bool hexadecimal) {
    auto digits = text;
    if (text.ends_with('h') || text.ends_with('H'))
        digits.remove_suffix(1);
    else if (!hexadecimal)
        return std::nullopt;
    if (!all_hexadecimal(digits)) return std::nullopt;
    return "0x" + std::string(without_zeros(digits));
}

std::optional<std::string> reference_word(std::string_view text) {
    constexpr std::size_t kDigits = 5;
    if (!all_digits(text) || text.size() >= kDigits) return std::nullopt;
    return std::string(kDigits - text.size(), '0').append(text);
}

std::optional<std::string> duration_word(std::string_view text, std::string_view unit, bool decimal_comma) {
    if (model::parse_duration(text) && (text != "0" || unit.empty())) return std::nullopt;
    const auto end = std::min(text.find_first_not_of("0123456789.,"), text.size());
    const auto written = time_unit(text.substr(end));
    if (end < text.size() && written.empty()) return std::nullopt;
    auto number = std::string(text.substr(0, end));
    if (decimal_comma) std::ranges::replace(number, ',', '.');
    number.append(end < text.size() ? written : unit);
    if (!model::parse_duration(number)) return std::nullopt;
    return number;
}

std::optional<std::string> number_word(std::string_view text) {
    if (std::ranges::count(text, ',') != 1 || text.find('.') != std::string_view::npos) return std::nullopt;
    std::string number(text);
    std::ranges::replace(number, ',', '.');
    if (!model::parse_number(number)) return std::nullopt;
    return number;
}

std::optional<std::string> ungrouped_word(std::string_view text) {
    constexpr std::array<std::string_view, 4> kBlanks{" ", "\u00A0", "\u202F", "\u2009"};
    constexpr std::size_t kGroup = 3;
    std::size_t at = text.starts_with('-') ? 1 : 0;
    const auto digits_at = [&](std::size_t from) {
        return std::min(text.find_first_not_of("0123456789", from), text.size()) -
               std::min(from, text.size());
    };
    if (const auto first = digits_at(at); first == 0 || first > kGroup) return std::nullopt;
    at += digits_at(at);
    std::string word(text.substr(0, at));
    for (;;) {
        const auto* const blank = std::ranges::find_if(
            kBlanks, [&](std::string_view its) { return text.substr(at).starts_with(its); });
        if (blank == kBlanks.end() || digits_at(at + blank->size()) != kGroup) break;
        word += text.substr(at + blank->size(), kGroup);
        at += blank->size() + kGroup;
    }
    if (word.size() == at) return std::nullopt;
    return word.append(text.substr(at));
}

}  // namespace takt::file
