// What this computer adds to an exchange, as text and as JSON.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "takt/base/latency_statistics.hpp"
#include "takt/client/measure.hpp"
#include "takt/file/json.hpp"
#include "takt/report/drawing/texts.hpp"

namespace takt::report {

/// Of each subject (client::Subject, in their order) what was measured; nothing: it was not.
using SelftestRun = std::array<std::optional<LatencyStatistics>, client::kSubjects.size()>;

struct SelftestReport {
    SelftestRun idle;
    SelftestRun loaded;
    unsigned load_threads = 0;
};

/// The word for JSON: "wake_up", "loopback", "pty".
[[nodiscard]] std::string_view name(client::Subject subject);

/// A table of both runs, a histogram of each measurement under load, and the `host:` line for a project where
/// all of them were measured.
[[nodiscard]] std::string selftest_text(const Texts& texts, const SelftestReport& report);

/// One object (docs/commands/selftest.md).
[[nodiscard]] file::Json selftest_json(const SelftestReport& report);

}  // namespace takt::report
