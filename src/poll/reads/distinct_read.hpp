// The read that is sent in the place of a planned one while a response to it may still come.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "takt/bus/outstanding_responses.hpp"
#include "takt/plan/read_alternatives.hpp"

namespace takt::poll {

/// Chooses among the alternatives to one planned read so that its response cannot be mistaken for one that is
/// outstanding. A wider read has all values. A part, or another read of the device, shows that the device
/// answers again: a device that answers in order does not answer the earlier request any more. The planned
/// read follows it.
class DistinctRead {
public:
    explicit DistinctRead(const plan::ReadAlternatives& alternatives) : alternatives_(alternatives) {}

    /// @param planned    how the response to the planned read could be mistaken
    /// @param ambiguity  (read, quantity) → bus::Ambiguity
    /// @returns what is sent instead of the planned read; nothing: the planned read, now or when it may start
    template <class Ask>
    [[nodiscard]] const plan::ReadAlternative* choose(bus::Ambiguity planned, const Ask& ambiguity) const {
        using bus::Ambiguity;
        using Kind = plan::ReadAlternative::Kind;
        const auto first = [&](bool wider, Ambiguity worst) -> const plan::ReadAlternative* {
            for (std::size_t i = 0; i < alternatives_.size(); ++i) {
                const auto& alternative = alternatives_[i];
                if ((alternative.kind == Kind::wider) != wider || (refused_ >> i & 1) != 0) continue;
                if (ambiguity(alternative.read, alternative.quantity) <= worst) return &alternative;
            }
            return nullptr;
        };
        if (planned == Ambiguity::none) return nullptr;
        if (const auto* wider = first(true, Ambiguity::none)) return wider;
        if (planned <= Ambiguity::suspected) return nullptr;
        if (const auto* wider = first(true, Ambiguity::passed)) return wider;
        return answered_ ? nullptr : first(false, Ambiguity::none);
    }

    void send(const plan::ReadAlternative* alternative) {
        sent_.reset();
        if (alternative) sent_ = static_cast<std::size_t>(alternative - alternatives_.begin());
    }
    /// What was sent instead of the planned read; nullptr: the planned read.
    [[nodiscard]] const plan::ReadAlternative* sent() const {
        return sent_ ? &alternatives_[*sent_] : nullptr;
    }

    /// The planned read or a wider one was sent.
    [[nodiscard]] bool whole() const { return !sent() || sent()->kind == plan::ReadAlternative::Kind::wider; }

    /// A part or another read was answered: it is not sent again until the planned read was answered.
    void on_part_answered() { answered_ = true; }
    void on_answered() { answered_ = false; }
    /// The device refuses what was sent instead: it is not sent again.
    void on_refused() { refused_ |= std::uint32_t{1} << *sent_; }

private:
    plan::ReadAlternatives alternatives_;
    std::optional<std::size_t> sent_;  // index into alternatives_
    std::uint32_t refused_ = 0;        // a bit for each alternative
    bool answered_ = false;
};

}  // namespace takt::poll
