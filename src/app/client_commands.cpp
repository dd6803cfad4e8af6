// read and raw: one device asked once.
#include "takt/app/client_commands.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <string>
#include <vector>

#include "one_off.hpp"
#include "takt/app/console.hpp"
#include "takt/report/formatting.hpp"
#include "takt/report/value_json.hpp"
#include "takt/value/codec.hpp"
#include "takt/value/text.hpp"
#include "takt/wire/words.hpp"

namespace takt::app {
namespace {

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
             client.ask(wire::ReadRequest{wire::read_function(options.area), DataAddress{start}, items}));
    if (const auto bits = response.bits(); !bits.empty()) {
        for (std::uint16_t i = 0; i < items; ++i)
            values.push_back({static_cast<std::uint16_t>(start + i), value::Value(bits[i])});
        return {};
    }
    std::vector<std::uint16_t> registers(response.registers().size());
    response.registers().copy_to(registers);
    const auto layout = layout_of(options);
    const auto size = static_cast<std::size_t>(layout.register_count());
    for (std::size_t i = 0; i + size <= registers.size(); i += size) {
        TAKT_TRY(auto value, value::decode(layout, std::span<const std::uint16_t>(registers).subspan(i, size)));
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
        static_cast<std::uint32_t>(wire::max_items(wire::Framing::tcp, wire::read_function(options.area)));
    const std::uint32_t most = limit / size * size;
    for (std::uint32_t done = 0, total = options.count * size; done < total;) {
        const std::uint32_t items = std::min(most, total - done);
        TAKT_CHECK(read_chunk(client, options, static_cast<std::uint16_t>(options.start + done),
                              static_cast<std::uint16_t>(items), values));
        done += items;
    }
    return {};
}

DataType type_of(const ReadOptions& options) {
    return is_bit_area(options.area) ? DataType::boolean : options.type;
}

file::Json read_json(const ReadOptions& options, const std::vector<ReadValue>& values, Duration time) {
    auto list = file::Json::array();
    for (const auto& read : values) list.push_back(report::to_json(type_of(options), false, read.value));
    auto object = object_of(options);
    object.set("function", static_cast<int>(wire::read_function(options.area)));
    object.set("start", options.start);
    object.set("type", name(type_of(options)));
    object.set("values", std::move(list));
    object.set("time_ms", static_cast<double>(time.count()) / 1e6);
    return object;
}

std::string read_text(const ReadOptions& options, const std::vector<ReadValue>& values) {
    std::string text;
    for (const auto& [address, value] : values)
        text += fmt::format("{} {}\n", address,
                            type_of(options) == DataType::boolean
                                ? (std::get<bool>(value) ? "1" : "0")
                                : value::format(type_of(options), false, value));
    return text;
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
    std::vector<ReadValue> values;
    auto client = Client::open(options);
    if (!client) return ended_by(texts, options, nullptr, client.error(), read_json(options, values, {}));
    const Instant begin = line::now();
    const auto done = read_all(**client, options, values);
    auto object = read_json(options, values, line::now() - begin);
    if (!options.json) print(read_text(options, values));
    if (done && options.json) print(object.dump() + "\n");
    if (done) return ExitCode::ok;
    const ExitCode code = ended_by(texts, options, client->get(), done.error(), std::move(object));
    return values.empty() ? code : ExitCode::partly;
}

ExitCode raw(const CommonOptions& common, const RawOptions& options) {
    const Texts texts(common.language);
    const auto pdu = pdu_of(options.bytes);
    if (!pdu) return bad_arguments(texts, pdu.error());
    auto object = object_of(options);
    object.set("request", wire::hex(pdu->span()));
    auto client = Client::open(options);
    if (!client) return ended_by(texts, options, nullptr, client.error(), std::move(object));
    const UnitId unit{options.unit};
    const auto decoded = wire::decode_request(pdu->span());
    print_status(wire::describe_request(unit, pdu->span(), decoded) + "\n");
    const auto answer = (*client)->transact(*pdu, false);
    if (!answer) return ended_by(texts, options, client->get(), answer.error(), std::move(object));
    if (!answer->empty())
        print_status(wire::describe_response(unit, answer->pdu(), decoded ? &*decoded : nullptr) + "\n");
    if (options.json) {
        object.set("response", wire::hex(answer->pdu()));
        print(object.dump() + "\n");
    } else {
        print(wire::hex(answer->pdu()) + "\n");
    }
    return !answer->empty() && (answer->pdu()[0] & 0x80U) != 0 ? ExitCode::exception : ExitCode::ok;
}

}  // namespace takt::app
