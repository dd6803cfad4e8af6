// Queries of a history.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "takt/base/result.hpp"
#include "takt/store/history_damage.hpp"
#include "takt/store/history_sample.hpp"

namespace takt::store {

/// [from, to)
struct HistoryRange {
    std::int64_t from_ns = 0;
    std::int64_t to_ns = 0;
};

struct HistoryPoint {
    std::int64_t time_ns = 0;
    double value = 0;  ///< of a bool 0 or 1; integers beyond 2^53 are rounded
    /// The poll before. Unknown where the point comes from a roll-up.
    std::optional<std::int64_t> previous_ns;
};

/// What is drawn in one column of pixels (M4: first, minimum, maximum, last). Only numbers of quality good or
/// uncertain count.
struct HistoryPixel {
    std::size_t index = 0;      ///< column: 0 to pixels - 1
    HistoryRange range;         ///< its times
    std::uint64_t samples = 0;  ///< with a time in this column, whichever their quality
    HistoryPoint first{};
    HistoryPoint min{};
    HistoryPoint max{};
    HistoryPoint last{};
    bool has_value = false;  ///< false: the four points are not set
};

/// A time in which the value was not good.
struct HistoryBadSpan {
    HistoryRange range;
    value::Quality quality = value::Quality::bad;
    value::Reason reason = value::Reason::ok;
};

/// A series in a range, as a screen needs it.
struct HistoryPicture {
    HistoryRange range;
    std::vector<HistoryPixel> pixels;     ///< those with samples, in order of time
    std::optional<HistorySample> before;  ///< the last sample before the range: its value holds
    std::optional<HistoryPoint> held;     ///< the number that holds at the begin of the range
    std::vector<HistoryBadSpan> bad;      ///< in order of time; neighbours of one reason are one span
    std::vector<HistoryGap> gaps;         ///< that overlap the range, in order of time
    std::uint64_t samples = 0;            ///< in the range
    std::uint64_t damaged_chunks = 0;     ///< and rows of the log: their samples are missing
    // Of the numbers of quality good or uncertain, the values that hold at the begin of the range included.
    std::optional<double> min;
    std::optional<double> max;
    std::optional<double> mean;       ///< weighted with time; each value holds until the next sample or gap
    double good_share = 0;            ///< part of the range's time, from the first poll on, with quality good
    std::int64_t known_until_ns = 0;  ///< the last commit: no value holds beyond it
    std::size_t rolled_up = 0;        ///< roll-ups that were used instead of samples
};

struct HistorySeriesInfo {
    SeriesId id;
    HistorySeries series;
};

/// Reads a history while another process or thread writes it. Each call sees one state of the file. One
/// thread.
class HistoryReader {
public:
    /// @returns not_found, unsupported, malformed, cannot_open, io_failed
    [[nodiscard]] static Result<HistoryReader> open(const std::string& path);

    HistoryReader(HistoryReader&&) noexcept;
    HistoryReader& operator=(HistoryReader&&) noexcept;
    ~HistoryReader();

    /// All series, by name.
    [[nodiscard]] Result<std::vector<HistorySeriesInfo>> series();
    /// Whether a variable that series() does not return may be one of a damaged row. Then damage() has it.
    [[nodiscard]] bool is_lost(std::string_view variable);
    /// The times of the oldest and newest sample of a series; nothing: it has none.
    [[nodiscard]] Result<std::optional<HistoryRange>> extent(SeriesId series);
    /// The newest sample before a time.
    [[nodiscard]] Result<std::optional<HistorySample>> before(SeriesId series, std::int64_t time_ns);
    /// The gaps that overlap the range, in order of time.
    [[nodiscard]] Result<std::vector<HistoryGap>> gaps(const HistoryRange& range);
    /// The samples in the range, in order of time; equal times in the order of arrival.
    /// @param sample  called for each; false ends the query
    [[nodiscard]] Result<void> read(SeriesId series, const HistoryRange& range,
                                    const std::function<bool(const HistorySample&)>& sample);
    /// @param pixels  1 to 100,000
    /// @returns out_of_range: an empty range, or the number of pixels
    [[nodiscard]] Result<HistoryPicture> picture(SeriesId series, const HistoryRange& range,
                                                 std::size_t pixels);

    /// The damage that the calls since open() met, each damaged row once. Samples that are missing in their
    /// answers are in its times, if these are known. A call that uses roll-ups does not read their chunks.
    [[nodiscard]] const std::vector<HistoryDamage>& damage() const;

private:
    struct State;
    explicit HistoryReader(std::unique_ptr<State> state);

    std::unique_ptr<State> state_;
};

}  // namespace takt::store
