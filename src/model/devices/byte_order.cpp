#include "takt/model/byte_order.hpp"

#include <algorithm>
#include <iterator>
#include <string>
#include <utility>

#include "servers/interpretation.hpp"

namespace takt::model {
namespace {

constexpr std::size_t kBytesOfARegister = 2;
constexpr std::size_t kBytesOfTwo = 4;

/// The permutations that fit a type. Those of two registers state both orders, so they fit every type.
std::string fitting(DataType type) {
    std::string all = "2143, 4321, 1234, 3412";
    const auto registers = type == DataType::string ? 1 : register_count(type);
    if (registers == 1) all += ", 21, 12";
    if (registers == 4) all += ", 21436587, 87654321, 12345678, 78563412";
    return all;
}

void check_switch(Reader& reader, std::string_view key, std::optional<bool> written, bool stated) {
    if (!written || *written == stated) return;
    reader.report(Rule::byte_order_contradiction, key, stated ? "true" : "false",
                  {{"key", std::string(key)}, {"order", reader.value("byte_order")->text}});
}

std::optional<Permutation> read_permutation(Reader& reader, std::optional<DataType> type) {
    const Node* const node = reader.scalar("byte_order");
    if (node == nullptr) return std::nullopt;
    const auto permutation = parse_byte_order(node->text);
    if (!permutation) {
        reader.report(Rule::byte_order_unknown, "byte_order", reader.allowed_text("byte_order"));
        return std::nullopt;
    }
    if (!type || permutation->bytes == kBytesOfTwo) return permutation;
    if (permutation->bytes == byte_order_text({}, *type).size()) return permutation;
    reader.report(Rule::byte_order_type, "byte_order", fitting(*type), {{"type", std::string(name(*type))}});
    return std::nullopt;
}

/// `CDAB` as `2143`: A is the most significant byte. A text of anything but letters as it is.
std::string numbered(std::string letters) {
    const auto upper = [](char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; };
    const auto size = static_cast<int>(letters.size());
    const auto number = [&](char c) { return size - (upper(c) - 'A'); };
    const auto is_name = [&](char c) { return upper(c) >= 'A' && number(c) >= 1 && number(c) <= size; };
    if (size > 8 || !std::ranges::all_of(letters, is_name)) return letters;
    std::ranges::transform(letters, letters.begin(),
                           [&](char c) { return static_cast<char>('0' + number(c)); });
    return letters;
}

}  // namespace

std::optional<Permutation> parse_byte_order(std::string_view text) {
    // As an IDE shows it: `Float: 2 1 4 3`.
    constexpr std::string_view kShown = "Float:";
    if (text.starts_with(kShown)) text.remove_prefix(kShown.size());
    std::string digits;
    std::ranges::copy_if(text, std::back_inserter(digits), [](char c) { return c != ' '; });
    digits = numbered(std::move(digits));
    if (std::ranges::find(kByteOrders, std::string_view(digits)) == kByteOrders.end()) return std::nullopt;
    for (const bool high_byte : {true, false})
        for (const bool high_register : {false, true})
            for (const int registers : {1, 2, 4}) {
                const ByteOrder order{high_byte, high_register};
                if (byte_order_text(order, registers) == digits) return Permutation{order, digits.size()};
            }
    return std::nullopt;
}

std::string_view byte_order_text(ByteOrder order, int registers) {
    const std::size_t at =
        order.high_byte_first ? (order.high_register_first ? 1 : 0) : (order.high_register_first ? 3 : 2);
    if (registers == 1) return order.high_byte_first ? kByteOrders[4] : kByteOrders[5];
    return kByteOrders[registers == 4 ? 6 + at : at];
}

std::string_view byte_order_text(ByteOrder order, DataType type) {
    return byte_order_text(order, type == DataType::string ? 1 : register_count(type));
}

std::string byte_order_name(std::string_view permutation) {
    const auto size = static_cast<int>(permutation.size());
    std::string name;
    for (const char digit : permutation) name += static_cast<char>('A' + size - (digit - '0'));
    return name;
}

ByteOrder read_byte_order(Reader& reader, ByteOrder inherited, std::optional<DataType> type) {
    const auto high_byte = reader.boolean("high_byte_first");
    const auto high_register = reader.boolean("high_register_first");
    const auto stated = read_permutation(reader, type);
    ByteOrder order{high_byte.value_or(inherited.high_byte_first),
                    high_register.value_or(inherited.high_register_first)};
    if (!stated) return order;
    check_switch(reader, "high_byte_first", high_byte, stated->order.high_byte_first);
    order.high_byte_first = stated->order.high_byte_first;
    if (stated->bytes == kBytesOfARegister) return order;
    check_switch(reader, "high_register_first", high_register, stated->order.high_register_first);
    order.high_register_first = stated->order.high_register_first;
    return order;
}

}  // namespace takt::model
