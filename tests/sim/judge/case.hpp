// The case under judgement and its violations.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "takt/model/project.hpp"
#include "takt/plan/guarantee.hpp"
#include "takt/plan/plan.hpp"

namespace takt::judge {

/// The invariants by name; docs/simulation.md defines them.
inline constexpr std::string_view kInvariants[] = {
    "value_true",          "value_own",        "write_done_exact",     "write_unknown_bounded",
    "unsafe_not_repeated", "outcome_once",     "transaction_within_f", "silence_kept",
    "order_kept",          "failed_to_queue",  "dead_costs_probes",    "group_whole",
    "poll_enable_obeyed",  "request_was_due",  "memory_bounded",       "recovers",
    "reachable",           "polling_advances", "quality_own",
};

struct Violation {
    std::string_view invariant;
    Instant t;
    std::size_t line = 0;
    std::string expected;
    std::string seen;
};

/// Stores the first few violations. The first one is the one to explain.
class Complaints {
public:
    void add(std::string_view invariant, Instant t, std::size_t line, std::string expected,
             std::string seen) {
        constexpr std::size_t kMost = 20;
        if (all_.size() < kMost) all_.push_back({invariant, t, line, std::move(expected), std::move(seen)});
    }
    [[nodiscard]] bool any() const { return !all_.empty(); }
    [[nodiscard]] const std::vector<Violation>& all() const { return all_; }

private:
    std::vector<Violation> all_;
};

/// Outlives its judges.
struct Case {
    const model::Project& project;
    const plan::Plan& plan;
    const std::vector<plan::LineGuarantee>& guarantees;
};

}  // namespace takt::judge
