// The read half of a request of the plan.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "takt/base/time.hpp"
#include "takt/bus/transaction.hpp"
#include "takt/wire/prepared_request.hpp"

namespace takt::poll {

/// What the values of a response belong to: they were due in a period, or read by a change of a trigger.
struct ReadRound {
    Instant due = Instant::min();
    std::optional<std::int64_t> change;  ///< its number
};

/// What a read is; ReadSchedule has its schedule.
struct ReadJob {
    wire::PreparedRead request;
    std::size_t rank = 0;   ///< among all jobs of the line, in the order of the plan
    Duration deadline{};    ///< relative to the release
    bool polled = false;    ///< by period
    unsigned refusals = 0;  ///< in a row, of a read across gaps
    Instant last_start = Instant::min();

    [[nodiscard]] bus::AnswerShape shape() const { return bus::answer_shape(request.shape()); }
};

}  // namespace takt::poll
