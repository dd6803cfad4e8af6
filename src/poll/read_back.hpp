// Verification of writes: the written items are read back and compared.
#pragma once

#include <cstdint>
#include <optional>

#include "takt/bus/health.hpp"
#include "takt/bus/transaction.hpp"
#include "takt/model/project.hpp"
#include "takt/plan/plan.hpp"
#include "takt/wire/prepared_request.hpp"

namespace takt::poll {

/// The state of a verification. The response is compared with WrittenRun::sent. It keeps the position in the
/// queue that its write had; until it ends, the device gets no other write.
struct ReadBack {
    wire::PreparedRead request;
    bool due = false;        // the device confirmed the write
    bool in_flight = false;  // it is being read
    std::uint64_t order = 0;
    std::uint16_t failures = 0;
    bus::Backoff busy = bus::busy_backoff();
    Instant not_before = Instant::min();

    [[nodiscard]] bool pending() const { return due || in_flight; }
    void begin(std::uint64_t arrival) {
        due = true;
        order = arrival;
        failures = 0;
        busy.reset();
        not_before = Instant::min();
    }
};

/// The verification of one variable that is written alone.
[[nodiscard]] ReadBack read_back_of(const model::Variable& variable);

/// The verification of a request of the plan; nothing if none of its variables has `verify`.
[[nodiscard]] std::optional<ReadBack> read_back_of(const model::Device& device, const plan::Request& request);

}  // namespace takt::poll
