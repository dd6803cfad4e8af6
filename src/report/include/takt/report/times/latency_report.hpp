// The response times of a capture or a target as text, JSON, CSV and in the form of cyclictest.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "takt/capture/analysis.hpp"
#include "takt/capture/capture_reader.hpp"
#include "takt/capture/latency.hpp"
#include "takt/client/load.hpp"
#include "takt/file/json.hpp"
#include "takt/model/device.hpp"
#include "takt/report/drawing/texts.hpp"

namespace takt::report {

/// How the exchanges were made, if the program made them.
struct LoadRun {
    const client::LoadOptions& options;
    const client::LoadCounts& counts;
};

/// A capture that was read, or a target that was measured.
struct LatencyRun {
    std::string file;  ///< or the target
    const capture::LatencyReport& report;
    capture::PacketCounts packets;  ///< of a capture, as the next two; of a target the two times alone
    capture::TcpCounts tcp;
    capture::SerialCounts serial;
    std::optional<LoadRun> load = {};  ///< nothing: a capture
};

/// The round trip of a TCP device for its project (`round_trip`), as measured with so many in flight.
/// Nothing: a serial line, several connections, fewer than 100 responses, or requests without a response in
/// time.
[[nodiscard]] std::optional<model::MeasuredRoundTrip> round_trip_of(const LatencyRun& run);

/// What the exchanges show about the limit of LatencyConfig.
struct LatencyVerdict {
    std::uint64_t exchanges = 0;  ///< answered and unanswered ones
    std::uint64_t exceeded = 0;
    double bound = 1;  ///< with 95 % confidence the share that exceeds the limit is below it
    [[nodiscard]] bool kept() const { return exchanges > 0 && exceeded == 0; }
};
[[nodiscard]] LatencyVerdict latency_verdict(const capture::LatencyReport& report);

/// The report: series, total, the slowest exchanges, notes about the capture, and the verdict if there is a
/// limit.
/// @param columns  of the terminal; SIZE_MAX: none
[[nodiscard]] std::string latency_text(const Texts& texts, const LatencyRun& run, std::size_t columns);

/// One sentence or two, with the bound in words; ends without a line end. There is a limit.
[[nodiscard]] std::string latency_verdict_text(const Texts& texts, const capture::LatencyReport& report);

/// Requests in a second that a load sent; 0 before the first instant.
[[nodiscard]] double sent_per_second(const client::LoadCounts& counts);

/// One object; times in milliseconds. @param texts  for the verdict in words
[[nodiscard]] file::Json latency_json(const Texts& texts, const LatencyRun& run);

/// A row for each series and one for the total, behind a heading.
[[nodiscard]] std::string latency_csv(const capture::LatencyReport& report);

/// The counts of microseconds as cyclictest prints them with -h.
[[nodiscard]] std::string latency_histogram(const capture::LatencyReport& report);

/// What is wrong with a capture: place, value, what is allowed.
[[nodiscard]] std::string capture_error_text(const Texts& texts, const std::string& file,
                                             const capture::CaptureError& error);

/// "10.0.0.2:502", "[fe80::1]:502"; "10.0.0.2" without a port.
[[nodiscard]] std::string endpoint_text(const capture::Endpoint& endpoint);

/// "33,000", in Russian and Ukrainian with a no-break space.
[[nodiscard]] std::string grouped_number(std::uint64_t number, text::Language language);

}  // namespace takt::report
