// write: values to one device, in as many requests as it takes.
#include <algorithm>
#include <span>
#include <string>
#include <vector>

#include "one_off.hpp"
#include "takt/app/client_commands.hpp"
#include "takt/app/console.hpp"
#include "takt/value/codec.hpp"
#include "takt/value/text.hpp"
#include "takt/wire/pdu.hpp"

namespace takt::app {
namespace {

using wire::Area;
using wire::Function;

/// The items to be written, in the order of their addresses; those of one value are never parted.
struct Items {
    std::vector<bool> bits;
    std::vector<std::uint16_t> registers;
    std::vector<std::size_t> value_ends;  // items up to the end of each value

    [[nodiscard]] std::size_t size() const { return bits.size() + registers.size(); }
};

Result<Items> items_of(const WriteOptions& options) {
    Items items;
    for (const auto& text : options.values) {
        if (options.area == Area::coil) {
            TAKT_TRY(const auto value, value::parse(DataType::boolean, false, text));
            items.bits.push_back(std::get<bool>(value));
        } else {
            TAKT_TRY(const auto value, value::parse(options.type, false, text));
            const auto string_registers =
                static_cast<std::uint16_t>(std::clamp<std::size_t>((text.size() + 1) / 2, 1, 123));
            TAKT_TRY(const auto encoded, value::encode({.type = options.type,
                                                        .order = options.order,
                                                        .registers = string_registers,
                                                        .bit = {},
                                                        .scale = 1,
                                                        .offset = 0},
                                                       value));
            items.registers.insert(items.registers.end(), encoded.registers.begin(), encoded.registers.end());
        }
        items.value_ends.push_back(items.size());
    }
    return items;
}

/// Where the request that begins with item `begin` ends: behind as many values as it holds.
std::size_t part_end(const Items& items, std::size_t begin, std::size_t most) {
    const auto beyond = std::ranges::upper_bound(items.value_ends, begin + most);
    return beyond == items.value_ends.begin() ? begin : *(beyond - 1);
}

wire::Request request_of(const WriteOptions& options, const Items& items, std::size_t begin,
                         std::size_t end) {
    const DataAddress start{static_cast<std::uint16_t>(options.start + begin)};
    const bool single = items.size() == 1 && !options.multiple;
    if (options.area == Area::coil) {
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

wire::Function first_function(const WriteOptions& options, const Items& items) {
    return wire::function_of(
        request_of(options, items, 0, items.value_ends.empty() ? 0 : items.value_ends[0]));
}

/// What a write came to.
struct Written {
    wire::Function function{};
    std::size_t items = 0;  ///< confirmed, from the first on
    Result<void> ended;
};

Written write_all(Client& client, const WriteOptions& options, const Items& items) {
    const auto function =
        options.area == Area::coil ? Function::write_multiple_coils : Function::write_multiple_registers;
    const std::size_t most = wire::max_items(wire::Framing::tcp, function);
    Written written;
    while (written.items < items.size()) {
        const std::size_t end = part_end(items, written.items, most);
        const auto request = request_of(options, items, written.items, end);
        written.function = wire::function_of(request);
        written.ended = client.order(request);
        if (!written.ended) return written;
        written.items = end;
    }
    return written;
}

// What was sent and not answered may have been done.
const char* outcome_name(const Written& written) {
    if (written.ended) return "done";
    if (written.items > 0) return "partly";
    switch (written.ended.error().code) {
        case Code::modbus_exception:
        case Code::cannot_open:
        case Code::busy: return "refused";
        default: return "unknown";
    }
}

file::Json write_json(const WriteOptions& options, const Items& items, const Written& written,
                      Duration time) {
    auto object = object_of(options);
    object.set("function", static_cast<int>(written.function));
    object.set("start", options.start);
    object.set("quantity", static_cast<std::uint64_t>(written.items));
    object.set("outcome", outcome_name(written));
    if (!written.ended) object.set("wanted", static_cast<std::uint64_t>(items.size()));
    object.set("time_ms", static_cast<double>(time.count()) / 1e6);
    return object;
}

}  // namespace

ExitCode write(const CommonOptions& common, const WriteOptions& options) {
    const Texts texts(common.language);
    if (options.area != Area::coil && options.area != Area::holding_register) {
        print_error(texts("app.read_only_area"));
        return ExitCode::usage;
    }
    if (is_for_registers(texts, options.area, options.registers_only)) return ExitCode::usage;
    const auto items = items_of(options);
    if (!items) return bad_arguments(texts, items.error());
    if (is_beyond(texts, options.start, items->size())) return ExitCode::usage;
    auto client = Client::open(options);
    if (!client) {
        const Written nothing{.function = first_function(options, *items),
                              .ended = std::unexpected(client.error())};
        return ended_by(texts, options, nullptr, client.error(), write_json(options, *items, nothing, {}));
    }
    const Instant begin = line::now();
    const auto written = write_all(**client, options, *items);
    auto object = write_json(options, *items, written, line::now() - begin);
    const Texts::Arguments counts{{"count", std::to_string(written.items)},
                                  {"total", std::to_string(items->size())},
                                  {"start", std::to_string(options.start)},
                                  {"next", std::to_string(options.start + written.items)}};
    if (written.ended) {
        if (options.json)
            print(object.dump() + "\n");
        else
            print_status(texts("app.written", counts) + "\n");
        return ExitCode::ok;
    }
    const ExitCode code = ended_by(texts, options, client->get(), written.ended.error(), std::move(object),
                                   "app.client.write_interrupted");
    if (written.items == 0) return code;
    print_error(texts("app.partly_written", counts));
    return ExitCode::partly;
}

}  // namespace takt::app
