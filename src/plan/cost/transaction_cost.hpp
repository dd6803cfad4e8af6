// C and F of the transactions of a request (docs/guarantees.md, "Model").
#pragma once

#include "cost/exact_time.hpp"
#include "takt/plan/plan.hpp"
#include "takt/plan/request_job.hpp"

namespace takt::plan {

/// Exact, except that C, F and the time-out are each rounded up to microseconds.
class TransactionCosts {
public:
    TransactionCosts(const model::Project& project, const model::Line& line)
        : project_(project), line_(line), bus_times_(line) {}

    /// C and F of a read or a write. The two transactions of a read-modify-write count as one; reading back a
    /// verified value is a separate one.
    [[nodiscard]] RequestCosts of_read(const Request& request) const;
    [[nodiscard]] RequestCosts of_write(const Request& request) const;
    /// C and F of a write of one variable by a command of its own.
    [[nodiscard]] RequestCosts of_command(const model::Device& device, const model::Variable& variable) const;
    /// The longest transaction of others on a shared line, answered or not.
    [[nodiscard]] Microseconds of_relayed() const;

private:
    [[nodiscard]] FrameLengths read_back_lengths(const Request& request) const;
    [[nodiscard]] RequestCosts costs(const Request& request, const Transactions& transactions) const;
    [[nodiscard]] TransactionCost cost(const model::Device& device, const FrameLengths& frames) const;

    const model::Project& project_;
    const model::Line& line_;
    BusTimeModel bus_times_;
};

}  // namespace takt::plan
