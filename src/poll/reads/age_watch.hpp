// Quality follows time: a good value that is older than its bound becomes uncertain.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "reads/ages.hpp"
#include "takt/value/store.hpp"

namespace takt::poll {

/// Watches the ages of the values of a line, also while nothing is read. The age of a value counts from the
/// start of the transaction that read it: no sample is older.
///
/// Variables are numbers of the caller; their slots follow one another. Allocates in watch() only. One owner,
/// one thread; the store must outlive it.
class AgeWatch {
public:
    /// @param first_slot  of variable 0
    AgeWatch(value::Store& store, value::SlotId first_slot) : store_(store), first_slot_(first_slot) {}

    struct Watched {
        std::size_t variable = 0;
        Duration bound{};                  ///< the greatest age
        bool split = false;                ///< it is read in parts
        std::vector<std::size_t> readers;  ///< the requests that read it
    };
    /// Watches these variables instead of those before, each from its next value on.
    /// @param variables  how many the line has
    void watch(std::size_t variables, const std::vector<Watched>& watched);
    /// Values that are good now are as old as this moment.
    void begin(Instant t);

    /// A request has read values and they were published at `read_at`; the device had them at `sampled`.
    void note_read(std::span<const std::size_t> variables, Instant sampled, Instant read_at);
    /// The values of these updates were published that something else than the read of their request has
    /// read.
    void note_updates(std::span<const value::Update> updates, Instant sampled, Instant read_at);
    /// The variable has no good value any more.
    void forget(std::size_t variable);

    /// When a value may become too old.
    [[nodiscard]] Instant next() const { return ages_.next(); }
    /// Values that were read together and have become too old: they are uncertain now. Spans are valid until
    /// the next watch().
    struct Stale {
        std::span<const std::size_t> variables;
        std::span<const std::size_t> readers;
    };
    /// Call it until it returns nothing.
    [[nodiscard]] std::optional<Stale> take_stale(Instant t);

private:
    struct OfVariable {
        std::uint32_t group = AgeLimits::kNone;
        Duration age_when_published{};  // of a value that not the read of its request has read
    };

    [[nodiscard]] value::SlotId slot(std::size_t variable) const {
        return {first_slot_.value + static_cast<std::uint32_t>(variable)};
    }
    [[nodiscard]] bool expire(Instant t, std::uint32_t group);

    value::Store& store_;
    value::SlotId first_slot_;
    AgeLimits ages_;
    std::vector<OfVariable> variables_;
    std::vector<value::Update> updates_;  // scratch
};

}  // namespace takt::poll
