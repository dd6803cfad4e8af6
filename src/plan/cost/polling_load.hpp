// The load that polling puts on a line, known before phases and streams are.
#pragma once

#include <span>

#include "cost/transaction_cost.hpp"

namespace takt::plan {

/// The sum of C / T over the polled requests of a line, as in its proof.
class PollingLoad {
public:
    PollingLoad(const model::Project& project, const model::Line& line)
        : costs_(project, line), in_flight_(static_cast<double>(requests_in_flight(line))) {}

    /// @param requests  all requests of one device; with device, period and frame lengths
    void add(std::span<const Request> requests);

    /// Above 1 also without rounding errors: the least urgent polled requests have no bound.
    [[nodiscard]] bool exceeds_line() const { return load_ > in_flight_ + kRounding; }

private:
    static constexpr double kRounding = 1e-6;  // exceeds the rounding error of both sums

    TransactionCosts costs_;
    double in_flight_ = 1;
    double load_ = 0;
};

}  // namespace takt::plan
