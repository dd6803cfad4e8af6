// The meaning of an outcome for the device that was asked.
#pragma once

#include <cstdint>

#include "takt/base/status_code.hpp"
#include "takt/bus/transaction.hpp"

namespace takt::bus {

/// The status that a variable of the request shows, and whether the device answered.
struct OutcomeStatus {
    StatusCode status = StatusCode::ok;
    bool answered = false;  ///< by the device itself, not by a gateway
    bool busy = false;      ///< exceptions 5 and 6

    /// The same request may end otherwise if it is repeated.
    [[nodiscard]] bool transient() const { return !answered || busy || status == StatusCode::ambiguous; }
};

[[nodiscard]] OutcomeStatus status_of(const Outcome& outcome);

/// Whether a failed write, or the reading back of one, may be sent again. A lost link uses up no attempt.
/// After two ambiguous responses a unit is in step again (OutstandingResponses): these are no failures of the
/// unit.
/// @param attempts  of the device
/// @param failures  so far; counted
[[nodiscard]] bool attempts_left(StatusCode status, std::uint16_t attempts, std::uint16_t& failures);

}  // namespace takt::bus
