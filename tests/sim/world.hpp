// One run: a project with the real master on simulated lines, users, faults, and the judge.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "judge/line_judge.hpp"
#include "plant.hpp"
#include "takt/poll/master.hpp"
#include "takt/sim/simulated_line.hpp"
#include "users.hpp"

namespace takt::simtest {

/// Which faults, by name or by seed.
struct FaultChoice {
    enum class Kind : std::uint8_t { by_seed, none, few, many, given };
    Kind kind = Kind::by_seed;
    sim::FaultRates rates;  ///< given
};

struct Run {
    std::uint64_t seed = 1;
    Duration length = std::chrono::minutes(10);
    FaultChoice faults;
    bool merciless = false;  ///< lateness without a limit, copies at any time, answers of the past
    bool trace = false;      ///< every frame on stderr
};

struct Frame {
    Instant t;
    std::size_t line = 0;
    bool sent = false;
    std::vector<std::uint8_t> bytes;
};

struct Result {
    std::uint64_t seed = 0;
    std::uint64_t hash = 0;
    std::uint64_t steps = 0;
    std::uint64_t frames = 0;
    std::uint64_t commands = 0;
    sim::FaultCounts faults;
    std::map<std::string, std::uint64_t> recoveries;
    std::vector<judge::Violation> violations;
    std::vector<Frame> last_frames;  ///< before the first violation
};

/// Runs until the end or the first violation.
[[nodiscard]] Result run(const model::Project& project, const Run& settings);

/// How long everything stays quiet at the end, so that all can be well again.
[[nodiscard]] Duration quiet_time(const model::Project& project);

}  // namespace takt::simtest
