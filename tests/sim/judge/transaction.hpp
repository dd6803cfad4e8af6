// One request on the wire and its outcome, as recorded by the judge.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <string_view>
#include <vector>

#include "frames.hpp"
#include "takt/base/time.hpp"
#include "takt/poll/statistics.hpp"
#include "takt/value/command.hpp"

namespace takt::judge {

using poll::Purpose;

/// The purpose of a request as the master reports it. The judge checks it against its own records.
struct Claim {
    Instant t;  ///< of the choice
    poll::Sending sending;
};

/// The connection was closed before the answer.
enum class Close : std::uint8_t {
    none,
    of_several,   ///< it is a failure of no device
    perhaps_own,  ///< of several, or its own
    own,          ///< it is a failure of its device
};

/// Values that the device did not give in answer to the request, though the bytes show a history in which it
/// did. See ledger.hpp.
struct FalseHistory {
    Words values;
    std::string_view exemption;
};

struct Transaction {
    Asked asked;
    std::size_t device = 0;
    Instant start;
    Instant end;         ///< of the request
    Instant deadline;    ///< latest end of the transaction
    Duration failure{};  ///< F
    Purpose purpose = Purpose::period;
    Instant chosen;                          ///< before `start` where the line was busy
    std::optional<Instant> due_since;        ///< of what is polled: since when it waits
    bool waits_again = false;                ///< its trigger, because it failed
    bool repeated = false;                   ///< the attempt before failed
    bool replaces = false;                   ///< another read than the planned one
    bool partial = false;                    ///< a part of the planned read, or another one instead
    std::optional<std::size_t> request;      ///< of the plan
    std::vector<value::CommandId> commands;  ///< that it carries out
    bool expected = false;                   ///< admitted by a rate limit, so the guarantees include it
    bool client = false;                     ///< of what passes the rate limit of the line

    bool early = false;               ///< a probe in spare time
    bool broadcast = false;           ///< without an answer; ends at its deadline
    std::set<std::uint8_t> taken_by;  ///< the units that have executed it

    bool over = false;
    bool cut = false;     ///< the link went away, or its device was switched meanwhile
    bool joined = false;  ///< another request was in flight with it
    bool may_be_joined = false;
    Close close = Close::none;
    bool heard_something = false;
    Received received;
    std::vector<FalseHistory> false_histories;  ///< when the next request is sent
    std::vector<Words> further;  ///< the values of frames behind the first one that could be its answer
    Instant heard_at;

    bool served = false;  ///< the device has given the values
    Instant served_at;
    Words values;
    unsigned executed = 0;  ///< how often the device has done it
    bool ignored = false;   ///< the device confirmed it without executing it
    Instant executed_at;

    [[nodiscard]] bool answered() const {
        return (broadcast && !cut) || received.answer == Answer::good ||
               (received.answer == Answer::exception && !gateway());
    }
    /// The device has answered, but the master may have missed it.
    [[nodiscard]] bool unsure() const { return received.among_others && answered(); }
    [[nodiscard]] bool writes() const { return asked.writes || asked.masks; }
    [[nodiscard]] bool polls() const { return purpose == Purpose::period || purpose == Purpose::repetition; }
    /// A write, or a read on behalf of one.
    [[nodiscard]] bool commanded_write() const {
        return purpose == Purpose::write || purpose == Purpose::before_write || purpose == Purpose::read_back;
    }
    /// A write, a read on behalf of one, or a triggered read.
    [[nodiscard]] bool event() const { return commanded_write() || purpose == Purpose::trigger; }
    /// It is the read of its request, and not one for what that writes.
    [[nodiscard]] bool is_its_read() const {
        return polls() || purpose == Purpose::probe || purpose == Purpose::trigger;
    }
    [[nodiscard]] bool gateway() const { return received.exception == 10 || received.exception == 11; }
};

}  // namespace takt::judge
