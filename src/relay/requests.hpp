// Classification of the requests that a gateway relays.
#pragma once

#include <optional>

#include "takt/base/engine.hpp"
#include "takt/wire/function.hpp"
#include "takt/wire/pdu.hpp"

namespace takt::relay {

/// The exception for a request that is not relayed. A length that does not match the function is refused,
/// because a second frame could be hidden behind the first one.
/// @param broadcast  a broadcast on a serial line: only writes are relayed
[[nodiscard]] std::optional<wire::ExceptionCode> refusal(Bytes request, bool broadcast);

/// The answer to a relayed broadcast write, which no device answers.
[[nodiscard]] wire::Pdu answer_to_broadcast(Bytes request);

}  // namespace takt::relay
