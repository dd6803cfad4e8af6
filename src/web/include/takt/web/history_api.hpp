// The history of a running project for trends.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "takt/host/configuration.hpp"
#include "takt/web/api.hpp"

namespace takt::web {

/// Whether one of the outputs writes the history.
[[nodiscard]] bool has_history(const model::Project& project);

/// The file of the marks of trends, beside the history: "plant.marks.jsonl" of "plant.yaml".
[[nodiscard]] std::string marks_file(const std::string& project_file);

struct HistoryApiOptions {
    std::string project_file;  ///< the history is beside it
    /// Of the running project.
    std::function<host::ConfigurationPtr()> configuration;
};

/// GET /history/series, /history?variable=…&from=&to=&pixels=, /history.csv?variable=…&from=&to=.
/// Times are milliseconds since 1970, or texts as of `takt history`. Bounds: kMostHistoryPixels,
/// kMostHistoryVariables, kMostHistoryRows.
[[nodiscard]] std::vector<ApiRoute> history_routes(const HistoryApiOptions& options);

inline constexpr std::size_t kMostHistoryPixels = 4000;
inline constexpr std::size_t kMostHistoryVariables = 64;
inline constexpr std::size_t kMostHistoryRows = 1'000'000;
inline constexpr std::size_t kMostHistoryBytes = std::size_t{64} << 20;  ///< of a CSV table

}  // namespace takt::web
