// Counters of a slave engine.
#pragma once

#include <array>
#include <cstdint>

#include "takt/wire/framer.hpp"

namespace takt::serve {

/// Totals since the engine was made. Dropped frames are counted by reason.
struct Counters {
    std::uint64_t requests = 0;    ///< good frames for a unit served here, without broadcasts
    std::uint64_t broadcasts = 0;  ///< serial lines only
    std::uint64_t other_units =
        0;                      ///< good frames for or from units that are not served here; serial lines only
    std::uint64_t answers = 0;  ///< sent, exceptions included
    std::uint64_t exceptions = 0;  ///< sent
    std::uint64_t unanswered = 0;  ///< requests without an answer: silence, superseded, queue full, link lost
    std::uint64_t echoes = 0;      ///< own frames received as echo
    std::array<std::uint64_t, 9> faults{};  ///< dropped input by wire::FrameFault

    [[nodiscard]] std::uint64_t of(wire::FrameFault fault) const {
        return faults[static_cast<std::size_t>(fault)];
    }
    void count(wire::FrameFault fault) { ++faults[static_cast<std::size_t>(fault)]; }
    void add(const Counters& other) {
        requests += other.requests;
        broadcasts += other.broadcasts;
        other_units += other.other_units;
        answers += other.answers;
        exceptions += other.exceptions;
        unanswered += other.unanswered;
        echoes += other.echoes;
        for (std::size_t i = 0; i < faults.size(); ++i) faults[i] += other.faults[i];
    }
};

}  // namespace takt::serve
