// The meaning of an outcome for the device that was asked.
#pragma once

#include "takt/base/status_code.hpp"
#include "takt/bus/transaction.hpp"

namespace takt::bus {

/// The status that a variable of the request shows, and whether the device answered.
struct OutcomeStatus {
    StatusCode status = StatusCode::ok;
    bool answered = false;  ///< by the device itself, not by a gateway
    bool busy = false;      ///< exceptions 5 and 6
};

[[nodiscard]] OutcomeStatus status_of(const Outcome& outcome);

}  // namespace takt::bus
