#include "options/blank_options.hpp"

#include <charconv>
#include <string>
#include <utility>

#include "options/shared_options.hpp"
#include "takt/serve/fifos.hpp"
#include "takt/serve/files.hpp"
#include "takt/serve/identification.hpp"

namespace takt::app {
namespace {

constexpr std::int64_t kLastItem = 65535;

/// The two sides of a separator; nothing: it is not there.
std::optional<std::pair<std::string_view, std::string_view>> split_once(std::string_view text,
                                                                        std::string_view separator) {
    const auto at = text.find(separator);
    if (at == std::string_view::npos) return std::nullopt;
    return std::pair{text.substr(0, at), text.substr(at + separator.size())};
}

std::optional<std::int64_t> number_within(std::string_view text, std::int64_t least, std::int64_t greatest) {
    const bool hexadecimal = text.starts_with("0x") || text.starts_with("0X");
    if (hexadecimal) text.remove_prefix(2);
    if (hexadecimal && text.starts_with('-')) return std::nullopt;
    std::int64_t value = 0;
    const auto [end, error] =
        std::from_chars(text.data(), text.data() + text.size(), value, hexadecimal ? 16 : 10);
    if (error != std::errc() || end != text.data() + text.size() || value < least || value > greatest)
        return std::nullopt;
    return value;
}

/// "5..9", or "7" for both.
std::optional<std::pair<std::int64_t, std::int64_t>> bounds(std::string_view text, std::int64_t least,
                                                            std::int64_t greatest) {
    const auto sides = split_once(text, "..").value_or(std::pair{text, text});
    const auto first = number_within(sides.first, least, greatest);
    const auto last = number_within(sides.second, least, greatest);
    if (!first || !last || *first > *last) return std::nullopt;
    return std::pair{*first, *last};
}

}  // namespace

std::optional<BlankSpec::Range> parse_item_range(std::string_view text) {
    const auto sides = split_once(text, ":");
    if (!sides) return std::nullopt;
    const auto word = kAreas.find(std::string(sides->first));
    const auto items = bounds(sides->second, 0, kLastItem);
    if (word == kAreas.end() || !items) return std::nullopt;
    return BlankSpec::Range{
        word->second, {static_cast<std::uint16_t>(items->first), static_cast<std::uint16_t>(items->second)}};
}

std::optional<BlankSpec::Limit> parse_value_limits(std::string_view text) {
    const auto sides = split_once(text, "=");
    if (!sides) return std::nullopt;
    const auto range = parse_item_range(sides->first);
    const auto values = bounds(sides->second, -32768, kLastItem);
    if (!range || !values || range->area != wire::Area::holding_register) return std::nullopt;
    if (values->first < 0 && values->second > 32767) return std::nullopt;
    return BlankSpec::Limit{range->addresses, static_cast<std::int32_t>(values->first),
                            static_cast<std::int32_t>(values->second)};
}

std::optional<BlankSpec::File> parse_file_records(std::string_view text) {
    const auto sides = split_once(text, ":");
    if (!sides) return std::nullopt;
    const auto file = number_within(sides->first, 1, kLastItem);
    const auto records = number_within(sides->second, 1, serve::File::kMostRecords);
    if (!file || !records) return std::nullopt;
    return BlankSpec::File{static_cast<std::uint16_t>(*file), static_cast<std::uint16_t>(*records)};
}

std::optional<BlankSpec::Fifo> parse_fifo(std::string_view text) {
    const auto sides = split_once(text, ":");
    if (!sides) return std::nullopt;
    const auto address = number_within(sides->first, 0, kLastItem);
    if (!address) return std::nullopt;
    BlankSpec::Fifo fifo{static_cast<std::uint16_t>(*address), {}};
    std::string_view rest = sides->second;
    while (!rest.empty()) {
        const auto [one, more] = split_once(rest, ",").value_or(std::pair{rest, std::string_view()});
        const auto value = number_within(one, 0, kLastItem);
        if (!value || fifo.values.size() == serve::Fifos::kMostValues) return std::nullopt;
        fifo.values.push_back(static_cast<std::uint16_t>(*value));
        rest = more;
    }
    return fifo;
}

std::optional<BlankSpec::Object> parse_object(std::string_view text) {
    const auto sides = split_once(text, "=");
    if (!sides || sides->second.size() > serve::IdentificationObject::kMostText) return std::nullopt;
    const auto id = number_within(sides->first, 0, 255);
    if (!id) return std::nullopt;
    return BlankSpec::Object{static_cast<std::uint8_t>(*id), std::string(sides->second)};
}

}  // namespace takt::app
