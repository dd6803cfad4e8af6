// The results of seeds, as lines of text and as reports.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace takt::seeds {

/// Numbers by name: faults injected and recovered from, what else was recognised, sizes.
using Counts = std::map<std::string, std::uint64_t>;

/// One seed as it is kept in a resume file and goes between processes: a line of text.
struct Record {
    std::uint64_t seed = 0;
    std::uint64_t hash = 0;
    std::string invariant;  ///< the first one violated; empty: none
    Counts counts;
};

[[nodiscard]] std::string to_line(const Record& record);
[[nodiscard]] bool from_line(const std::string& line, Record& record);

/// @param shown  the count that the text shows of each seed
void print_seed(std::ostream& out, const Record& record, bool json, const std::string& shown);
/// @param missing  kinds that should have been seen and were not
void print_summary(std::ostream& out, const Counts& total, std::uint64_t seeds, std::uint64_t failed,
                   const std::vector<std::string>& missing, bool json);

}  // namespace takt::seeds
