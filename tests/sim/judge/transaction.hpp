// One request on the wire and what became of it, as the judge sees it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "frames.hpp"
#include "takt/base/time.hpp"

namespace takt::judge {

/// What a request was sent for.
enum class Purpose : std::uint8_t {
    polled,     ///< its period, or a repetition of that
    triggered,  ///< a start-reading trigger
    probe,      ///< its device does not answer
    learning,   ///< `gaps: learn` tries a range
    before,     ///< the read of a read-modify-write
    group,      ///< a group is written
    command,    ///< one variable is written
    nothing,    ///< nobody asked for it: a violation
};

struct Transaction {
    Asked asked;
    std::size_t device = 0;
    Instant start;
    Instant end;         ///< of the request
    Instant deadline;    ///< when it is given up at the latest
    Duration failure{};  ///< F
    Purpose purpose = Purpose::nothing;
    std::optional<Instant> due_since;     ///< of what is polled: since when it waits
    bool repeated = false;                ///< the attempt before failed
    std::vector<std::size_t> requests;    ///< of the plan, that it may be; the one it was taken for first
    std::optional<std::size_t> group;     ///< of the plan, that is written
    std::vector<std::uint64_t> commands;  ///< that it carries out
    bool expected = false;                ///< an admission lets it through: no surprise for the guarantees

    bool doubtful = false;     ///< taken for a command's; it may be a group's with the same bytes
    bool looked_into = false;  ///< whether the outcome of its command came with its answer

    bool over = false;
    bool cut = false;  ///< the link went away, or its device was switched meanwhile
    bool heard_something = false;
    bool was_dead = false;  ///< its device, when it ended
    Heard heard;
    Instant heard_at;

    bool served = false;  ///< the device has given the values
    Instant served_at;
    Words values;
    unsigned executed = 0;  ///< how often the device has done it
    Instant executed_at;

    [[nodiscard]] bool answered() const {
        return heard.answer == Answer::good || (heard.answer == Answer::exception && !gateway());
    }
    [[nodiscard]] bool gateway() const { return heard.exception == 10 || heard.exception == 11; }
};

}  // namespace takt::judge
