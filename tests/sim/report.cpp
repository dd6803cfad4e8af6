#include "report.hpp"

#include <algorithm>
#include <cinttypes>
#include <cstdio>
#include <ostream>
#include <sstream>
#include <utility>

#include "takt/file/json.hpp"

namespace takt::simtest {
namespace {

constexpr std::string_view kRecoveries[] = {
    "link_came_up",       "device_came_back", "retried_and_got", "busy_ended",      "late_recognised",
    "foreign_dropped",    "command_done",     "command_refused", "command_unknown", "command_expired",
    "command_queue_full", "verify_equal",     "verify_differed", "broadcast",       "trial",
    "plan_replaced",      "line_with_echo",   "line_in_lumps"};

std::string hex(std::uint64_t number) {
    char buffer[24];
    std::snprintf(buffer, sizeof buffer, "%016" PRIx64, number);
    return buffer;
}

std::string milliseconds(Instant t) {
    char buffer[40];
    std::snprintf(buffer, sizeof buffer, "%.6f ms", static_cast<double>(t.time_since_epoch().count()) / 1e6);
    return buffer;
}

/// @param all  also the counts that are zero
file::Json json_of(const Counts& counts, bool all) {
    file::Json::Object entries;
    for (const auto& [kind, count] : counts)
        if (all || count > 0) entries.emplace_back(kind, count);
    return file::Json(std::move(entries));
}

}  // namespace

Record record_of(const Result& result) {
    Record record{.seed = result.seed, .hash = result.hash};
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

std::string to_line(const Record& record) {
    std::string line = std::to_string(record.seed) + " " + hex(record.hash) + " " +
                       (record.invariant.empty() ? "ok" : record.invariant);
    for (const auto& [kind, count] : record.counts)
        if (count > 0) line += " " + kind + "=" + std::to_string(count);
    return line;
}

bool from_line(const std::string& line, Record& record) {
    std::istringstream words(line);
    std::string hash;
    if (!(words >> record.seed >> hash >> record.invariant)) return false;
    if (std::sscanf(hash.c_str(), "%" SCNx64, &record.hash) != 1) return false;
    if (record.invariant == "ok") record.invariant.clear();
    for (std::string word; words >> word;) {
        const auto sign = word.find('=');
        if (sign == std::string::npos) return false;
        record.counts[word.substr(0, sign)] = std::strtoull(word.c_str() + sign + 1, nullptr, 10);
    }
    return true;
}

std::string violation_text(const Result& result, const Options& options) {
    std::string made = "seed " + std::to_string(result.seed) + ":\n";
    for (const auto& violation : result.violations) {
        made += "  " + std::string(violation.invariant) + " at " + milliseconds(violation.t) + ", line " +
                std::to_string(violation.line) + "\n    expected: " + violation.expected +
                "\n    seen:     " + violation.seen + "\n";
    }
    made += "  the last frames:\n";
    for (const Frame& frame : result.last_frames) {
        made += "    " + milliseconds(frame.t) + "  line " + std::to_string(frame.line) +
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

void print_seed(std::ostream& out, const Record& record, const Options& options) {
    if (options.json) {
        auto object = file::Json::object();
        object.set("seed", record.seed);
        object.set("hash", hex(record.hash));
        object.set("ok", record.invariant.empty());
        if (!record.invariant.empty()) object.set("invariant", record.invariant);
        object.set("counts", json_of(record.counts, false));
        out << object.dump() << '\n';
        return;
    }
    const auto frames = record.counts.find("frames");
    out << "seed " << record.seed << "  " << hex(record.hash) << "  "
        << (record.invariant.empty() ? "ok" : "VIOLATED " + record.invariant) << "  "
        << (frames == record.counts.end() ? 0 : frames->second) << " frames\n";
}

void print_summary(std::ostream& out, const Counts& total, std::uint64_t seeds, std::uint64_t failed,
                   const Options& options) {
    const auto missing = missing_kinds(total);
    if (options.json) {
        auto object = file::Json::object();
        object.set("seeds", seeds);
        object.set("failed", failed);
        object.set("total", json_of(total, true));
        auto never_seen = file::Json::array();
        for (const auto& kind : missing) never_seen.push_back(kind);
        object.set("never_seen", std::move(never_seen));
        out << object.dump() << '\n';
        return;
    }
    out << seeds << " seeds, " << failed << " with a violation\n";
    for (const auto& [kind, count] : total) out << "  " << kind << ": " << count << "\n";
}

std::vector<std::string> missing_kinds(const Counts& total) {
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
    return missing;
}

}  // namespace takt::simtest
