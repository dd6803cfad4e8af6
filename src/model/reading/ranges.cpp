// Ranges of items: 7, 0..99, 0-99, 0x10..0x1F, [0, 99]; for all areas, or by area.
#include <algorithm>
#include <expected>
#include <utility>

#include "servers/interpretation.hpp"
#include "takt/base/ascii.hpp"

namespace takt::model {
namespace {

constexpr std::uint64_t kLastItem = 65535;
constexpr auto* kRangeForms = "7, 0..99, 0-99, 0x10..0x1F, [0, 99]";

std::expected<std::uint16_t, Rule> parse_bound(std::string_view text) {
    const auto parsed = parse_integer(trimmed(text));
    if (parsed && !parsed->negative && parsed->magnitude <= kLastItem)
        return static_cast<std::uint16_t>(parsed->magnitude);
    if (parsed || parsed.error() == ScalarError::too_large) return std::unexpected(Rule::field_out_of_range);
    return std::unexpected(parsed.error() == ScalarError::leading_zero ? Rule::integer_leading_zero
                                                                       : Rule::range_malformed);
}

std::expected<ItemRange, Rule> parse_bounds(std::string_view first, std::string_view last) {
    const auto least = parse_bound(first);
    const auto greatest = parse_bound(last);
    if (!least) return std::unexpected(least.error());
    if (!greatest) return std::unexpected(greatest.error());
    if (*least > *greatest) return std::unexpected(Rule::range_reversed);
    return ItemRange{*least, *greatest};
}

std::expected<ItemRange, Rule> parse_text(std::string_view text) {
    for (const std::string_view separator : {"..", "-"}) {
        const auto at = text.find(separator, 1);  // the first character may be a sign
        if (at != std::string_view::npos)
            return parse_bounds(text.substr(0, at), text.substr(at + separator.size()));
    }
    return parse_bounds(text, text);
}

std::expected<ItemRange, Rule> parse_item(const Node& item) {
    if (item.kind == Node::Kind::scalar) return parse_text(item.text);
    const auto is_scalar = [](const Node& bound) { return bound.kind == Node::Kind::scalar; };
    if (item.kind != Node::Kind::list || item.items.size() != 2 ||
        !std::ranges::all_of(item.items, is_scalar))
        return std::unexpected(Rule::range_malformed);
    return parse_bounds(item.items[0].text, item.items[1].text);
}

/// An item as it is named in a finding.
std::string item_text(const Node& item) {
    constexpr std::size_t kMost = 3;
    if (item.kind == Node::Kind::mapping) return "{...}";
    if (item.kind != Node::Kind::list) return item.text;
    std::string all;
    for (std::size_t i = 0; i < std::min(item.items.size(), kMost); ++i)
        all.append(all.empty() ? "" : ", ").append(item.items[i].text);
    return "[" + all + (item.items.size() > kMost ? ", ...]" : "]");
}

void merge(std::vector<ItemRange>& ranges) {
    std::ranges::sort(ranges, {}, &ItemRange::first);
    std::size_t kept = 0;
    for (const auto range : ranges) {
        if (kept > 0 && range.first <= ranges[kept - 1].last + 1)
            ranges[kept - 1].last = std::max(ranges[kept - 1].last, range.last);
        else
            ranges[kept++] = range;
    }
    ranges.resize(kept);
}

}  // namespace

std::vector<ItemRange> read_item_ranges(Interpretation& state, Reader& reader, std::string_view key) {
    std::vector<ItemRange> ranges;
    const Node* const list = reader.list(key);
    if (list == nullptr) return ranges;
    if (list->items.empty()) reader.report(Rule::field_empty, key, {}, {{"key", std::string(key)}});
    for (std::size_t i = 0; i < list->items.size(); ++i) {
        const auto& item = list->items[i];
        const auto range = parse_item(item);
        if (range)
            ranges.push_back(*range);
        else
            state.findings.add(
                range.error(), item.location, reader.path_of(key) + "[" + std::to_string(i) + "]",
                item_text(item),
                range.error() == Rule::range_malformed ? kRangeForms : reader.allowed_text(key));
    }
    merge(ranges);
    return ranges;
}

AreaRanges read_ranges(Interpretation& state, Reader& reader, std::string_view key) {
    AreaRanges ranges;
    if (!reader.is_mapping(key)) {
        ranges.fill(read_item_ranges(state, reader, key));
        return ranges;
    }
    Reader areas(state.findings, *reader.value(key), reader.path_of(key), Object::areas, state.context);
    for (std::size_t area = 0; area < kAreas.size(); ++area)
        ranges[area] = read_item_ranges(state, areas, kAreas[area]);
    return ranges;
}

}  // namespace takt::model
