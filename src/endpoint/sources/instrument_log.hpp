// The log lines of an instrument.
#pragma once

#include <map>
#include <optional>
#include <tuple>

#include "takt/base/log.hpp"
#include "takt/base/result.hpp"
#include "takt/endpoint/instrument_engine.hpp"
#include "takt/model/instrument.hpp"

namespace takt::endpoint {

/// Writes one line for each change of the link and each event. A line of the same kind as an earlier one of
/// the last kWindow (a failed write: of the same command, with any value) is left out and counted; the count
/// is written before the next one. The settings outlive it. One owner, one thread.
class InstrumentLog {
public:
    static constexpr Duration kWindow = std::chrono::seconds(60);

    InstrumentLog(const Log& log, const model::Instrument& settings) : log_(log), settings_(settings) {}

    void on_link(Instant t, bool up, const std::optional<Error>& why);
    void on_event(Instant t, const InstrumentEvent& event);

private:
    struct Written {
        std::optional<Instant> at;
        std::uint64_t omitted = 0;
    };
    /// Kind, number, result.
    using Key = std::tuple<int, std::size_t, int>;

    [[nodiscard]] bool admit(Instant t, const Key& key);

    Log log_;
    const model::Instrument& settings_;
    std::map<Key, Written> written_;
};

}  // namespace takt::endpoint
