// Where the rules of the judge report what does not hold, and what a run was like.
#pragma once

#include <cstdint>
#include <cstdio>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "takt/base/time.hpp"

namespace takt::gatewaysim {

struct Violation {
    std::string_view rule;  ///< a literal
    Instant t;
    std::string expected;
    std::string seen;
};

/// Keeps the first violations, counts what a run has seen, and prints its events if that is wanted.
class Complaints {
public:
    explicit Complaints(bool trace) : trace_(trace) {}

    void add(std::string_view rule, Instant t, std::string expected, std::string seen) {
        if (all_.size() < kMost) all_.push_back({rule, t, std::move(expected), std::move(seen)});
    }
    [[nodiscard]] bool any() const { return !all_.empty(); }
    [[nodiscard]] const std::vector<Violation>& all() const { return all_; }

    /// @param kind  as in "gap_quota"
    void count(const std::string& kind, std::uint64_t number = 1) { counts_[kind] += number; }
    [[nodiscard]] const std::map<std::string, std::uint64_t>& counts() const { return counts_; }

    /// @param text  makes the line; called only if lines are printed
    void trace(Instant t, const auto& text) const {
        if (!trace_) return;
        std::fprintf(stderr, "%14.3f ms  %s\n", static_cast<double>(t.time_since_epoch().count()) / 1e6,
                     std::string(text()).c_str());
    }

private:
    static constexpr std::size_t kMost = 5;

    bool trace_;
    std::vector<Violation> all_;
    std::map<std::string, std::uint64_t> counts_;
};

}  // namespace takt::gatewaysim
