// Between requests on the wire and the values of their variables.
#pragma once

#include <cstddef>
#include <cstdint>

#include "takt/base/result.hpp"
#include "takt/model/project.hpp"
#include "takt/plan/plan.hpp"
#include "takt/value/codec.hpp"
#include "takt/wire/prepared_request.hpp"

namespace takt::poll {

/// A read that keeps the limits of its function, as all reads of a plan do.
wire::PreparedRead prepared(const wire::ReadRequest& read);

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

/// A value as it is written. It is encoded once; requests and comparisons are made of this.
struct Written {
    value::Value value;     ///< what a read returns after the write
    wire::Registers words;  ///< its registers in the order of their addresses; of a bool one, 0 if it is off
    bool rounded = false;   ///< `value` is not the value that was set
};
/// @returns what value::encode() returns
Result<Written> as_written(const model::Variable& variable, const value::Value& value);

/// The items of a write by 0x05, 0x06, 0x0F, 0x10 or 0x17. Its members are added in the order of their
/// addresses, and lie side by side.
class WrittenItems {
public:
    explicit WrittenItems(wire::Function function) : function_(function) {}

    /// @returns unsupported if the function cannot write the variable (a bool of a register); too_long
    Result<void> add(const model::Variable& variable, const wire::Registers& words);

    /// The request that writes them, by a function other than 0x17. At least one member was added.
    /// @returns unsupported for several registers by 0x06
    [[nodiscard]] Result<wire::Request> request() const;

    /// The request that writes them and reads what `request` reads, by 0x17.
    [[nodiscard]] wire::Request exchange(const plan::Request& request) const;

private:
    wire::Function function_;
    const model::Variable* first_ = nullptr;
    wire::Bits bits_;
    wire::Registers registers_;
};

/// Some bits of one register.
struct RegisterBits {
    std::uint16_t mask = 0;  ///< which
    std::uint16_t bits = 0;  ///< their values; the others 0

    [[nodiscard]] std::uint16_t in(std::uint16_t old) const {
        return static_cast<std::uint16_t>((old & ~mask) | bits);
    }
    /// @param variable  a bit of this register
    void add(const model::Variable& variable, const wire::Registers& words);
};

/// 0x16: changes these bits alone.
wire::Request mask_request(DataAddress address, const RegisterBits& bits);

/// A whole register by 0x06 or 0x10.
wire::Request register_request(wire::Function function, DataAddress address, std::uint16_t value);

}  // namespace takt::poll
