// One request on the wire and what became of it, as the judge sees it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <vector>

#include "frames.hpp"
#include "takt/base/time.hpp"
#include "takt/poll/statistics.hpp"
#include "takt/value/command.hpp"

namespace takt::judge {

using poll::Purpose;

/// What the master says a request is sent for: testimony, which the judge holds against what it knows.
struct Claim {
    Instant t;  ///< of the choice
    poll::Sending sending;
};

struct Transaction {
    Asked asked;
    std::size_t device = 0;
    Instant start;
    Instant end;         ///< of the request
    Instant deadline;    ///< when it is given up at the latest
    Duration failure{};  ///< F
    Purpose purpose = Purpose::period;
    Instant chosen;                          ///< before `start` where the line was busy
    std::optional<Instant> due_since;        ///< of what is polled: since when it waits
    bool repeated = false;                   ///< the attempt before failed
    std::optional<std::size_t> request;      ///< of the plan
    std::vector<value::CommandId> commands;  ///< that it carries out
    bool expected = false;                   ///< an admission lets it through: no surprise for the guarantees

    bool broadcast = false;           ///< nobody answers; it is over at its deadline
    std::set<std::uint8_t> taken_by;  ///< the units that have executed it

    bool over = false;
    bool cut = false;  ///< the link went away, or its device was switched meanwhile
    bool heard_something = false;
    Heard heard;
    Instant heard_at;

    bool served = false;  ///< the device has given the values
    Instant served_at;
    Words values;
    unsigned executed = 0;  ///< how often the device has done it
    bool ignored = false;   ///< the device says that it has done it, and has not
    Instant executed_at;

    [[nodiscard]] bool answered() const {
        return (broadcast && !cut) || heard.answer == Answer::good ||
               (heard.answer == Answer::exception && !gateway());
    }
    /// The device has answered, but the master need not have found that.
    [[nodiscard]] bool unsure() const { return heard.among_others && answered(); }
    [[nodiscard]] bool writes() const { return asked.writes || asked.masks; }
    [[nodiscard]] bool polls() const { return purpose == Purpose::period || purpose == Purpose::repetition; }
    /// It is the read of its request, and not one for what that writes.
    [[nodiscard]] bool is_its_read() const {
        return polls() || purpose == Purpose::probe || purpose == Purpose::trigger;
    }
    [[nodiscard]] bool gateway() const { return heard.exception == 10 || heard.exception == 11; }
};

}  // namespace takt::judge
