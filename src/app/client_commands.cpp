// read, write, raw: one device asked once.
#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <string>
#include <vector>

#include "takt/app/areas.hpp"
#include "takt/app/client.hpp"
#include "takt/app/commands.hpp"
#include "takt/app/texts.hpp"
#include "takt/app/value_json.hpp"
#include "takt/file/json.hpp"
#include "takt/value/codec.hpp"
#include "takt/value/text.hpp"
#include "takt/wire/words.hpp"

namespace takt::app {
namespace {

using wire::Area;
using wire::Function;

ExitCode ended_by(const Texts& texts, const Client* client, const Error& error) {
    if (client && client->interrupted()) return ExitCode::timed_out;
    texts.complain(texts.describe(error));
    return exit_code(error);
}

/// Arguments that cannot be sent, whatever is wrong with them.
ExitCode bad_arguments(const Texts& texts, const Error& error) {
    texts.complain(texts.describe(error));
    return ExitCode::usage;
}

struct ReadValue {
    std::uint16_t address;
    value::Value value;
};

value::Layout layout_of(const ReadOptions& options) {
    return {.type = options.type,
            .order = options.order,
            .registers = options.string_registers,
            .bit = {},
            .scale = 1,
            .offset = 0};
}

/// Reads `count` values beginning with item `start` in one request, behind what is in `values`.
Result<void> read_chunk(Client& client, const ReadOptions& options, std::uint16_t start, std::uint16_t items,
                        std::vector<ReadValue>& values) {
    TAKT_TRY(const auto response,
             client.ask(wire::ReadRequest{read_function(options.area), DataAddress{start}, items}));
    if (const auto* bits = std::get_if<wire::ReadBitsResponse>(&response)) {
        for (std::uint16_t i = 0; i < items; ++i)
            values.push_back({static_cast<std::uint16_t>(start + i), value::Value(bits->values[i])});
        return {};
    }
    const auto* registers = std::get_if<wire::ReadRegistersResponse>(&response);
    if (!registers) return fail(Code::unexpected_reply, options.target);
    const auto layout = layout_of(options);
    const auto size = static_cast<std::size_t>(layout.register_count());
    for (std::size_t i = 0; i + size <= registers->values.size(); i += size) {
        TAKT_TRY(auto value, value::decode(layout, registers->values.span().subspan(i, size)));
        values.push_back({static_cast<std::uint16_t>(start + i), std::move(value)});
    }
    return {};
}

/// Reads everything that was asked for, in as many requests as it takes; what was read before an error stays
/// in `values`.
Result<void> read_all(Client& client, const ReadOptions& options, std::vector<ReadValue>& values) {
    const bool bits = is_bit_area(options.area);
    const std::uint32_t size = bits ? 1 : static_cast<std::uint32_t>(layout_of(options).register_count());
    const auto limit =
        static_cast<std::uint32_t>(wire::max_items(wire::Framing::tcp, read_function(options.area)));
    const std::uint32_t most = limit / size * size;
    for (std::uint32_t done = 0, total = options.count * size; done < total;) {
        const std::uint32_t items = std::min(most, total - done);
        TAKT_CHECK(read_chunk(client, options, static_cast<std::uint16_t>(options.start + done),
                              static_cast<std::uint16_t>(items), values));
        done += items;
    }
    return {};
}

std::string read_report(const ReadOptions& options, const std::vector<ReadValue>& values, Duration time) {
    const DataType type = is_bit_area(options.area) ? DataType::boolean : options.type;
    std::string text;
    if (!options.json) {
        for (const auto& [address, value] : values)
            text += fmt::format("{} {}\n", address,
                                type == DataType::boolean ? (std::get<bool>(value) ? "1" : "0")
                                                          : value::format(type, false, value));
        return text;
    }
    auto list = file::Json::array();
    for (const auto& read : values) list.push_back(to_json(type, false, read.value));
    auto object = file::Json::object();
    object.set("target", options.target);
    object.set("unit", options.unit);
    object.set("function", static_cast<int>(read_function(options.area)));
    object.set("start", options.start);
    object.set("type", name(type));
    object.set("values", std::move(list));
    object.set("time_ms", static_cast<double>(time.count()) / 1e6);
    return object.dump() + "\n";
}

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

std::string write_json(const WriteOptions& options, const Items& items, const Written& written,
                       Duration time) {
    auto object = file::Json::object();
    object.set("target", options.target);
    object.set("unit", options.unit);
    object.set("function", static_cast<int>(written.function));
    object.set("start", options.start);
    object.set("quantity", static_cast<std::uint64_t>(written.items));
    object.set("outcome", written.ended ? "done" : "partly");
    if (!written.ended) object.set("wanted", static_cast<std::uint64_t>(items.size()));
    object.set("time_ms", static_cast<double>(time.count()) / 1e6);
    return object.dump() + "\n";
}

/// Whether options of registers were given for bits, told.
bool is_for_registers(const Texts& texts, Area area, bool given) {
    if (!given || !is_bit_area(area)) return false;
    texts.complain(texts("app.registers_only", {{"area", std::string(area_word(area))}}));
    return true;
}

bool is_beyond(const Texts& texts, std::uint64_t start, std::uint64_t items) {
    if (start + items <= 65536) return false;
    texts.complain(
        texts("app.beyond_area", {{"start", std::to_string(start)}, {"items", std::to_string(items)}}));
    return true;
}

Result<wire::Pdu> pdu_of(const std::vector<std::string>& words) {
    std::string digits;
    for (const auto& word : words)
        digits += word.starts_with("0x") || word.starts_with("0X") ? word.substr(2) : word;
    std::erase_if(digits, [](char c) { return c == ' ' || c == ':' || c == ','; });
    wire::Pdu pdu;
    if (digits.empty() || digits.size() % 2 != 0) return fail(Code::syntax, digits);
    for (std::size_t i = 0; i < digits.size(); i += 2) {
        const auto pair = digits.substr(i, 2);
        if (pair.find_first_not_of("0123456789abcdefABCDEF") != std::string::npos)
            return fail(Code::syntax, pair);
        if (!pdu.try_push_back(static_cast<std::uint8_t>(std::stoul(pair, nullptr, 16))))
            return fail(Code::too_long, static_cast<std::int64_t>(digits.size() / 2), wire::kMaxPdu);
    }
    return pdu;
}

}  // namespace

ExitCode read(const CommonOptions& common, const ReadOptions& options) {
    const Texts texts(common.language);
    if (is_for_registers(texts, options.area, options.registers_only)) return ExitCode::usage;
    const std::uint64_t size =
        is_bit_area(options.area) ? 1 : static_cast<std::uint64_t>(layout_of(options).register_count());
    if (is_beyond(texts, options.start, options.count * size)) return ExitCode::usage;
    if (options.watch) return watch(common, options);
    auto client = Client::open(options);
    if (!client) return ended_by(texts, nullptr, client.error());
    std::vector<ReadValue> values;
    const Instant begin = line::now();
    const auto done = read_all(**client, options, values);
    if (!values.empty() || done) print(read_report(options, values, line::now() - begin));
    if (done) return ExitCode::ok;
    const ExitCode code = ended_by(texts, client->get(), done.error());
    return values.empty() ? code : ExitCode::partly;
}

ExitCode write(const CommonOptions& common, const WriteOptions& options) {
    const Texts texts(common.language);
    if (options.area != Area::coil && options.area != Area::holding_register) {
        texts.complain(texts("app.read_only_area"));
        return ExitCode::usage;
    }
    if (is_for_registers(texts, options.area, options.registers_only)) return ExitCode::usage;
    const auto items = items_of(options);
    if (!items) return bad_arguments(texts, items.error());
    if (is_beyond(texts, options.start, items->size())) return ExitCode::usage;
    auto client = Client::open(options);
    if (!client) return ended_by(texts, nullptr, client.error());
    const Instant begin = line::now();
    const auto written = write_all(**client, options, *items);
    if (!written.ended && written.items == 0) return ended_by(texts, client->get(), written.ended.error());
    if (options.json) print(write_json(options, *items, written, line::now() - begin));
    const Texts::Arguments counts{{"count", std::to_string(written.items)},
                                  {"total", std::to_string(items->size())},
                                  {"start", std::to_string(options.start)},
                                  {"next", std::to_string(options.start + written.items)}};
    if (written.ended) {
        if (!options.json) talk(texts("app.written", counts) + "\n");
        return ExitCode::ok;
    }
    (void)ended_by(texts, client->get(), written.ended.error());
    texts.complain(texts("app.partly_written", counts));
    return ExitCode::partly;
}

ExitCode raw(const CommonOptions& common, const RawOptions& options) {
    const Texts texts(common.language);
    const auto pdu = pdu_of(options.bytes);
    if (!pdu) return bad_arguments(texts, pdu.error());
    auto client = Client::open(options);
    if (!client) return ended_by(texts, nullptr, client.error());
    const UnitId unit{options.unit};
    const auto decoded = wire::decode_request(pdu->span());
    talk(wire::describe_request(unit, pdu->span()) + "\n");
    const auto answer = (*client)->transact(*pdu, false);
    if (!answer) return ended_by(texts, client->get(), answer.error());
    if (!answer->empty())
        talk(wire::describe_response(unit, answer->span(), decoded ? &*decoded : nullptr) + "\n");
    if (options.json) {
        auto object = file::Json::object();
        object.set("target", options.target);
        object.set("unit", options.unit);
        object.set("request", wire::hex(pdu->span()));
        object.set("response", wire::hex(answer->span()));
        print(object.dump() + "\n");
    } else {
        print(wire::hex(answer->span()) + "\n");
    }
    return !answer->empty() && ((*answer)[0] & 0x80U) != 0 ? ExitCode::exception : ExitCode::ok;
}

}  // namespace takt::app
