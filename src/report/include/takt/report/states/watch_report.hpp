// Values that are read again and again: each sample as lines, as JSON, as a table, and the statistics.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "takt/base/result.hpp"
#include "takt/bus/counters.hpp"
#include "takt/file/json.hpp"
#include "takt/model/device.hpp"
#include "takt/plan/plan.hpp"
#include "takt/report/drawing/panel.hpp"
#include "takt/report/drawing/texts.hpp"
#include "takt/report/states/live_screen.hpp"
#include "takt/value/value.hpp"

namespace takt::report {

struct WatchedValue {
    value::Value value;
    std::optional<Instant> read_at;  ///< nothing: not read yet
    std::uint64_t changes = 0;
    bool changed = false;  ///< by the last sample; the first one changes every value
    std::string trouble;   ///< why the last sample has no value, as reason_text(); empty: it has one

    void update(value::Value read, Instant t);
};

/// A request of a sample that got no values.
struct FailedRequest {
    const plan::Request* request = nullptr;
    Error error;
};

struct WatchStatistics {
    std::uint64_t samples = 0;
    std::uint64_t errors = 0;
    bus::TimeStatistics time;  ///< of the requests that got values
};

/// Reports the samples of some variables. One owner, one thread.
class WatchReport {
public:
    /// @param variables     must outlive the report
    /// @param only_changes  lines and JSON leave out values that did not change
    /// @param target        for the heading of the display
    WatchReport(const Texts& texts, std::span<const model::Variable> variables, bool only_changes,
                std::string target = {})
        : texts_(texts), variables_(variables), only_changes_(only_changes), target_(std::move(target)) {}

    /// "12:00:00.123 holding 5 = 17" for each value of the sample.
    /// @param values  one for each variable, here and below
    [[nodiscard]] std::string lines(const std::string& stamp, std::span<const WatchedValue> values) const;

    /// "12:00:00.123 0x03 5..9: MESSAGE", without line end.
    [[nodiscard]] std::string failure_line(const std::string& stamp, const FailedRequest& failed) const;

    /// The event `sample`; null where there is nothing to report.
    /// @param time   the moment, as text
    /// @param since  the time since the first sample
    [[nodiscard]] file::Json sample_json(const std::string& time, Duration since, std::uint64_t sample,
                                         std::span<const WatchedValue> values,
                                         std::span<const FailedRequest> failures) const;

    /// The display: target and statistics, the values that were not read, the others, and the failures of the
    /// last sample in full. The lines fit the screen.
    /// @param selection  its `first` and `page` follow what is shown
    [[nodiscard]] std::vector<std::string> table(const Screen& screen, Instant now,
                                                 std::span<const WatchedValue> values,
                                                 const WatchStatistics& statistics,
                                                 std::span<const FailedRequest> failures,
                                                 LiveSelection& selection) const;

    [[nodiscard]] std::string statistics_text(const WatchStatistics& statistics) const;

private:
    [[nodiscard]] std::string heading(const WatchStatistics& statistics,
                                      std::span<const FailedRequest> failures) const;
    [[nodiscard]] std::string value_text(std::size_t index, const WatchedValue& watched) const;
    [[nodiscard]] bool is_reported(const WatchedValue& watched) const;

    Texts texts_;
    std::span<const model::Variable> variables_;
    bool only_changes_;
    std::string target_;
};

/// An error of a request in few words: "time-out", "exception 2".
[[nodiscard]] std::string reason_text(const Texts& texts, const Error& error);

/// The event `error`: no connection was made.
[[nodiscard]] file::Json watch_error_json(const Texts& texts, const Error& error);

/// The event `summary`.
[[nodiscard]] file::Json watch_summary_json(const WatchStatistics& statistics);

}  // namespace takt::report
