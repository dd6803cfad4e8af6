#include <algorithm>
#include <span>

#include "takt/client/values.hpp"
#include "takt/value/text.hpp"

namespace takt::client {
namespace {

using wire::Area;

/// The items to be written, in the order of their addresses.
struct Items {
    std::vector<bool> bits;
    std::vector<std::uint16_t> registers;
    std::vector<std::size_t> value_ends;  // items up to the end of each value

    [[nodiscard]] std::size_t size() const { return bits.size() + registers.size(); }
};

Result<Items> items_of(const WriteSpec& spec) {
    Items items;
    for (const auto& text : spec.values) {
        if (spec.area == Area::coil) {
            TAKT_TRY(const auto value, value::parse(DataType::boolean, false, text));
            items.bits.push_back(std::get<bool>(value));
        } else {
            TAKT_TRY(const auto value, value::parse(spec.layout.type, false, text));
            auto layout = spec.layout;
            layout.registers =
                static_cast<std::uint16_t>(std::clamp<std::size_t>((text.size() + 1) / 2, 1, 123));
            TAKT_TRY(const auto encoded, value::encode(layout, value));
            items.registers.insert(items.registers.end(), encoded.registers.begin(), encoded.registers.end());
        }
        items.value_ends.push_back(items.size());
    }
    return items;
}

/// The end of the request that begins with item `begin`: behind as many values as it holds.
std::size_t part_end(const Items& items, std::size_t begin, std::size_t most) {
    const auto beyond = std::ranges::upper_bound(items.value_ends, begin + most);
    return beyond == items.value_ends.begin() ? begin : *(beyond - 1);
}

wire::Request request_of(const WriteSpec& spec, const Items& items, std::size_t begin, std::size_t end) {
    const DataAddress start{static_cast<std::uint16_t>(spec.start + begin)};
    const bool single = items.size() == 1 && !spec.multiple;
    if (spec.area == Area::coil) {
        if (single) return wire::WriteSingleCoilRequest{start, items.bits[0]};
        wire::WriteMultipleCoilsRequest request{start, {}};
        for (std::size_t i = begin; i < end; ++i) request.values.push_back(items.bits[i]);
        return request;
    }
    if (single) return wire::WriteSingleRegisterRequest{start, items.registers[0]};
    wire::WriteMultipleRegistersRequest request{start, {}};
    request.values.assign(std::span(items.registers).subspan(begin, end - begin));
    return request;
}

}  // namespace

Result<std::vector<WritePart>> write_parts(const WriteSpec& spec) {
    TAKT_TRY(const auto items, items_of(spec));
    const auto function = wire::write_function(spec.area == Area::coil, false);
    const std::size_t most = wire::max_items(wire::Framing::tcp, function);
    std::vector<WritePart> parts;
    for (std::size_t begin = 0; begin < items.size();) {
        const std::size_t end = part_end(items, begin, most);
        parts.push_back({request_of(spec, items, begin, end), end});
        begin = end;
    }
    return parts;
}

Written write_values(Client& client, const std::vector<WritePart>& parts) {
    Written written;
    for (const auto& [request, end] : parts) {
        written.function = wire::function_of(request);
        written.ended = client.order(request);
        if (!written.ended) break;
        written.items = end;
    }
    return written;
}

// A request that was sent and not answered may have been executed.
std::string_view Written::outcome() const {
    if (ended) return "done";
    if (items > 0) return "partly";
    switch (ended.error().code) {
        case Code::modbus_exception:
        case Code::cannot_open:
        case Code::busy: return "refused";
        default: return "unknown";
    }
}

}  // namespace takt::client
