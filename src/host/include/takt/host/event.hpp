// The events that a host reports to its sessions. docs/architecture.md, "The host".
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>

#include "takt/base/result.hpp"
#include "takt/base/time.hpp"
#include "takt/endpoint/audit_record.hpp"
#include "takt/endpoint/notice.hpp"
#include "takt/host/command.hpp"
#include "takt/poll/gap_event.hpp"
#include "takt/poll/statistics.hpp"
#include "takt/value/store.hpp"
#include "takt/wire/function.hpp"

namespace takt::host {

/// A request of the plan that ran when the event happened, by what identifies it on the wire.
struct RequestKey {
    std::size_t line = 0;
    std::size_t device = 0;
    std::optional<wire::Function> read;
    std::optional<wire::Function> write;
    std::uint16_t start = 0;     ///< on the wire
    std::uint16_t quantity = 0;  ///< on the wire
    friend bool operator==(const RequestKey&, const RequestKey&) = default;
};

/// The value, quality or reason of a slot changed.
struct ValueChanged {
    value::SlotId slot;
    value::Value value;
    value::Quality quality = value::Quality::good;
    value::Reason reason = value::Reason::ok;
    std::optional<Instant> good_at;      ///< when it was last read well, or set
    std::optional<Instant> sampled_at;   ///< of that read, the begin: the age counts from here
    std::optional<Instant> good_before;  ///< the begin of the last good read before: it changed after that
    std::uint64_t batch = 0;             ///< equal for slots that changed together
};

struct DeviceStateChanged {
    std::size_t line = 0;
    std::size_t device = 0;
    poll::DeviceState state = poll::DeviceState::unknown;
    value::Reason failure = value::Reason::ok;  ///< not_answering: of its last transaction
    /// A device that stops and begins to answer again and again does not fill the lists of events.
    enum class Shown : std::uint8_t {
        each,     ///< the change has a message
        often,    ///< the message says that the device changes often
        counted,  ///< no message
        steady,   ///< no change: the device, which has changed often, has this state for some time
        total,    ///< no change: the run ends, or its project changes
    };
    Shown shown = Shown::each;
    std::uint64_t changes = 0;  ///< not `each`: up to now
    Duration in{};              ///< from the first of them to the last
};

/// A port or a connection was opened, was lost, or could not be opened. Attempts that fail as the one before
/// are counted: there is an event for them after a pause that grows.
struct LinkChanged {
    std::size_t line = 0;
    bool up = false;
    std::optional<Error> why;    ///< of a link that is down
    std::uint64_t repeated = 0;  ///< no change: so many attempts failed again
    Duration in{};               ///< in that time
};

/// The real period of a request became longer than the configured one, or keeps to it again.
struct PeriodOverrun {
    RequestKey request;
    Duration period{};
    Duration real{};
    bool overrun = false;  ///< false: it holds again
};

/// A device is slower than a setting of the project says. Published again when the advised value grows.
struct DelaysFound {
    std::size_t line = 0;
    std::size_t device = 0;
    poll::DelayFinding finding;
};

/// Noise comes before the responses of a device. Published once.
struct NoiseFound {
    std::size_t line = 0;
    std::size_t device = 0;
    poll::NoiseFinding finding;
};

/// A device sent a response that no request had asked for, so earlier ones may have answered other requests.
/// Their values are uncertain now. Published once.
struct SurplusFound {
    std::size_t line = 0;
    std::size_t device = 0;
};

/// A group is to be written, but one member was neither set nor read yet and has no default.
struct WriteWaiting {
    RequestKey request;
    std::size_t variable = 0;  ///< index in its device
};

/// A variable was read back as another value than was written.
struct VerifyFailed {
    value::SlotId slot;
    value::Value written;
    value::Value read_back;
};

struct GapLearnt {
    std::size_t line = 0;
    poll::GapEvent gap_event;
};

/// The outcome of a command of any session, or of the writing of a group that no session waits for.
struct WriteFinished {
    Outcome outcome;        ///< id 0: no command
    SessionId session = 0;  ///< that submitted it
};

/// Something that a person should know; `code` is the key of its text (src/text).
using Notice = endpoint::Notice;

/// Another project runs. Events that follow have indices of that generation.
struct ConfigurationChanged {
    std::uint32_t generation = 0;
};

/// A write or a refusal at an endpoint with an audit log. endpoint::audit_line() gives the line of the log.
struct AuditRecorded {
    endpoint::AuditRecord record;
};

/// Changes of values that came faster than the I/O thread could publish them.
struct EventsLost {
    std::uint64_t count = 0;
};

struct Event {
    std::uint64_t number = 0;  ///< 0, 1, 2, … without holes
    std::uint32_t generation = 0;
    Instant t;
    std::variant<ValueChanged, DeviceStateChanged, LinkChanged, PeriodOverrun, WriteWaiting, VerifyFailed,
                 GapLearnt, WriteFinished, Notice, ConfigurationChanged, AuditRecorded, EventsLost,
                 DelaysFound, NoiseFound, SurplusFound>
        body;
};

}  // namespace takt::host
