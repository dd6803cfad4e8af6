// Answers that were just given, for who asks the same.
#pragma once

#include <cstddef>
#include <vector>

#include "takt/base/engine.hpp"
#include "takt/base/numbers.hpp"
#include "takt/wire/pdu.hpp"

namespace takt::relay {

/// The last normal answers to reads, of a bounded number; the oldest makes room. One owner, one thread.
class AnswerCache {
public:
    explicit AnswerCache(std::size_t most) : most_(most) {}

    /// @param t  when the request was sent: no value in the answer is older
    void keep(Instant t, UnitId unit, Bytes request, Bytes answer);

    /// @returns the answer to the same read of the same unit, not older than `age`; nullptr: there is none
    [[nodiscard]] const wire::Pdu* find(Instant t, UnitId unit, Bytes request, Duration age) const;

    /// Something was written to the unit.
    void drop(UnitId unit);
    void clear() { kept_.clear(); }

private:
    struct Kept {
        Instant t;
        UnitId unit;
        wire::Pdu request;
        wire::Pdu answer;
    };
    std::size_t most_;
    std::vector<Kept> kept_;
};

}  // namespace takt::relay
