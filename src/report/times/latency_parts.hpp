// What the text, the JSON and the CSV of response times share.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "takt/capture/latency.hpp"

namespace takt::report {

struct Percentile {
    std::string_view name;
    double percent = 0;
};
inline constexpr std::array kPercentiles{Percentile{"p50", 50}, Percentile{"p90", 90}, Percentile{"p99", 99},
                                         Percentile{"p99.9", 99.9}, Percentile{"p99.99", 99.99}};

/// The two ends of a series; empty where they do not separate series. A serial line has the number of its
/// interface as server.
[[nodiscard]] std::string client_text(const capture::SeriesKey& key, const capture::Grouping& grouping);
[[nodiscard]] std::string server_text(const capture::SeriesKey& key, const capture::Grouping& grouping);

/// "2:5 3:1": exceptions by code; empty: none.
[[nodiscard]] std::string exceptions_text(const capture::Series& series);

}  // namespace takt::report
