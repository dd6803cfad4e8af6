// The engine of an instrument on its line.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "takt/base/engine.hpp"
#include "takt/base/result.hpp"
#include "takt/endpoint/answer.hpp"
#include "takt/endpoint/answer_scanner.hpp"
#include "takt/endpoint/reading.hpp"
#include "takt/model/instrument.hpp"

namespace takt::endpoint {

struct InstrumentCounters {
    std::uint64_t requests = 0;
    std::uint64_t answers = 0;   ///< that matched
    std::uint64_t timeouts = 0;  ///< requests without an answer
    std::uint64_t strange = 0;   ///< answers that did not match, and floods
    std::uint64_t resets = 0;    ///< restarts that were recognised while the link was up
    std::uint64_t starts = 0;    ///< after which it was ready
    std::uint64_t failed_starts = 0;
    std::uint64_t written = 0;     ///< commands that were confirmed
    std::uint64_t refused = 0;     ///< commands that were refused, or read back differently
    std::uint64_t unanswered = 0;  ///< commands without an answer in time
    std::uint64_t busy = 0;        ///< commands that found the queue full
    std::uint64_t restored = 0;    ///< settings that were sent again
};

/// The numbers are those of the measurement `state`.
enum class InstrumentState : std::uint8_t {
    ready,         ///< its start is complete
    starting,      ///< start commands or settings are being sent
    start_failed,  ///< the next start follows after start_retry
    silent,        ///< it does not answer
    down,          ///< the link is down
};
[[nodiscard]] std::string_view name(InstrumentState state);

/// The result of a command.
enum class WriteResult : std::uint8_t {
    done,
    refused,    ///< by the instrument
    differs,    ///< the answer or the value that was read back has another value
    no_answer,  ///< it may have been executed
    expired,    ///< it was not confirmed in time; if it was not sent yet, it is not sent any more
};

/// What happened to an instrument, for the log.
struct InstrumentEvent {
    enum class Kind : std::uint8_t {
        reset_line,       ///< the line of a reset was received
        silence_ended,    ///< it answers again
        ready,            ///< the start is complete; `number` settings were sent again
        start_failed,     ///< by start command `number`, for the reason `result`
        restore_failed,   ///< a start failed by the setting of command `number`
        silent,           ///< `number` requests in a row were not answered
        write_failed,     ///< command `number` with the value `text`
        setting_dropped,  ///< the value `text` of command `number` was refused after a start
    };
    Kind kind{};
    std::size_t number = 0;
    WriteResult result{};
    std::string_view text{};
};

/// Sends the requests of an instrument in rounds, or receives from one that sends by itself, and stores the
/// last measurements. Sends its start commands after each start, and commands with values between the
/// requests.
///
/// One request is in flight at a time. Its time-out runs from the request to the end of the answer. Bytes
/// that do not match (the own echo) are skipped. After a time-out all bytes are dropped until the line was
/// silent for one time-out, at most for ten of them. So a late answer is not taken for the next one.
///
/// Without requests: after the line opens, bytes are dropped up to the end of an answer or up to a pause
/// of one time-out, because the first answer may be incomplete. A pause inside an answer drops it.
///
/// A start begins when the link comes up, at the line of a reset that no request asked for, and at the first
/// answer after `silent_after` unanswered requests. Then the start commands are sent, then the last confirmed
/// values of the commands with `restore`, in the order of the settings; then requests and commands go on. If
/// one of them is not answered or a start command is refused, after its attempts, the start has failed and
/// begins again after `start_retry`. Measurements are taken and commands are sent only when it is complete.
///
/// Commands are executed one by one, in the order of submit(). A command that is interrupted by a start is
/// sent again afterwards if it has `restore`; otherwise its result is no_answer.
///
/// At most kMostAnswer bytes are buffered. One owner, one thread; the settings outlive it.
class InstrumentEngine final : public Engine {
public:
    using Done = std::function<void(WriteResult)>;
    using Observer = std::function<void(Instant, const InstrumentEvent&)>;
    /// Commands that may wait, with the one in flight.
    static constexpr std::size_t kMostCommands = 32;

    explicit InstrumentEngine(const model::Instrument& settings);

    void on_link(Instant t, bool up) override;
    void on_bytes(Instant t, Bytes bytes) override;
    void on_tick(Instant t) override;
    [[nodiscard]] Bytes transmit(Instant t) override;
    /// With the link down: the next expiry of a command.
    [[nodiscard]] Instant next_wakeup() const override;

