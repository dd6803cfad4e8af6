// Reading back what was written, and comparing (verify).
#pragma once

#include <cstdint>
#include <optional>

#include "takt/bus/health.hpp"
#include "takt/bus/transaction.hpp"
#include "takt/model/project.hpp"
#include "takt/plan/plan.hpp"
#include "takt/value/value.hpp"
#include "takt/wire/pdu.hpp"

namespace takt::poll {

/// Where the reading back of a write stands. It has the place in the queue that its write had; until it is
/// settled nothing else is written to the device.
struct ReadBack {
    wire::ReadRequest request;
    wire::Request written;   // what is compared with; of a read-modify-write its write
    bool due = false;        // the device confirmed the write
    bool under_way = false;  // it is being read
    std::uint64_t order = 0;
    std::uint16_t failures = 0;
    bus::Backoff busy = bus::busy_backoff();
    Instant not_before = Instant::min();

    [[nodiscard]] bool pending() const { return due || under_way; }
    void begin(std::uint64_t place) {
        due = true;
        order = place;
        failures = 0;
        busy.reset();
        not_before = Instant::min();
    }
};

/// What reads back one variable, which is written alone.
[[nodiscard]] ReadBack read_back_of(const model::Variable& variable);

/// What reads back all that a request of the plan writes; nothing where none of it is to be verified.
[[nodiscard]] std::optional<ReadBack> read_back_of(const model::Device& device, const plan::Request& request);

/// The value of a variable as a write of 0x05, 0x06, 0x0F, 0x10, 0x16 or 0x17 makes it; of 0x16 only of the
/// bits it writes. Nothing where the write does not hold it.
[[nodiscard]] std::optional<value::Value> value_written(const wire::Request& write,
                                                        const model::Variable& variable);

}  // namespace takt::poll
