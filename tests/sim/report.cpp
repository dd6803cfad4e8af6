#include "report.hpp"

#include <cstdio>

namespace takt::simtest {
namespace {

constexpr std::string_view kRecoveries[] = {
    "link_came_up",       "device_came_back", "retried_and_got", "busy_ended",      "late_recognised",
    "foreign_dropped",    "command_done",     "command_refused", "command_unknown", "command_expired",
    "command_queue_full", "verify_equal",     "verify_differed", "broadcast",       "trial",
    "plan_replaced",      "line_with_echo",   "line_in_lumps"};

std::string exact_milliseconds(Instant t) {
    char buffer[40];
    std::snprintf(buffer, sizeof buffer, "%.6f ms", static_cast<double>(t.time_since_epoch().count()) / 1e6);
    return buffer;
}

}  // namespace

seeds::Record record_of(const Result& result) {
    seeds::Record record{.seed = result.seed, .hash = result.hash};
    if (!result.violations.empty()) record.invariant = result.violations.front().invariant;
    auto& counts = record.counts;
    counts["steps"] = result.steps;
    counts["frames"] = result.frames;
    counts["commands"] = result.commands;
    counts["exchanges"] = result.faults.exchanges;
    counts["bytes"] = result.faults.bytes;
    counts["redrawn"] = result.faults.redrawn;
    for (std::size_t i = 0; i < sim::kFaultKinds; ++i) {
        const std::string kind(name(static_cast<sim::FaultKind>(i)));
        counts["fault." + kind] = result.faults.injected[i];
        counts["after." + kind] = result.faults.recovered[i];
    }
    for (const auto& [kind, count] : result.recoveries) counts["seen." + kind] = count;
    return record;
}

std::string violation_text(const Result& result, const Options& options) {
    std::string made = "seed " + std::to_string(result.seed) + ":\n";
    for (const auto& violation : result.violations) {
        made += "  " + std::string(violation.invariant) + " at " + exact_milliseconds(violation.t) +
                ", line " + std::to_string(violation.line) + "\n    expected: " + violation.expected +
                "\n    seen:     " + violation.seen + "\n";
    }
    made += "  the last frames:\n";
    for (const Frame& frame : result.last_frames) {
        made += "    " + exact_milliseconds(frame.t) + "  line " + std::to_string(frame.line) +
                (frame.sent ? "  Tx:" : "  Rx:");
        char digits[8];
        for (const auto byte : frame.bytes) {
            std::snprintf(digits, sizeof digits, " %02X", byte);
            made += digits;
        }
        made += "\n";
    }
    return made + "  again: " + replay(options, result.seed) + "\n";
}

std::vector<std::string> missing_kinds(const seeds::Counts& total, const Options& options) {
    std::vector<std::string> missing;
    const auto need = [&](const std::string& kind) {
        const auto found = total.find(kind);
        if (found == total.end() || found->second == 0) missing.push_back(kind);
    };
    for (std::size_t i = 0; i < sim::kFaultKinds; ++i) {
        need("fault." + std::string(name(static_cast<sim::FaultKind>(i))));
        need("after." + std::string(name(static_cast<sim::FaultKind>(i))));
    }
    for (const auto kind : kRecoveries) need("seen." + std::string(kind));
    if (options.lenient)
        std::erase_if(missing, [](const auto& kind) {
            return kind.ends_with("past_response") || kind.ends_with("duplicate_response");
        });
    return missing;
}

}  // namespace takt::simtest
