// Reads whose values are held back because their unit is in doubt.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "takt/bus/transaction.hpp"
#include "takt/value/value.hpp"
#include "takt/wire/pdu.hpp"

namespace takt::poll {

/// The response to a read.
struct HeldRead {
    std::size_t device = 0;
    std::size_t request = 0;
    wire::RequestShape sent;  ///< what it reads
    bool whole = false;       ///< all values of the request
    bus::Outcome outcome;     ///< in a queue its response points to `response`
    wire::Pdu response;
};

/// The reads of a line whose responses may be those to earlier requests (bus::StepWatch::doubts()), in their
/// order. Their values follow when that is decided: good, or uncertain.
///
/// Holds at most kMost reads: the oldest one is given up for a further one. Allocates with the first one,
/// once. One owner, one thread.
class HeldReads {
public:
    static constexpr std::size_t kMost = 256;
    enum class Verdict : std::uint8_t { waits, good, uncertain };

    [[nodiscard]] bool empty() const { return reads_.empty(); }
    [[nodiscard]] std::span<const HeldRead> reads() const { return reads_; }

    /// Copies the response. @returns the oldest read, if there is no place for both; valid until the next
    /// call
    [[nodiscard]] const HeldRead* add(HeldRead read);

    /// Removes the reads that do not wait, in their order.
    /// @param judge    HeldRead → Verdict. If one read of a device waits, so do the later ones of that device
    /// @param publish  (HeldRead, value::Quality), of each one that is removed; must not call this queue
    template <class Judge, class Publish>
    void settle(const Judge& judge, const Publish& publish) {
        std::size_t kept = 0;
        for (std::size_t i = 0; i < reads_.size(); ++i) {
            const Verdict verdict = judge(reads_[i]);
            if (verdict == Verdict::waits) {
                if (kept != i) move_to(kept, i);
                ++kept;
            } else {
                publish(reads_[i],
                        verdict == Verdict::good ? value::Quality::good : value::Quality::uncertain);
            }
        }
        reads_.erase(reads_.begin() + static_cast<std::ptrdiff_t>(kept), reads_.end());
    }

private:
    void move_to(std::size_t to, std::size_t from);

    std::vector<HeldRead> reads_;
    HeldRead given_up_;
};

}  // namespace takt::poll
