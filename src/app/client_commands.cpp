// read, write, raw: one device asked once.
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

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

Function read_function(Area area) {
    switch (area) {
        case Area::coil: return Function::read_coils;
        case Area::discrete_input: return Function::read_discrete_inputs;
        case Area::input_register: return Function::read_input_registers;
        case Area::holding_register: return Function::read_holding_registers;
    }
    return Function::read_holding_registers;
}

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

/// The items to be written, in the order of their addresses.
struct Items {
    wire::Bits bits;
    std::vector<std::uint16_t> registers;
};

Result<Items> items_of(const WriteOptions& options) {
    Items items;
    for (const auto& text : options.values) {
        if (options.area == Area::coil) {
            TAKT_TRY(const auto value, value::parse(DataType::boolean, false, text));
            if (items.bits.size() == wire::Bits::kCapacity)
                return fail(Code::too_long, static_cast<std::int64_t>(options.values.size()),
                            wire::Bits::kCapacity);
            items.bits.push_back(std::get<bool>(value));
            continue;
        }
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
    return items;
}

Result<wire::Request> request_of(const WriteOptions& options, const Items& items) {
    const DataAddress start{options.start};
    if (options.area == Area::coil) {
        if (items.bits.size() == 1 && !options.multiple)
            return wire::WriteSingleCoilRequest{start, items.bits[0]};
        return wire::WriteMultipleCoilsRequest{start, items.bits};
    }
    if (items.registers.size() == 1 && !options.multiple)
        return wire::WriteSingleRegisterRequest{start, items.registers[0]};
    const auto most = wire::max_items(wire::Framing::tcp, Function::write_multiple_registers);
    if (items.registers.size() > most)
        return fail(Code::out_of_range, "registers", static_cast<std::int64_t>(items.registers.size()), 1,
                    static_cast<std::int64_t>(most));
    wire::WriteMultipleRegistersRequest request{start, {}};
    request.values.assign(items.registers);
    return request;
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
    const std::uint64_t size =
        is_bit_area(options.area) ? 1 : static_cast<std::uint64_t>(layout_of(options).register_count());
    if (options.start + options.count * size > 65536) {
        texts.complain(texts("app.beyond_area", {{"start", std::to_string(options.start)},
                                                 {"items", std::to_string(options.count * size)}}));
        return ExitCode::usage;
    }
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
    const auto items = items_of(options);
    if (!items) return bad_arguments(texts, items.error());
    const auto request = request_of(options, *items);
    if (!request) return bad_arguments(texts, request.error());
    auto client = Client::open(options);
    if (!client) return ended_by(texts, nullptr, client.error());
    const Instant begin = line::now();
    const auto done = (*client)->order(*request);
    if (!done) return ended_by(texts, client->get(), done.error());
    const auto count = options.area == Area::coil ? items->bits.size() : items->registers.size();
    if (options.json) {
        auto object = file::Json::object();
        object.set("target", options.target);
        object.set("unit", options.unit);
        object.set("function", static_cast<int>(wire::function_of(*request)));
        object.set("start", options.start);
        object.set("quantity", static_cast<std::uint64_t>(count));
        object.set("outcome", "done");
        object.set("time_ms", static_cast<double>((line::now() - begin).count()) / 1e6);
        print(object.dump() + "\n");
    } else {
        talk(texts("app.written",
                   {{"count", std::to_string(count)}, {"start", std::to_string(options.start)}}) +
             "\n");
    }
    return ExitCode::ok;
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
