// A cache of recent answers to reads.
#pragma once

#include <cstddef>
#include <vector>

#include "takt/base/engine.hpp"
#include "takt/base/numbers.hpp"
#include "takt/wire/pdu.hpp"

namespace takt::serve {

/// The last normal answers to reads, of bounded number; a new entry replaces the oldest. One owner, one
/// thread.
class AnswerCache {
public:
    explicit AnswerCache(std::size_t most) : most_(most) {}

    /// @param t  time of the request; no value in the answer is older
    void store(Instant t, UnitId unit, Bytes request, Bytes answer);

    /// @returns the answer to the same read of the same unit, not older than `age`; nullptr: there is none
    [[nodiscard]] const wire::Pdu* find(Instant t, UnitId unit, Bytes request, Duration age) const;

    /// Removes the answers of the unit, after a write to it.
    void drop(UnitId unit);
    void clear() { entries_.clear(); }

private:
    struct Entry {
        Instant t;
        UnitId unit;
        wire::Pdu request;
        wire::Pdu answer;
    };
    std::size_t most_;
    std::vector<Entry> entries_;
};

}  // namespace takt::serve
