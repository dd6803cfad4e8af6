// An instrument on its line: asks and listens.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "takt/base/engine.hpp"
#include "takt/model/source.hpp"
#include "takt/source/answer.hpp"
#include "takt/source/reading.hpp"

namespace takt::source {

struct InstrumentCounters {
    std::uint64_t requests = 0;
    std::uint64_t answers = 0;   ///< that fitted
    std::uint64_t timeouts = 0;  ///< questions without one
    std::uint64_t strange = 0;   ///< answers that did not fit, and floods
};

/// Asks the questions of an instrument round by round, or listens to one that talks by itself, and keeps what
/// it measured last.
///
/// Asked: one question at a time; from its sending to the end of its answer at most the time-out. What
/// comes meanwhile and does not fit (the own echo) is skipped. After a time-out everything is dropped until
/// it has been silent for as long (at most ten times), so that a late answer is not taken for that of the
/// next question. Talking by itself: what follows the opening of the line is dropped up to the end of an
/// answer, or up to a pause as long as the time-out, for it may be half of one; a pause inside an answer
/// drops it.
///
/// At most kMostAnswer bytes are kept. One owner, one thread; the settings outlive it.
class InstrumentEngine final : public Engine {
public:
    explicit InstrumentEngine(const model::Instrument& settings);

    void on_link(Instant t, bool up) override;
    void on_bytes(Instant t, Bytes bytes) override;
    void on_tick(Instant t) override;
    [[nodiscard]] Bytes transmit(Instant t) override;
    [[nodiscard]] Instant next_wakeup() const override;

    /// The measurement of that name, which the settings have. Valid as long as the engine.
    [[nodiscard]] const Reading& reading(std::string_view measurement) const;
    [[nodiscard]] const InstrumentCounters& counters() const { return counters_; }

private:
    enum class State : std::uint8_t { down, resting, awaiting, settling };
    struct Named {
        std::string_view name;
        Reading reading;
    };

    void take(Instant t, Bytes bytes);
    void hear_answer(Instant t);
    void hear_talk(Instant t);
    bool hear_one(Instant t);
    void keep(Instant t, const Measurements& found);
    void fail_exchange();
    void drop(std::size_t count);
    void next_exchange(Instant t);
    void settle(Instant t);
    [[nodiscard]] const model::Exchange& current() const { return settings_.exchanges[exchange_]; }

    const model::Instrument& settings_;
    std::vector<Named> readings_;
    InstrumentCounters counters_;
    State state_ = State::down;
    std::size_t exchange_ = 0;
    Instant round_;         // when its first question went out
    Instant asked_;         // when the last one did
    Instant due_ = kNever;  // of the next question, of the time-out, of the end of settling
    Instant settled_;       // at the latest
    Instant last_bytes_;
    bool in_step_ = false;  // talking by itself: the next byte begins an answer
    std::vector<std::uint8_t> buffer_;
};

}  // namespace takt::source
