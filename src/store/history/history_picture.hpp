// Puts a picture together from samples and roll-ups in order of time.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "history/history_summary.hpp"
#include "takt/store/history_reader.hpp"

namespace takt::store {

class PictureBuilder {
public:
    /// @param gaps  by their first times; must outlive the builder
    PictureBuilder(const HistoryRange& range, std::size_t pixels, std::span<const HistoryGap> gaps);

    [[nodiscard]] std::size_t pixel_of(std::int64_t time_ns) const;
    /// Whether a roll-up can be added: within the range and one pixel, and of one quality and reason.
    [[nodiscard]] bool fits(const HistorySummary& summary) const;

    /// The sample whose value holds at the begin of the range; before add().
    void begin(const HistorySample& before);
    /// Samples or roll-ups that fit, in order of time. Samples outside the range are left out.
    void add(const HistorySample& sample);
    void add(const HistorySummary& summary);
    /// @param known_until_ns  no value holds beyond it
    [[nodiscard]] HistoryPicture finish(std::int64_t known_until_ns);

private:
    void hold(std::int64_t until_ns);
    void put_bad(std::int64_t from_ns, std::int64_t to_ns);
    void add_to_pixel(const HistorySummary& summary);

    HistoryRange range_;
    std::size_t pixels_;
    std::span<const HistoryGap> gaps_;
    HistoryPicture picture_;
    std::optional<HistorySummary> last_;  // the last piece: it holds
    std::optional<std::int64_t> polled_;  // from when on the variable was polled, not before the range
    double area_ = 0;
    double drawn_s_ = 0;
    double good_s_ = 0;
};

}  // namespace takt::store
