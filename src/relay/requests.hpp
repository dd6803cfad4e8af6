// What a gateway must know of the requests it passes on.
#pragma once

#include <optional>

#include "takt/base/engine.hpp"
#include "takt/wire/function.hpp"
#include "takt/wire/pdu.hpp"
#include "takt/wire/prepared_request.hpp"

namespace takt::relay {

/// Of a request that is not passed on. What does not have the length that its function says could hide a
/// second frame behind the first.
/// @param broadcast  to all units of a serial line: writes only
[[nodiscard]] std::optional<wire::ExceptionCode> refusal(const wire::PreparedRequest& request,
                                                         bool broadcast);

/// The normal answer to a write that nobody answers: a broadcast.
[[nodiscard]] wire::Pdu answer_to_broadcast(Bytes request);

}  // namespace takt::relay
