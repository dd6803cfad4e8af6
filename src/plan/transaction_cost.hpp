// C and F of the transactions of a request (guarantees, "Model").
#pragma once

#include <vector>

#include "exact_time.hpp"
#include "takt/plan/plan.hpp"
#include "takt/plan/response.hpp"

namespace takt::plan {

struct TransactionCost {
    Microseconds transaction = 0;  ///< C
    Microseconds failure = 0;      ///< F
};

/// Exact but for C, F and the time-out, which are each rounded up to whole microseconds.
class TransactionCosts {
public:
    TransactionCosts(const model::Project& project, const model::Line& line)
        : project_(project), line_(line), ruler_(line) {}

    /// Of the transaction of a read or a write; the two of a read-modify-write count as one, the reading back
    /// of what is verified is one of its own.
    [[nodiscard]] std::vector<TransactionCost> of_read(const Request& request) const;
    [[nodiscard]] std::vector<TransactionCost> of_write(const Request& request) const;
    /// The most one transaction of others can take on a line that is shared, answered or not.
    [[nodiscard]] Microseconds of_relayed() const;

private:
    [[nodiscard]] FrameLengths read_back_lengths(const Request& request) const;
    [[nodiscard]] std::vector<TransactionCost> costs(const Request& request,
                                                     const Transactions& transactions) const;
    [[nodiscard]] TransactionCost cost(const model::Device& device, const FrameLengths& frames) const;

    const model::Project& project_;
    const model::Line& line_;
    Ruler ruler_;
};

}  // namespace takt::plan
