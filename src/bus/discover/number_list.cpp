#include "takt/bus/number_list.hpp"

#include <algorithm>
#include <optional>
#include <string_view>

#include "discover/decimal.hpp"
#include "takt/model/fields.hpp"

namespace takt::bus {
namespace {

struct NumberRange {
    std::uint32_t first;
    std::uint32_t last;
};

std::unexpected<Error> unreadable_number(std::string_view part) {
    constexpr std::size_t kShown = 40;
    return fail(Code::syntax, part.substr(0, kShown));
}

/// Removes the text up to the next comma, and the comma, from `text`. False at the end of the list.
bool next_part(std::optional<std::string_view>& text, std::string_view& part) {
    if (!text) return false;
    const auto comma = text->find(',');
    part = text->substr(0, comma);
    if (comma == std::string_view::npos)
        text.reset();
    else
        text->remove_prefix(comma + 1);
    return true;
}

/// "16" or "20-25".
std::optional<NumberRange> parse_range(std::string_view part) {
    const auto dash = part.find('-');
    const auto first = parse_decimal(part.substr(0, dash));
    const auto last = dash == std::string_view::npos ? first : parse_decimal(part.substr(dash + 1));
    if (!first || !last || *last < *first) return std::nullopt;
    return NumberRange{*first, *last};
}

Result<void> append_range(std::vector<std::uint32_t>& numbers, const NumberRange& range) {
    for (std::uint32_t value = range.first; value <= range.last; ++value) {
        if (std::ranges::find(numbers, value) != numbers.end()) continue;
        if (numbers.size() == kMaxListed)
            return fail(Code::too_long, range.last - range.first + 1, kMaxListed);
        numbers.push_back(value);
    }
    return {};
}

}  // namespace

Result<std::vector<std::uint32_t>> parse_numbers(std::string_view text, std::uint32_t least,
                                                 std::uint32_t greatest) {
    std::vector<std::uint32_t> numbers;
    std::optional<std::string_view> rest = text;
    for (std::string_view part; next_part(rest, part);) {
        const auto range = parse_range(part);
        if (!range) return unreadable_number(part);
        for (const auto bound : {range->first, range->last})
            if (bound < least || bound > greatest) return fail(Code::out_of_range, bound, least, greatest);
        TAKT_CHECK(append_range(numbers, *range));
    }
    return numbers;
}

Result<std::vector<wire::Parity>> parse_parities(std::string_view text) {
    std::vector<wire::Parity> parities;
    std::optional<std::string_view> rest = text;
    for (std::string_view part; next_part(rest, part);) {
        const auto known = std::ranges::find(model::kParities, part);
        if (known == model::kParities.end()) return unreadable_number(part);
        const auto parity = static_cast<wire::Parity>(known - model::kParities.begin());
        if (std::ranges::find(parities, parity) == parities.end()) parities.push_back(parity);
    }
    return parities;
}

}  // namespace takt::bus