    /// Queues a command.
    /// @param command  index into the settings
    /// @param text     its value, of command_text()
    /// @param done     called once, later, never from inside submit(); must not call the engine. May be empty
    /// @returns queue_full; timed_out if it is known not to answer: silent, the start has failed, or the link
    ///          has been down for the time in which the command expires. Then `done` is not called
    [[nodiscard]] Result<void> submit(Instant t, std::size_t command, std::string text, Done done);

    /// When the next waiting command expires. on_tick() ends it then, also with the link down.
    [[nodiscard]] Instant next_expiry() const;

    void set_observer(Observer observer) { observer_ = std::move(observer); }

    /// The measurement of that name, which must exist in the settings. Valid as long as the engine.
    [[nodiscard]] const Reading& reading(std::string_view measurement) const;
    [[nodiscard]] const InstrumentCounters& counters() const { return counters_; }
    [[nodiscard]] InstrumentState state() const;

private:
    enum class Phase : std::uint8_t { down, starting, restoring, start_failed, ready };
    enum class Wire : std::uint8_t { resting, awaiting, settling };
    enum class Job : std::uint8_t { none, exchange, start, setting, command };
    enum class Step : std::uint8_t { write, read_back };
    struct Named {
        std::string_view name;
        Reading reading;
    };
    struct Pending {
        std::size_t command = 0;
        std::string text;
        Done done;  // empty once the result was given
        Instant expires;
        bool expired = false;
    };

    void take(Instant t, Bytes bytes);
    void take_one(Instant t, std::uint8_t byte);
    void take_sent(Instant t, Bytes bytes);
    bool take_one_sent(Instant t);
    void drop(std::size_t count);
    void keep(Instant t, const Measurements& found);

    void begin_start(Instant t);
    void on_reset_line(Instant t);
    void interrupt(Instant t);
    void settle(Instant t);
    void on_answer(Instant t, const Measurements& found);
    void on_exchange(Instant t, const Measurements& found);
    void on_write_answer(Instant t, const Measurements& found);
    void on_refused(Instant t);
    void on_timeout(Instant t);
    void next_exchange(Instant t);
    void fail_start(Instant t, WriteResult why);
    void finish_write(Instant t, WriteResult result);
    void conclude(Instant t, Pending& pending, WriteResult result);
    [[nodiscard]] bool is_deaf(Instant t, Duration expires);
    void expire(Instant t);

    void choose(Instant t);
    void choose_ready(Instant t);
    [[nodiscard]] bool writes() const { return job_ == Job::setting || job_ == Job::command; }
    [[nodiscard]] bool has_start() const;
    [[nodiscard]] const model::InstrumentCommand& command() const { return settings_.commands[command_]; }
    [[nodiscard]] const std::string& text() const;
    [[nodiscard]] const model::Confirmation& confirmation() const;
    Bytes send(Instant t, std::string bytes, const model::AnswerFormat* answer,
               const model::AnswerFormat* refused, Duration timeout);
    void notify(Instant t, const InstrumentEvent& event) const;

    const model::Instrument& settings_;
    Observer observer_;
    std::vector<Named> readings_;
    std::vector<std::optional<std::string>> confirmed_;  // by command: the last confirmed value
    std::deque<Pending> queue_;                          // the first one may be in flight
    InstrumentCounters counters_;
    Phase phase_ = Phase::down;
    Wire wire_ = Wire::resting;
    Job job_ = Job::none;
    Step step_ = Step::write;
    std::size_t exchange_ = 0;
    std::size_t start_ = 0;     // next start command
    std::size_t command_ = 0;   // of a setting or a command; the next setting
    std::size_t restored_ = 0;  // in this start
    unsigned attempts_ = 0;     // of the job's step
    unsigned unanswered_ = 0;   // requests in a row
    bool silent_ = false;
    bool was_command_ = false;  // the last job; then a due exchange goes first
    Instant ready_at_;          // the next request is not earlier
    Instant round_ = kNever;    // the next exchange is not earlier
    Instant round_begun_;
    Instant asked_;         // time of the last request
    Instant due_ = kNever;  // time-out, or end of the silence
    Instant settled_;       // latest end of the wait for silence
    Instant last_bytes_;
    std::optional<Instant> down_since_;
    bool in_step_ = false;  // without requests: the next byte begins an answer
    std::string sent_;
    AnswerScanner answer_;
    AnswerScanner refused_;
    AnswerScanner reset_;
    std::vector<std::uint8_t> buffer_;  // without requests
};

}  // namespace takt::endpoint
