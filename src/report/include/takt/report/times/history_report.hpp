// The history of variables as text, JSON and CSV.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "takt/file/json.hpp"
#include "takt/report/drawing/texts.hpp"
#include "takt/store/history_reader.hpp"

namespace takt::report {

/// A variable in a range.
struct HistoryView {
    store::HistorySeries series;
    store::HistoryPicture picture;
    std::optional<store::HistorySample> last;  ///< the newest sample before the end of the range
};

/// The cause in the language of `texts`.
[[nodiscard]] std::string gap_text(const Texts& texts, store::GapCause cause);

/// A row for each variable (newest value, min, mean, max, share of good time), then gaps and bad times.
/// @param columns  of a terminal: a small picture of each variable is added; SIZE_MAX: no terminal
[[nodiscard]] std::string history_text(const Texts& texts, const std::vector<HistoryView>& views,
                                       std::size_t columns);

/// {"from", "to", "variables": […], "gaps": […], "damage": […]} with the points of each pixel and bad times.
/// @param damage  as HistoryReader::damage()
[[nodiscard]] file::Json history_json(const std::vector<HistoryView>& views, const store::HistoryRange& range,
                                      std::span<const store::HistoryDamage> damage);

/// A heading and a line for each damage: variable, times, part of the file, number of samples; empty without
/// damage.
[[nodiscard]] std::string history_damage_text(const Texts& texts,
                                              std::span<const store::HistoryDamage> damage);

/// The variables of a history, with the times of their oldest and newest samples.
struct HistoryListEntry {
    store::HistorySeries series;
    std::optional<store::HistoryRange> extent;
};
[[nodiscard]] std::string history_list_text(const Texts& texts, const std::vector<HistoryListEntry>& entries,
                                            std::size_t columns);
[[nodiscard]] file::Json history_list_json(const std::vector<HistoryListEntry>& entries,
                                           std::span<const store::HistoryDamage> damage);

/// The heading of a CSV table of samples, with its line end.
[[nodiscard]] std::string history_csv_heading();
/// A sample as a row. Decimal point, cells quoted as in RFC 4180.
[[nodiscard]] std::string history_csv_row(const store::HistorySeries& series,
                                          const store::HistorySample& sample);
/// Damage as a row: the first time of missing samples, no value, quality "damaged", and as the reason the
/// part of the file and the last time. Cells that are unknown are empty.
[[nodiscard]] std::string history_csv_row(const store::HistoryDamage& damage);

}  // namespace takt::report
