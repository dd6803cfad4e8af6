// Statistics of the poller, and the interface of its observers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "takt/base/inplace_vector.hpp"
#include "takt/base/time.hpp"
#include "takt/bus/counters.hpp"
#include "takt/bus/transaction.hpp"
#include "takt/poll/availability.hpp"
#include "takt/poll/delay_finding.hpp"
#include "takt/poll/failure_share.hpp"
#include "takt/poll/gap_event.hpp"
#include "takt/poll/noise_finding.hpp"
#include "takt/value/command.hpp"
#include "takt/value/value.hpp"

namespace takt::poll {

enum class DeviceState : std::uint8_t {
    unknown,        ///< no request was sent yet
    answering,      ///< also with exceptions
    not_answering,  ///< `attempts` failures in a row: only probed
    switched_off,   ///< its poll-enable variable is false
    link_down,      ///< the port is not open, the connection not made
};
std::string_view name(DeviceState state);

/// One request of the plan; its reads and its writes together.
struct RequestStatistics {
    bus::TransactionCounters counters;
    std::optional<Duration> period;  ///< as set; zero: as fast as the line allows; nothing: not polled
    /// Times between answered polled reads, from start to start. Failed reads, outages and lost links make
    /// them longer; time in which the device was switched off does not count. count() 0: fewer than two were
    /// answered.
    bus::TimeStatistics real_period;
    Duration recent_period{};   ///< mean of about the last eight
    bool overrun = false;       ///< bus::PeriodMeter::is_late()
    std::uint64_t skipped = 0;  ///< releases that passed while an earlier one was still waiting
    /// Answered transactions that took longer than their C of the proof, which is that with as many requests
    /// in flight as the line has.
    std::uint64_t over_cost = 0;
    /// How often a read ended later than its period plus R after the begin of the read before, without a
    /// failure on the line, and how often its values became older than their proved age with failures, else
    /// their `max_age`, before it was repeated.
    std::uint64_t late_refreshes = 0;
};

/// Durations, within 12.5 %. In memory of fixed size, so that a copy does not allocate.
struct HistogramSnapshot {
    struct Bucket {
        std::uint32_t upper_us = 0;  ///< the longest of them, rounded up
        std::uint32_t count = 0;     ///< at most UINT32_MAX
    };
    std::uint64_t count = 0;
    Duration p50{};
    Duration p99{};
    Duration longest{};  ///< exact
    /// Those with a count, ascending. The last one has all longer times where there are more.
    InplaceVector<Bucket, 64> buckets;
};

/// How often one variable is read, by any request.
struct VariableStatistics {
    Duration period{};                ///< as set; zero: as fast as the line allows
    bus::TimeStatistics real_period;  ///< as of a request
    Duration recent_period{};         ///< mean of about the last eight
    bool overrun = false;             ///< as of a request
};

/// Whether a device answers, and how often it did not.
struct DeviceCondition {
    DeviceState state = DeviceState::unknown;
    /// How often it stopped answering, or its link was lost. It ends with the next answer: a link that comes
    /// back without one does not begin another.
    std::uint64_t outages = 0;
    /// availability.at(t). An outage begins with the first of the failed attempts, or when the link is lost,
    /// and ends with the next answer. Before the link could be opened for the first time it is down too.
    AvailabilityMeter availability;
    value::Reason failure = value::Reason::ok;  ///< of its last transaction; ok: it was answered
    /// Whether it fails often, though it answers.
    FailureShare share{FailureShare::Of::silence};
};

/// What was counted and measured of the transactions with a device.
struct DeviceTraffic {
    bus::TransactionCounters counters;
    std::uint64_t late = 0;  ///< responses that came after their transaction had timed out
    /// Responses that no request had asked for, repetitions included; Framing::tcp: repetitions only.
    std::uint64_t surplus = 0;
    bool shifted = false;  ///< one of them was no repetition: others may have answered earlier requests
    /// A response came that does not belong to the request, and none that does.
    std::uint64_t foreign = 0;  ///< of the time-outs of `counters`
    std::optional<Mismatch> last_foreign;
    /// Only the begin of the response came.
    std::uint64_t cut_short = 0;  ///< of the checksums of `counters`
    std::optional<Mismatch> last_cut_short;
    /// Whether it answers often with exceptions: requests that it has answered otherwise, too.
    FailureShare refusals{FailureShare::Of::refusal};
    std::uint64_t verified = 0;  ///< writes that were read back as written
    std::uint64_t differed = 0;  ///< and those that were not
    Duration recent_time{};      ///< mean of about the last eight times of `counters`
};

struct DeviceStatistics : DeviceCondition, DeviceTraffic {
    std::optional<DelayFinding> delays;  ///< the device is slower than a setting says
    std::optional<NoiseFinding> noise;   ///< before three of its responses, and one in a hundred
    /// Of a device that does not answer and is probed: the end of its back-off. A line with no other request
    /// to send probes earlier.
    std::optional<Instant> next_probe;
    Duration back_off{};  ///< that ends then
};

struct LineStatistics {
    bus::LineCounters counters;
    Duration planned_cycle{};  ///< LinePlan::cycle
    /// Of that round, by the mean times of the attempts of its requests, failed ones and silences included;
    /// zero: nothing was answered yet.
    Duration measured_cycle{};
    /// Part of the time since the link came up that transactions took, silences included.
    double utilization = 0;
    double recent_utilization = 0;  ///< the same of the last five to ten seconds; 0 without a link
    /// availability.at(t). The line is down while its link is down, or while none of its devices answers.
    AvailabilityMeter availability;
};

/// The parts of the time of a line. Empty ones were not measured.
struct LineTimes {
    /// Serial line: the characters of request and response at the bit rate, computed. Of answered ones.
    HistogramSnapshot wire;
    /// From the end of a request to the first byte of its response, over all devices. On a network: the whole
    /// round trip, not with several requests in flight.
    HistogramSnapshot turnaround;
    /// How late this program woke up for the line: the measured part of `host.jitter`.
    HistogramSnapshot host;
};

/// Why a request is sent.
enum class Purpose : std::uint8_t {
    period,        ///< it is due, or has period 0
    trigger,       ///< a start-reading trigger, also once more after a failed attempt
    repetition,    ///< a polled read whose last attempt failed
    probe,         ///< its device does not answer
    trial,         ///< gaps: learn
    write,         ///< a group, or a command alone
    before_write,  ///< the read of a read-modify-write
    read_back,     ///< of a write that is verified
};
std::string_view name(Purpose purpose);

struct Sending {
    Purpose purpose = Purpose::period;
    bool early = false;  ///< of a probe: its back-off has not passed, but nothing is due before it times out
    std::size_t device = 0;
    std::optional<std::size_t> request;       ///< of the plan; nothing: a trial, or a command alone
    std::optional<value::CommandId> command;  ///< that is written alone
};

/// A transaction without a normal response.
struct FailedExchange {
    enum class Kind : std::uint8_t {
        attempt,  ///< of polling, of a write
        probe,    ///< its device does not answer
        relayed,  ///< of a client that shares the line
    };
    Kind kind = Kind::attempt;
    std::optional<std::size_t> device;  ///< nothing: a unit that is no device of the line
    UnitId unit{1};
    wire::RequestShape request;
    bus::Status status = bus::Status::timeout;
    std::uint8_t exception = 0;
    std::optional<Mismatch> instead;  ///< bus::Outcome::instead
    Duration took{};                  ///< from the start of the request
    std::uint16_t attempt = 1;   ///< failures of the device in a row, this one included; at most `attempts`
    std::uint16_t attempts = 1;  ///< after so many the device counts as not answering
    friend bool operator==(const FailedExchange&, const FailedExchange&) = default;
};

/// The write of a group, of set() values or by its trigger, has ended.
struct SettledGroup {
    std::size_t line = 0;
    std::size_t device = 0;
    /// Indices in the device: those that were set since its last write, or all if none was; without those
    /// whose commands have outcomes of their own. Valid during the call.
    std::span<const std::size_t> variables;
    value::CommandResult result = value::CommandResult::done;
    value::Reason reason = value::Reason::ok;
    std::optional<model::LocalIndex> trigger;  ///< that caused the write
};

/// Notified of events for a log or a stream. Called on the poller's thread from inside its members; must not
/// block and must not call the poller.
class PollObserver {
public:
    /// @param failure  the reason of its last transaction; ok: it was answered, or there was none
    virtual void on_device_state(Instant t, std::size_t line, std::size_t device, DeviceState state,
                                 value::Reason failure) = 0;
    /// The real period of a request is longer than the configured one (`overrun`; also while the read is
    /// awaited for more than four periods), or is no longer: it recovered, or another plan replaced the
    /// request.
    virtual void on_overrun(Instant t, std::size_t line, std::size_t request, Duration period, Duration real,
                            bool overrun) = 0;
    /// A group is to be written, but the member `variable` (index in its device) was neither set nor read
    /// yet, and has no default.
    virtual void on_write_waiting(Instant t, std::size_t line, std::size_t request, std::size_t variable) = 0;
    /// The device is slower than a setting of the project says. Called again when the advised value grows.
    virtual void on_delays(Instant /*t*/, std::size_t /*line*/, std::size_t /*device*/,
                           const DelayFinding& /*finding*/) {}
    /// Something was measured of the device that is worth keeping (LinePoller::learnt_times()).
    virtual void on_measured(Instant /*t*/, std::size_t /*line*/, std::size_t /*device*/) {}
    /// LinePoller::lengths_are_off() is true. Once a run.
    virtual void on_lengths_off(Instant /*t*/, std::size_t /*line*/) {}
    /// Noise comes before the responses of the device. Called once.
    virtual void on_noise(Instant /*t*/, std::size_t /*line*/, std::size_t /*device*/,
                          const NoiseFinding& /*finding*/) {}
    /// The device sent a response that no request had asked for, other bytes than the last one. Called once.
    virtual void on_surplus(Instant /*t*/, std::size_t /*line*/, std::size_t /*device*/) {}
    virtual void on_group_settled(Instant /*t*/, const SettledGroup& /*settled*/) {}
    /// Verification: a variable (index in its device) was read back with another value than was written.
    virtual void on_verify_failed([[maybe_unused]] Instant t, [[maybe_unused]] std::size_t line,
                                  [[maybe_unused]] std::size_t device, [[maybe_unused]] std::size_t variable,
                                  [[maybe_unused]] const value::Value& written,
                                  [[maybe_unused]] const value::Value& read) {}
    /// Of a line that learns (gaps: learn).
    virtual void on_learnt(Instant /*t*/, std::size_t /*line*/, const GapEvent& /*event*/) {}
    /// Called before the effects of the failure on its device.
    virtual void on_failed(Instant /*t*/, std::size_t /*line*/, const FailedExchange& /*failed*/) {}
    /// A request was chosen. It is sent next, at this moment unless the line is busy.
    virtual void on_sending(Instant /*t*/, std::size_t /*line*/, const Sending& /*sending*/) {}

protected:
    ~PollObserver() = default;
};

}  // namespace takt::poll
