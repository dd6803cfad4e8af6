// Commands of a running project and their outcomes.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "takt/base/numbers.hpp"
#include "takt/base/result.hpp"
#include "takt/base/time.hpp"
#include "takt/model/service.hpp"
#include "takt/value/command.hpp"
#include "takt/value/store.hpp"
#include "takt/value/value.hpp"

namespace takt::host {

/// Numbers the `set` and `write` commands of a host from 1; 0: none (get).
using CommandId = value::CommandId;

/// Identifies a session for as long as the host runs; 0: none.
using SessionId = std::uint32_t;

struct Command {
    enum class Kind : std::uint8_t {
        set,    ///< a local, or the value that a variable is to have: written on change or by its trigger
        write,  ///< the variable of a device, now
        get,    ///< the value as it is after the session's earlier commands were accepted
        pull,   ///< a local of type bool: it rises from 0 to 1 and falls again, for the requests that it
                ///< triggers
        probe,  ///< the device of the variable, if it does not answer: its back-off ends
        /// A request to a unit of a polled line. It is sent when no other request is due. The guarantees do
        /// not include it, unless it keeps to spare time. One at a time for each line, of all sessions.
        exchange,
    };
    struct Exchange {
        std::size_t line = 0;  ///< index in the project
        UnitId unit{1};
        std::vector<std::uint8_t> pdu;
        /// For the first byte of the response; of a device of the line its own time-outs apply.
        Duration wait = std::chrono::milliseconds(200);
        /// It is sent only if it has ended, answered or not, before a polled request is due. On a line that a
        /// server relays to it is one of the relayed requests instead, and waits no longer than they do.
        bool spare = false;
    };
    Kind kind = Kind::get;
    value::SlotId slot;     ///< of the session's configuration; of probe: any variable of the device
    value::Value value;     ///< of set and write: of the slot's type
    std::uint64_t tag = 0;  ///< handed back in the outcome
    /// Instead of `slot`: a service variable that the project does not use. It can only be read.
    std::optional<model::ServiceVariable> service;
    std::optional<Exchange> exchange = std::nullopt;  ///< of exchange, instead of `slot`
    /// Of exchange: not sent after this instant. Of set and write: not begun after this instant, and not sent
    /// to the device if it is a write. Nothing: a write expires after 10 s.
    std::optional<Instant> expires = std::nullopt;
};

/// The result of a command. A session gets exactly one outcome for each command that submit() accepted.
struct Outcome {
    /// How far an accepted `set` got.
    enum class Progress : std::uint8_t {
        settled,      ///< nothing more will happen
        waiting,      ///< the value is set; the device gets it when it can be written
        superseded,   ///< a later `set` of the variable replaced it
        not_written,  ///< the value is set; only the variable's trigger or a `write` sends it to the device
    };

    CommandId id = 0;
    std::uint64_t tag = 0;  ///< of the command
    Command::Kind kind = Command::Kind::get;
    value::SlotId slot;
    std::optional<model::ServiceVariable> service;  ///< instead of `slot`
    Instant t;
    std::optional<Error> error;  ///< the host did not accept it; nothing was sent or changed
    /// A probe is refused if its device is in no back-off. Its reason is link_lost if the link is down.
    value::CommandResult result = value::CommandResult::done;
    value::Reason reason = value::Reason::ok;  ///< why it was refused or is unknown; get: of the quality
    Progress progress = Progress::settled;     ///< of a `set` with result done
    bool rounded = false;                      ///< the device holds the nearest value it can
    bool not_retained = false;                 ///< the value is to survive the end of the run, and will not
    value::Quality quality = value::Quality::good;  ///< of get
    std::optional<Instant> good_at;                 ///< of get: when the value was last read well, or set
    std::optional<Instant> sampled_at;              ///< of that read, the begin: the age counts from here
    value::Reason cause = value::Reason::ok;  ///< of get, if `reason` is not_answering: the last failure
    value::Value value;                       ///< get: the value; set, write: that was asked for; pull: true
    value::Value written;                     ///< with Reason::differs: what was written
    value::Value read_back;                   ///< and what was read
    std::optional<value::SlotId> trigger;     ///< the local that caused a `set` to be written
    /// Of exchange: the response, also an exception; empty: none. Then `result` is expired if the request was
    /// not sent, else unknown, and `reason` is why there is none.
    std::vector<std::uint8_t> response;
};

}  // namespace takt::host
