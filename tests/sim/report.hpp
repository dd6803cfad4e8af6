// The report of a run of many seeds.
#pragma once

#include <string>
#include <vector>

#include "options.hpp"
#include "seeds/record.hpp"
#include "world.hpp"

namespace takt::simtest {

[[nodiscard]] seeds::Record record_of(const Result& result);

/// Seed, time, what was expected and seen, the last frames, how to run it again.
[[nodiscard]] std::string violation_text(const Result& result, const Options& options);

/// Kinds that a run of many seeds must have seen and has not.
[[nodiscard]] std::vector<std::string> missing_kinds(const seeds::Counts& total, const Options& options);

}  // namespace takt::simtest
