// Reads whose values are held back because their unit is in doubt.
#pragma once

#include <cstddef>
#include <list>
#include <ranges>

#include "reads/read_job.hpp"
#include "takt/bus/transaction.hpp"
#include "takt/wire/pdu.hpp"

namespace takt::poll {

/// A read and its response.
struct HeldRead {
    std::size_t request = 0;
    wire::RequestShape sent;  ///< what it reads
    ReadRound round;          ///< at the response
    bool whole = false;       ///< all values of the request
    bus::Outcome outcome;
};

/// The reads of a device whose responses may be those to earlier requests (bus::StepWatch::proof()). They
/// leave in their order: no value overtakes an earlier one.
///
/// Holds at most kMost reads. Allocates with each one. One owner, one thread.
class HeldReads {
    struct Held {
        explicit Held(const HeldRead& held) : read(held) {}
        HeldRead read;
        wire::Pdu response;  // of `read`
    };

public:
    static constexpr std::size_t kMost = 128;

    /// In their order.
    [[nodiscard]] auto all() const { return std::views::transform(reads_, &Held::read); }
    [[nodiscard]] bool empty() const { return reads_.empty(); }
    [[nodiscard]] bool full() const { return reads_.size() == kMost; }
    /// @pre !empty()
    [[nodiscard]] const HeldRead& front() const { return reads_.front().read; }
    /// @pre !empty()
    void pop() { reads_.pop_front(); }
    /// Copies the response.
    /// @pre !full()
    void add(const HeldRead& read) {
        auto& held = reads_.emplace_back(read);
        held.response.assign(read.outcome.response.pdu());
        held.read.outcome.response = read.outcome.response.moved_to(held.response.span());
    }

private:
    std::list<Held> reads_;  // their addresses stay
};

}  // namespace takt::poll
