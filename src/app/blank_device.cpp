#include "blank_device.hpp"

#include <algorithm>
#include <charconv>
#include <span>
#include <utility>

namespace takt::app {
namespace {

constexpr std::int64_t kLastItem = 65535;
constexpr std::array<std::pair<std::string_view, wire::Area>, 4> kAreaWords{
    {{"coils", wire::Area::coil},
     {"discrete", wire::Area::discrete_input},
     {"input", wire::Area::input_register},
     {"holding", wire::Area::holding_register}}};

/// The two sides of a separator; nothing: it is not there.
std::optional<std::pair<std::string_view, std::string_view>> split(std::string_view text,
                                                                   std::string_view separator) {
    const auto at = text.find(separator);
    if (at == std::string_view::npos) return std::nullopt;
    return std::pair{text.substr(0, at), text.substr(at + separator.size())};
}

std::optional<std::int64_t> number(std::string_view text, std::int64_t least, std::int64_t greatest) {
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
    const auto sides = split(text, "..").value_or(std::pair{text, text});
    const auto first = number(sides.first, least, greatest);
    const auto last = number(sides.second, least, greatest);
    if (!first || !last || *first > *last) return std::nullopt;
    return std::pair{*first, *last};
}

/// Sorted, without overlaps.
std::vector<serve::AddressRange> in_order(std::vector<serve::AddressRange> ranges) {
    std::ranges::sort(ranges, {}, &serve::AddressRange::first);
    std::vector<serve::AddressRange> merged;
    for (const auto range : ranges) {
        if (!merged.empty() && range.first <= merged.back().last)
            merged.back().last = std::max(merged.back().last, range.last);
        else
            merged.push_back(range);
    }
    return merged;
}

auto by_area(const std::vector<BlankLayout::Range>& ranges) {
    std::array<std::vector<serve::AddressRange>, 4> areas;
    for (const auto& [area, addresses] : ranges) areas[static_cast<std::size_t>(area)].push_back(addresses);
    for (auto& area : areas) area = in_order(std::move(area));
    return areas;
}

}  // namespace

std::optional<BlankLayout::Range> parse_item_range(std::string_view text) {
    const auto sides = split(text, ":");
    if (!sides) return std::nullopt;
    const auto word =
        std::ranges::find(kAreaWords, sides->first, [](const auto& area) { return area.first; });
    const auto items = bounds(sides->second, 0, kLastItem);
    if (word == kAreaWords.end() || !items) return std::nullopt;
    return BlankLayout::Range{
        word->second, {static_cast<std::uint16_t>(items->first), static_cast<std::uint16_t>(items->second)}};
}

std::optional<BlankLayout::Limit> parse_value_limits(std::string_view text) {
    const auto sides = split(text, "=");
    if (!sides) return std::nullopt;
    const auto range = parse_item_range(sides->first);
    const auto values = bounds(sides->second, -32768, kLastItem);
    if (!range || !values || range->area != wire::Area::holding_register) return std::nullopt;
    if (values->first < 0 && values->second > 32767) return std::nullopt;
    return BlankLayout::Limit{range->addresses, static_cast<std::int32_t>(values->first),
                              static_cast<std::int32_t>(values->second)};
}

std::optional<BlankLayout::File> parse_file_records(std::string_view text) {
    const auto sides = split(text, ":");
    if (!sides) return std::nullopt;
    const auto file = number(sides->first, 1, kLastItem);
    const auto records = number(sides->second, 1, serve::File::kMostRecords);
    if (!file || !records) return std::nullopt;
    return BlankLayout::File{static_cast<std::uint16_t>(*file), static_cast<std::uint16_t>(*records)};
}

std::optional<BlankLayout::Fifo> parse_fifo(std::string_view text) {
    const auto sides = split(text, ":");
    if (!sides) return std::nullopt;
    const auto address = number(sides->first, 0, kLastItem);
    if (!address) return std::nullopt;
    BlankLayout::Fifo fifo{static_cast<std::uint16_t>(*address), {}};
    std::string_view rest = sides->second;
    while (!rest.empty()) {
        const auto [one, more] = split(rest, ",").value_or(std::pair{rest, std::string_view()});
        const auto value = number(one, 0, kLastItem);
        if (!value || fifo.values.size() == serve::Fifos::kMostValues) return std::nullopt;
        fifo.values.push_back(static_cast<std::uint16_t>(*value));
        rest = more;
    }
    return fifo;
}

std::optional<BlankLayout::Object> parse_object(std::string_view text) {
    const auto sides = split(text, "=");
    if (!sides || sides->second.size() > serve::IdentificationObject::kMostText) return std::nullopt;
    const auto id = number(sides->first, 0, 255);
    if (!id) return std::nullopt;
    return BlankLayout::Object{static_cast<std::uint8_t>(*id), std::string(sides->second)};
}

BlankDevice::BlankDevice(const ServeOptions& options)
    : layout_(options.blank),
      devices_(UnitId{options.unit}, options.fill),
      offered_(by_area(layout_.ranges)),
      read_only_(by_area(layout_.read_only)),
      functions_({layout_.may_restart, layout_.may_listen_only, layout_.status_coils}) {
    for (const auto& [addresses, least, greatest] : layout_.limits)
        limits_[static_cast<std::size_t>(wire::Area::holding_register)].push_back(
            {addresses, least, greatest});
    identify();
    fill_files(options.fill);
    for (const auto& [address, values] : layout_.fifos) functions_.add_fifo(address, values);
    lay_out(*devices_.unit(UnitId{options.unit}));
}

void BlankDevice::lay_out(serve::Unit& unit) {
    unit.extensions = functions_.extensions(true);
    for (const wire::Area area : {wire::Area::coil, wire::Area::discrete_input}) {
        unit.banks.bits(area).offered = offered_[static_cast<std::size_t>(area)];
        unit.banks.bits(area).read_only = read_only_[static_cast<std::size_t>(area)];
    }
    for (const wire::Area area : {wire::Area::input_register, wire::Area::holding_register}) {
        unit.banks.registers(area).offered = offered_[static_cast<std::size_t>(area)];
        unit.banks.registers(area).read_only = read_only_[static_cast<std::size_t>(area)];
        unit.banks.registers(area).limits = limits_[static_cast<std::size_t>(area)];
    }
    if (layout_.overlay) unit.banks.coils.overlay = serve::BitOverlay{};
}

std::array<std::vector<serve::AddressRange>, 4> BlankDevice::retained() const {
    return by_area(layout_.retain);
}

void BlankDevice::identify() {
    if (layout_.objects.empty()) layout_.objects = {{0, "Takt"}, {1, "takt serve"}, {2, "1"}};
    std::ranges::stable_sort(layout_.objects, {}, &BlankLayout::Object::id);
    const auto same = [](const auto& one, const auto& other) { return one.id == other.id; };
    const auto surplus = std::ranges::unique(layout_.objects, same);  // of equal ids the first counts
    layout_.objects.erase(surplus.begin(), surplus.end());
    for (const auto& [id, text] : layout_.objects) functions_.add_object(id, text);
    functions_.set_server_id(devices_.units().front().id, layout_.server_id);
}

void BlankDevice::fill_files(sim::Fill fill) {
    for (const auto& [number, count] : layout_.files) {
        const auto records = functions_.add_file(number, count);
        for (std::size_t i = 0; fill == sim::Fill::ramp && i < records.size(); ++i)
            records[i] = static_cast<std::uint16_t>(i);
    }
}

}  // namespace takt::app
