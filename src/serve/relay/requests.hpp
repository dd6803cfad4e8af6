// Classification of the requests that a gateway relays.
#pragma once

#include <optional>

#include "takt/base/engine.hpp"
#include "takt/wire/function.hpp"
#include "takt/wire/pdu.hpp"
#include "takt/wire/prepared_request.hpp"

namespace takt::serve {

/// Of a request that is not passed on. A request without the length of its function could hide a
/// second frame behind the first.
/// @param broadcast  to all units of a serial line: writes only
[[nodiscard]] std::optional<wire::ExceptionCode> refusal(const wire::PreparedRequest& request,
                                                         bool broadcast);

/// The answer to a relayed broadcast write, which no device answers.
[[nodiscard]] wire::Pdu answer_to_broadcast(Bytes request);

}  // namespace takt::serve
