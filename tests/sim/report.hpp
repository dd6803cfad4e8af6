// The report of a run of many seeds.
#pragma once

#include <iosfwd>
#include <map>
#include <string>

#include "options.hpp"
#include "world.hpp"

namespace takt::simtest {

/// Numbers by name: faults injected and recovered from, what else was recognised, sizes.
using Counts = std::map<std::string, std::uint64_t>;

/// One seed as it stands in a resume file and goes between processes: a line of text.
struct Record {
    std::uint64_t seed = 0;
    std::uint64_t hash = 0;
    std::string invariant;  ///< the first one violated; empty: none
    Counts counts;
};

[[nodiscard]] Record record_of(const Result& result);
[[nodiscard]] std::string to_line(const Record& record);
[[nodiscard]] bool from_line(const std::string& line, Record& record);

/// Seed, time, what was expected and seen, the last frames, how to run it again.
[[nodiscard]] std::string violation_text(const Result& result, const Options& options);

void print_seed(std::ostream& out, const Record& record, const Options& options);
void print_summary(std::ostream& out, const Counts& total, std::uint64_t seeds, std::uint64_t failed,
                   const Options& options);

/// Kinds that a run of many seeds must have seen and has not.
[[nodiscard]] std::vector<std::string> missing_kinds(const Counts& total);

}  // namespace takt::simtest
