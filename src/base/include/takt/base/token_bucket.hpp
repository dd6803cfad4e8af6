// Admission at a bounded rate: of commands, of connections, of a client's requests.
#pragma once

#include <cstdint>

#include "takt/base/result.hpp"
#include "takt/base/time.hpp"

namespace takt {

/// Admits at most `burst` events at once and one more each `min_interval`: in any window of length t at most
/// burst + floor(t / min_interval). The bound on a command's response relies on this (docs/guarantees.md,
/// "Fixed priority without preemption").
///
/// Time is given by the caller and must not run backwards; there is no clock inside.
/// One owner, one thread; copying copies the state. Never allocates.
class TokenBucket {
public:
    /// @param burst         events admitted at once, 1..1'000'000
    /// @param min_interval  least mean distance of events, > 0; its product with `burst` at most 73 years
    /// @returns Code::out_of_range with the offending value when a limit is broken
    [[nodiscard]] static Result<TokenBucket> create(std::uint32_t burst, Duration min_interval);

    /// Takes a token if there is one at `now`. A refusal changes nothing.
    [[nodiscard]] bool admit(Instant now);

    /// The earliest instant at which admit() will succeed; `now` itself when a token is there.
    [[nodiscard]] Instant next_admission(Instant now) const;

private:
    TokenBucket(std::uint32_t burst, Duration min_interval);

    Duration min_interval_;
    Duration capacity_;  // burst, expressed as the time it takes to earn it
    Instant empty_at_;   // the instant at which the bucket would have been empty and started to fill
};

}  // namespace takt
