// Reads whose values are held back because their unit is in doubt.
#pragma once

#include <cstddef>
#include <list>
#include <utility>

#include "read_job.hpp"
#include "takt/bus/transaction.hpp"
#include "takt/wire/pdu.hpp"

namespace takt::poll {

/// The response to a read.
struct HeldRead {
    std::size_t request = 0;
    wire::RequestShape sent;  ///< what it reads
    ReadRound round;          ///< at the response
    bool whole = false;       ///< all values of the request
    bus::Outcome outcome;     ///< in a queue its response points to `response`
    wire::Pdu response;
};

/// The reads of a device whose responses may be those to earlier requests (bus::StepWatch::proof()). They
/// leave in their order: no value overtakes an earlier one.
///
/// Holds at most kMost reads. Allocates with each one. One owner, one thread.
class HeldReads {
public:
    static constexpr std::size_t kMost = 128;

    [[nodiscard]] bool empty() const { return reads_.empty(); }
    [[nodiscard]] bool full() const { return reads_.size() == kMost; }
    /// @pre !empty()
    [[nodiscard]] const HeldRead& front() const { return reads_.front(); }
    /// @pre !empty()
    void pop() { reads_.pop_front(); }
    /// Copies the response.
    /// @pre !full()
    void add(HeldRead read) {
        auto& held = reads_.emplace_back(std::move(read));
        held.response.assign(held.outcome.response.pdu());
        held.outcome.response = held.outcome.response.moved_to(held.response.span());
    }

private:
    std::list<HeldRead> reads_;  // their addresses stay
};

}  // namespace takt::poll
