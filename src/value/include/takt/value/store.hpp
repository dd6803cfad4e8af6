// The slots: the one owner of every value of a project (docs/architecture.md).
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "takt/base/time.hpp"
#include "takt/value/value.hpp"

namespace takt::value {

struct SlotId {
    std::uint32_t value = 0;
    friend constexpr auto operator<=>(SlotId, SlotId) = default;
};

/// What is fixed about a slot.
struct SlotInfo {
    std::string name;  ///< unique in the store
    DataType type = DataType::int16;
    bool scaled = false;   ///< its value is a double whatever its type
    bool local = false;    ///< of the project itself, not of a device
    double dead_band = 0;  ///< numbers that moved by no more than this since the last event make no event
    Value initial;         ///< the default value; none: std::monostate
};

/// What is known of a value now.
struct Slot {
    Value value;
    Quality quality = Quality::never_read;
    Reason reason = Reason::ok;
    std::optional<Instant> good_at;  ///< when it was last read well, or set (locals)
    std::uint64_t batch = 0;         ///< the change it came with: members of one request share it
    Value wanted;                    ///< what the project last set; std::monostate: never
};

/// One new content of a slot.
struct Update {
    SlotId slot;
    std::optional<Value> value;  ///< nothing: the value stays
    Quality quality = Quality::good;
    Reason reason = Reason::ok;
};

/// A change worth telling: value, quality or reason of a slot became another.
struct Event {
    std::uint64_t sequence = 0;  ///< 1, 2, 3, … without holes
    std::uint64_t batch = 0;     ///< equal for slots that changed together
    Instant t;
    SlotId slot;
    Value value;
    Quality quality = Quality::good;
    Reason reason = Reason::ok;
};

/// A reader's place in the event ring.
struct EventCursor {
    std::uint64_t next = 1;
    std::uint64_t missed = 0;  ///< events that were overwritten before this reader came to them
};

/// All slots of a project and the bounded ring of their changes.
///
/// One owner, one thread; readers of other threads are served copies by it. Updates of one apply() are seen
/// together: between calls the slots are one consistent state. After construction only values longer than 15
/// bytes of text allocate.
class Store {
public:
    static constexpr std::size_t kDefaultEvents = 8192;

    /// Slots get the ids 0, 1, 2, … in that order. Locals begin good, the others never read; both with their
    /// initial value.
    explicit Store(std::vector<SlotInfo> slots, std::size_t event_capacity = kDefaultEvents);

    [[nodiscard]] std::size_t size() const { return slots_.size(); }
    [[nodiscard]] const SlotInfo& info(SlotId id) const;
    [[nodiscard]] const Slot& operator[](SlotId id) const;
    [[nodiscard]] std::optional<SlotId> find(std::string_view name) const;

    /// Changes all the slots of `updates` at once, and tells events. `t` is what good_at becomes where the
    /// quality is good.
    void apply(Instant t, std::span<const Update> updates);

    /// Remembers what the project wants the slot to be; the actual value does not change.
    void want(SlotId id, const Value& value);

    /// Puts what another store held of the same value into a slot, as if it had always been here: no event.
    void carry_over(SlotId id, const Slot& slot);

    /// A copy of all slots, in one consistent state. The index is the id.
    [[nodiscard]] std::vector<Slot> snapshot() const { return slots_; }

    /// The next event the reader has not seen, and moves the cursor behind it; nullptr when there is none. A
    /// reader that was too slow goes on with the oldest event still there, and `missed` grows by the lost
    /// ones. Valid until the next apply().
    [[nodiscard]] const Event* next_event(EventCursor& cursor) const;

private:
    void tell(Instant t, SlotId id);

    std::vector<SlotInfo> infos_;
    std::vector<Slot> slots_;
    std::vector<Value> told_;             // the value of the last event of each slot, for the dead band
    std::vector<std::uint32_t> by_name_;  // ids in the order of their names
    std::vector<Event> events_;           // event n stands at (n - 1) % size
    std::uint64_t last_sequence_ = 0;
    std::uint64_t last_batch_ = 0;
};

}  // namespace takt::value
