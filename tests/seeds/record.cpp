#include "record.hpp"

#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <ostream>
#include <sstream>
#include <utility>

#include "takt/file/json.hpp"

namespace takt::seeds {
namespace {

std::string hex(std::uint64_t number) {
    char buffer[24];
    std::snprintf(buffer, sizeof buffer, "%016" PRIx64, number);
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

void print_seed(std::ostream& out, const Record& record, bool json, const std::string& shown) {
    if (json) {
        auto object = file::Json::object();
        object.set("seed", record.seed);
        object.set("hash", hex(record.hash));
        object.set("ok", record.invariant.empty());
        if (!record.invariant.empty()) object.set("invariant", record.invariant);
        object.set("counts", json_of(record.counts, false));
        out << object.dump() << '\n';
        return;
    }
    const auto count = record.counts.find(shown);
    out << "seed " << record.seed << "  " << hex(record.hash) << "  "
        << (record.invariant.empty() ? "ok" : "VIOLATED " + record.invariant) << "  "
        << (count == record.counts.end() ? 0 : count->second) << " " << shown << "\n";
}

void print_summary(std::ostream& out, const Counts& total, std::uint64_t seeds, std::uint64_t failed,
                   const std::vector<std::string>& missing, bool json) {
    if (json) {
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

}  // namespace takt::seeds
