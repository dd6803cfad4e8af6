// Typed values of one area, in as many requests as they need.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "takt/base/result.hpp"
#include "takt/client/client.hpp"
#include "takt/value/codec.hpp"
#include "takt/wire/pdu.hpp"

namespace takt::client {

/// Values of one area to read. In bit areas a value is a bit, and `layout` has no meaning.
struct ReadSpec {
    wire::Area area = wire::Area::holding_register;
    std::uint16_t start = 0;
    std::uint32_t count = 1;  ///< values
    value::Layout layout{.type = DataType::uint16};

    [[nodiscard]] DataType type() const { return is_bit_area(area) ? DataType::boolean : layout.type; }
    /// Registers or bits of one value, and of all.
    [[nodiscard]] std::uint32_t value_items() const;
    [[nodiscard]] std::uint64_t items() const { return std::uint64_t{count} * value_items(); }
};

struct ReadValue {
    std::uint16_t address = 0;  ///< of its first item
    value::Value value;
};

/// The requests for all values, in the order of their addresses. Each asks for as many whole values as fit.
/// @param spec  within the addresses of its area: start + items() <= 65536
[[nodiscard]] std::vector<wire::ReadRequest> read_requests(const ReadSpec& spec);

/// Appends the values of the response to the request that begins at `start`.
/// @returns what value::decode() returns
[[nodiscard]] Result<void> append_values(const ReadSpec& spec, std::uint16_t start,
                                         const wire::ResponseView& response, std::vector<ReadValue>& values);

/// Sends read_requests() until one fails. `values` gets those that were read before.
/// @returns what Client::ask() and append_values() return
[[nodiscard]] Result<void> read_values(Client& client, const ReadSpec& spec, std::vector<ReadValue>& values);

/// Values to write, as text. Coils take booleans, and `layout` has no meaning; a string has as many registers
/// as its text needs.
struct WriteSpec {
    wire::Area area = wire::Area::holding_register;  ///< coil or holding_register
    std::uint16_t start = 0;
    std::vector<std::string> values;
    value::Layout layout{.type = DataType::uint16};
    bool multiple = false;  ///< 0x0F and 0x10 also for a single item
};

/// One request of a write.
struct WritePart {
    wire::Request request;
    std::size_t end = 0;  ///< items written once it is confirmed, counted from the first request on
};

/// The requests for all values, in the order of their addresses. Each carries as many whole values as fit.
/// @returns what value::parse() and value::encode() return
[[nodiscard]] Result<std::vector<WritePart>> write_parts(const WriteSpec& spec);

/// How a write ended.
struct Written {
    wire::Function function{};  ///< of the last request
    std::size_t items = 0;      ///< confirmed, from the first on
    Result<void> ended;

    /// "done", "partly"; without a confirmed item "refused", or "unknown" where the device may have executed
    /// the request.
    [[nodiscard]] std::string_view outcome() const;
};

/// Sends the requests until one fails.
[[nodiscard]] Written write_values(Client& client, const std::vector<WritePart>& parts);

}  // namespace takt::client
