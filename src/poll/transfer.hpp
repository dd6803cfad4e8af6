// Between requests on the wire and the values of their variables.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "takt/base/result.hpp"
#include "takt/model/project.hpp"
#include "takt/plan/plan.hpp"
#include "takt/value/codec.hpp"
#include "takt/wire/prepared_request.hpp"

namespace takt::poll {

/// The read of a planned request; of 0x17 its read half as 0x03. The request must have a read.
wire::ReadRequest read_request(const plan::Request& request);

/// The value of one variable, copied out of the response to a read that began at `start`. Other items of the
/// response do not matter.
/// @returns too_short where the response does not reach it
Result<value::Value> value_in(const wire::ResponseView& response, DataAddress start,
                              const model::Variable& variable);

/// `count` registers copied out of the response to a read that began at `start`, from the address `first` on.
/// @returns too_short where the response does not reach them
Result<wire::Registers> registers_in(const wire::ResponseView& response, DataAddress start,
                                     std::uint16_t first, std::size_t count);

/// A bool that is a bit of a register.
[[nodiscard]] bool is_register_bit(const model::Variable& variable);

/// A value as it goes into a write.
struct Member {
    const model::Variable* variable;
    const value::Value* value;
};

/// The request that writes `members`, which lie side by side in the order of their addresses, by `function`
/// (0x05, 0x06, 0x0F, 0x10).
/// @returns what value::encode() returns; unsupported where the function cannot write them (a bool of a
/// register)
Result<wire::Request> write_request(wire::Function function, std::span<const Member> members);

/// The request that writes `members` and reads what `request` reads, by 0x17.
Result<wire::Request> exchange_request(const plan::Request& request, std::span<const Member> members);

/// Some bits of one register.
struct RegisterBits {
    std::uint16_t mask = 0;  ///< which
    std::uint16_t bits = 0;  ///< their values; the others 0

    [[nodiscard]] std::uint16_t in(std::uint16_t old) const {
        return static_cast<std::uint16_t>((old & ~mask) | bits);
    }
};
/// @param members  bits of one register
Result<RegisterBits> register_bits(std::span<const Member> members);

/// 0x16: changes these bits alone.
wire::Request mask_request(DataAddress address, const RegisterBits& bits);

/// A whole register by 0x06 or 0x10.
wire::Request register_request(wire::Function function, DataAddress address, std::uint16_t value);

/// What a variable will be once `value` was written to it, and whether that is another value.
struct Written {
    value::Value value;
    bool rounded = false;
};
Result<Written> as_written(const model::Variable& variable, const value::Value& value);

}  // namespace takt::poll
