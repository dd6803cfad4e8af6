// The way from responses to the values of a line.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "line/tables.hpp"
#include "reads/read_schedule.hpp"
#include "reads/split.hpp"
#include "takt/base/result.hpp"
#include "takt/bus/transaction.hpp"
#include "takt/value/store.hpp"
#include "takt/wire/prepared_request.hpp"
#include "takt/wire/response_view.hpp"
#include "writes/written_values.hpp"

namespace takt::poll {

/// What a value that was not read shows.
enum class Shown : std::uint8_t {
    last,     ///< the last value
    initial,  ///< its initial value; with hold_last, or without one, the last value
};

/// Publishes the values of a line to the store: what a response carries, what was written where nothing reads
/// it, and the quality of values that were not read. The values of one response change together.
///
/// It owns the parts of values that are longer than a request. It reads the tables of the line and the
/// schedule of the reads, and changes none of them. Allocates in set_requests(), and until the longest list
/// of updates was published once. One owner, one thread; what it is given must outlive it.
class ValuePublisher {
public:
    ValuePublisher(const LineTables& tables, const ReadSchedule& reads, WrittenValues& written,
                   value::Store& store)
        : tables_(tables), reads_(reads), written_(written), store_(store) {}

    /// The requests of the line are new ones. Parts that were read are dropped.
    void set_requests();
    /// The values that are read in parts.
    [[nodiscard]] const SplitValues& splits() const { return splits_; }
    /// Drops the parts of these values that were read.
    void forget_parts(std::span<const std::size_t> variables);

    /// The request has got a response. Of its variables those that the response carries are published.
    /// @param outcome  of the read: the planned one, a wider one, or a part of it
    /// @param sent     what it reads
    /// @param round    ReadSchedule::round() at the response
    /// @param quality  uncertain: the response may be that to another request. Parts are dropped, and nothing
    ///                 is written that depends on the values
    void take(const bus::Outcome& outcome, std::size_t request, const wire::RequestShape& sent,
              const ReadRound& round, value::Quality quality = value::Quality::good);

    /// A value was read back after its write. publish() follows, for all values of the write.
    /// @param function  of the read
    void read_back(std::size_t variable, wire::Function function, const Result<value::Value>& value);
    /// @param sampled_at  the begin of the read whose values follow
    /// @param quality     as of take()
    void begin(Instant sampled_at, value::Quality quality = value::Quality::good) {
        updates_.clear();
        sampled_at_ = sampled_at;
        quality_ = quality;
    }
    void publish(Instant t) { store_.apply(t, updates_); }

    /// Variables that nothing reads show the value last written.
    void show_written(Instant t, std::span<const std::size_t> variables);

    /// The values were not read. Variables without a read keep theirs.
    /// @param quality  uncertain: at most; a bad value stays bad
    void degrade(Instant t, std::span<const std::size_t> variables, value::Quality quality,
                 value::Reason reason, Shown shown);

    /// Published last; valid until the next call.
    [[nodiscard]] std::span<const value::Update> updates() const { return updates_; }

private:
    [[nodiscard]] const VariableRun& variable(std::size_t v) const { return tables_.variables[v]; }
    void add_parts(std::size_t request);
    void take_value(std::size_t request, const wire::RequestShape& sent, const wire::ResponseView& response,
                    std::size_t variable);
    void take_part(std::size_t request, DataAddress start, const wire::ResponseView& response,
                   std::size_t variable);
    void note_value(std::size_t variable, const Result<value::Value>& value, Instant sampled_at);

    LineTables tables_;
    const ReadSchedule& reads_;
    WrittenValues& written_;
    value::Store& store_;
    SplitValues splits_;
    value::Quality quality_ = value::Quality::good;
    ReadRound round_;                     // likewise of take()
    Instant sampled_at_;                  // the begin of the read that is taken
    std::vector<value::Update> updates_;  // scratch, so that a response allocates nothing
};

}  // namespace takt::poll
