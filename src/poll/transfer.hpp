// Between requests on the wire and the values of their variables.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "takt/base/result.hpp"
#include "takt/model/project.hpp"
#include "takt/plan/plan.hpp"
#include "takt/value/codec.hpp"
#include "takt/wire/pdu.hpp"

namespace takt::poll {

/// The read of a request of the plan, which must have one.
wire::ReadRequest read_request(const plan::Request& request);

/// The value of one variable in the response to `request`.
/// @returns too_short where the response does not reach it
Result<value::Value> value_in(const wire::Response& response, const wire::ReadRequest& request,
                              const model::Variable& variable);

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

/// What a variable will be once `value` was written to it, and whether that is another value.
struct Written {
    value::Value value;
    bool rounded = false;
};
Result<Written> as_written(const model::Variable& variable, const value::Value& value);

}  // namespace takt::poll
