#include "takt/report/states/all_types_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <vector>

#include "takt/model/byte_order.hpp"
#include "takt/report/drawing/text_table.hpp"
#include "takt/report/drawing/value_json.hpp"
#include "takt/text/escape.hpp"
#include "takt/value/codec.hpp"
#include "takt/value/text.hpp"

namespace takt::report {
namespace {

using Align = TextTable::Align;
using Registers = std::span<const std::uint16_t>;

/// In the order ABCD, CDAB, BADC, DCBA.
constexpr std::array kOrders{ByteOrder{true, true}, ByteOrder{true, false}, ByteOrder{false, true},
                             ByteOrder{false, false}};
constexpr std::array kOrdersOfOne{ByteOrder{true, false}, ByteOrder{false, false}};  // AB, BA

/// The types of values of so many registers.
std::vector<DataType> types_of(std::size_t registers) {
    if (registers == 1) return {DataType::uint16, DataType::int16};
    if (registers == 2) return {DataType::uint32, DataType::int32, DataType::float32};
    return {DataType::uint64, DataType::int64, DataType::float64};
}

std::span<const ByteOrder> orders_of(std::size_t registers) {
    if (registers == 1) return kOrdersOfOne;
    return kOrders;
}

std::string permutation(ByteOrder order, std::size_t registers) {
    return std::string(model::byte_order_text(order, static_cast<int>(registers)));
}

std::string order_name(ByteOrder order, std::size_t registers) {
    return model::byte_order_name(permutation(order, registers));
}

/// Every type but a string decodes every register; a string is cut at its first NUL.
value::Value decoded(DataType type, ByteOrder order, Registers registers) {
    const value::Layout layout{
        .type = type, .order = order, .registers = static_cast<std::uint16_t>(registers.size())};
    auto value = value::decode(layout, registers);
    if (!value) return {};
    return *std::move(value);
}

std::string decoded_text(DataType type, ByteOrder order, Registers registers) {
    return text::escape_line(value::format(type, false, decoded(type, order, registers)));
}

std::string binary_text(std::uint16_t word) {
    const auto digits = fmt::format("{:016b}", word);
    std::string groups = digits.substr(0, 4);
    for (std::size_t i = 4; i < digits.size(); i += 4) groups += ' ' + digits.substr(i, 4);
    return groups;
}

std::string words_table(const Texts& texts, std::uint16_t start, Registers registers) {
    TextTable table(std::vector<Align>(7, Align::right));
    std::vector<std::string> head{texts("app.read.register"), "hex", texts("app.read.binary")};
    for (const auto order : kOrdersOfOne)
        for (const auto type : types_of(1))
            head.push_back(fmt::format("{} {}", name(type), order_name(order, 1)));
    table.add(std::move(head));
    for (std::size_t i = 0; i < registers.size(); ++i) {
        const auto word = registers.subspan(i, 1);
        std::vector<std::string> row{std::to_string(start + i), fmt::format("{:04X}", word[0]),
                                     binary_text(word[0])};
        for (const auto order : kOrdersOfOne)
            for (const auto type : types_of(1)) row.push_back(decoded_text(type, order, word));
        table.add(std::move(row));
    }
    return table.render();
}

std::string values_table(std::size_t first, Registers registers) {
    TextTable table({Align::left, Align::right, Align::right, Align::right});
    const auto types = types_of(registers.size());
    std::vector<std::string> head{fmt::format("{}..{}", first, first + registers.size() - 1)};
    for (const auto type : types) head.emplace_back(name(type));
    table.add(std::move(head));
    for (const auto order : orders_of(registers.size())) {
        std::vector<std::string> row{order_name(order, registers.size())};
        for (const auto type : types) row.push_back(decoded_text(type, order, registers));
        table.add(std::move(row));
    }
    return '\n' + table.render();
}

/// The longest string that value::Layout takes.
Registers text_part(Registers registers) {
    constexpr std::size_t kMostRegisters = 125;
    return registers.first(std::min(registers.size(), kMostRegisters));
}

std::string orders_line(std::size_t registers) {
    std::string line;
    for (const auto order : orders_of(registers))
        line += fmt::format("{}{} {}", line.empty() ? "" : ", ", order_name(order, registers),
                            permutation(order, registers));
    return line + '\n';
}

constexpr std::array<std::size_t, 3> kWidths{1, 2, 4};

file::Json value_entry(std::size_t address, DataType type, ByteOrder order, Registers registers) {
    auto entry = file::Json::object();
    entry.set("address", static_cast<std::uint64_t>(address));
    entry.set("registers", static_cast<std::uint64_t>(registers.size()));
    entry.set("type", name(type));
    const auto digits = permutation(order, type == DataType::string ? 1 : registers.size());
    entry.set("order", model::byte_order_name(digits));
    entry.set("byte_order", digits);
    entry.set("value", to_json(type, false, decoded(type, order, registers)));
    return entry;
}

}  // namespace

std::string all_types_text(const Texts& texts, std::uint16_t start, Registers registers) {
    if (registers.empty()) return {};
    std::string text = words_table(texts, start, registers);
    std::string orders;
    for (const auto width : kWidths) {
        if (registers.size() < width) continue;
        for (std::size_t i = 0; width > 1 && i + width <= registers.size(); ++i)
            text += values_table(start + i, registers.subspan(i, width));
        orders += orders_line(width);
    }
    text += '\n';
    for (const auto order : kOrdersOfOne)
        text += fmt::format("string {}  {}\n", order_name(order, 1),
                            decoded_text(DataType::string, order, text_part(registers)));
    return text + '\n' + orders;
}

file::Json all_types_json(const Texts& texts, const ClientRun& run, const client::ReadSpec& spec,
                          Registers registers, const Result<void>& ended) {
    auto words = file::Json::array();
    for (std::size_t i = 0; i < registers.size(); ++i) {
        auto word = file::Json::object();
        word.set("address", static_cast<std::uint64_t>(spec.start + i));
        word.set("hex", fmt::format("{:04X}", registers[i]));
        word.set("binary", fmt::format("{:016b}", registers[i]));
        words.push_back(std::move(word));
    }
    auto values = file::Json::array();
    for (const auto width : kWidths)
        for (std::size_t i = 0; i + width <= registers.size(); ++i)
            for (const auto type : types_of(width))
                for (const auto order : orders_of(width))
                    values.push_back(value_entry(spec.start + i, type, order, registers.subspan(i, width)));
    if (!registers.empty())
        for (const auto order : kOrdersOfOne)
            values.push_back(value_entry(spec.start, DataType::string, order, text_part(registers)));
    auto object = read_json(texts, run, spec, {}, ended);
    object.set("type", "all");
    object.set("registers", std::move(words));
    object.set("values", std::move(values));
    return object;
}

}  // namespace takt::report
