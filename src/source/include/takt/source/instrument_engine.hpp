// The engine of an instrument on its line.
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
    std::uint64_t answers = 0;   ///< that matched
    std::uint64_t timeouts = 0;  ///< requests without an answer
    std::uint64_t strange = 0;   ///< answers that did not match, and floods
};

/// Sends the requests of an instrument in rounds, or receives from one that sends by itself, and stores the
/// last measurements.
///
/// With requests: one request is in flight at a time. Its time-out runs from the request to the end of the
/// answer. Bytes that do not match (the own echo) are skipped. After a time-out all bytes are dropped until
/// the line was silent for one time-out, at most for ten of them. So a late answer is not taken for the next
/// one. Without requests: after the line opens, bytes are dropped up to the end of an answer or up to a pause
/// of one time-out, because the first answer may be incomplete. A pause inside an answer drops it.
///
/// At most kMostAnswer bytes are buffered. One owner, one thread; the settings outlive it.
class InstrumentEngine final : public Engine {
public:
    explicit InstrumentEngine(const model::Instrument& settings);

    void on_link(Instant t, bool up) override;
    void on_bytes(Instant t, Bytes bytes) override;
    void on_tick(Instant t) override;
    [[nodiscard]] Bytes transmit(Instant t) override;
    [[nodiscard]] Instant next_wakeup() const override;

    /// The measurement of that name, which must exist in the settings. Valid as long as the engine.
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
    Instant round_;         // time of the round's first request
    Instant asked_;         // time of the last request
    Instant due_ = kNever;  // next request, time-out, or end of the silence
    Instant settled_;       // latest end of the wait for silence
    Instant last_bytes_;
    bool in_step_ = false;  // without requests: the next byte begins an answer
    std::vector<std::uint8_t> buffer_;
};

}  // namespace takt::source
