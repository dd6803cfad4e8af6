// Verification of writes: the written items are read back and compared.
#pragma once

#include <cstdint>
#include <optional>

#include "devices/outcome_class.hpp"
#include "takt/bus/health.hpp"
#include "takt/bus/transaction.hpp"
#include "takt/model/project.hpp"
#include "takt/plan/plan.hpp"
#include "takt/wire/prepared_request.hpp"

namespace takt::poll {

/// A verification and its retries; WriteProgress has its steps. The response is compared with
/// WrittenValues::sent(). It keeps the position in the queue that its write had; until it ends, the device
/// gets no other write.
struct ReadBack {
    wire::PreparedRead request;
    std::uint64_t order = 0;
    std::uint16_t failures = 0;
    bus::Backoff busy = bus::busy_backoff();
    Instant not_before = Instant::min();

    void begin(std::uint64_t arrival) {
        order = arrival;
        failures = 0;
        busy.reset();
        not_before = Instant::min();
    }
    /// It failed. A read may always be repeated.
    /// @param attempts  of the device
    /// @returns whether it is tried again
    bool again(Instant t, const OutcomeClass& outcome_class, std::uint16_t attempts);
};

/// The verification of one variable that is written alone.
[[nodiscard]] ReadBack read_back_of(const model::Variable& variable);

}  // namespace takt::poll
