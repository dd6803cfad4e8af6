// The slots own all values of a project (docs/architecture.md).
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

/// The constant properties of a slot.
struct SlotInfo {
    std::string name;  ///< unique in the store
    DataType type = DataType::int16;
    bool scaled = false;   ///< its value is a double, whichever its type
    bool local = false;    ///< of the project itself, not of a device
    bool service = false;  ///< a local that the program itself provides; read-only
    double dead_band = 0;  ///< a change by at most this amount since the last event causes no event
    Value initial;         ///< the default value; none: std::monostate
};

/// The current state of a slot.
struct Slot {
    Value value;
    Quality quality = Quality::never_read;
    Reason reason = Reason::ok;
    std::optional<Instant> good_at;     ///< when it was last read well, or set (locals)
    std::optional<Instant> sampled_at;  ///< of that read, the begin: the device had the value then or later
    std::uint64_t batch = 0;  ///< number of the apply() that changed it; members of one request share it
    Value wanted;             ///< what the project last set; std::monostate: never
};

/// A new state of one slot.
struct Update {
    SlotId slot;
    std::optional<Value> value;  ///< nothing: the value stays
    Quality quality = Quality::good;
    Reason reason = Reason::ok;
    /// Of a good value: the begin of the read; nothing: it is from the instant of apply().
    std::optional<Instant> sampled_at{};
};

/// An event: value, quality or reason of a slot changed.
struct Event {
    std::uint64_t sequence = 0;  ///< 1, 2, 3, … without holes
    std::uint64_t batch = 0;     ///< equal for slots that changed together
    Instant t;
    SlotId slot;
    Value value;
    Quality quality = Quality::good;
    Reason reason = Reason::ok;
    std::optional<Instant> good_at;      ///< Slot::good_at after the change
    std::optional<Instant> sampled_at;   ///< Slot::sampled_at after the change
    std::optional<Instant> good_before;  ///< Slot::sampled_at before it: the value changed after that
};

/// A reader's position in the event ring.
struct EventCursor {
    std::uint64_t next = 1;
    std::uint64_t missed = 0;  ///< events that were overwritten before they were read
};

/// All slots of a project and a bounded ring of their changes.
///
/// One owner, one thread, which serves copies to readers of other threads. The updates of one apply() take
/// effect together, so the slots are consistent between calls. After construction only texts of more than 15
/// bytes allocate.
class Store {
public:
    static constexpr std::size_t kDefaultEvents = 8192;

    /// Slots get the ids 0, 1, 2, … in order. Locals start with quality good, others and service variables
    /// never_read, all with their initial value.
    explicit Store(std::vector<SlotInfo> slots, std::size_t event_capacity = kDefaultEvents);

    [[nodiscard]] std::size_t size() const { return slots_.size(); }
    [[nodiscard]] const SlotInfo& info(SlotId id) const;
    [[nodiscard]] const Slot& operator[](SlotId id) const;
    [[nodiscard]] std::optional<SlotId> find(std::string_view name) const;

    /// Changes all slots of `updates` at once and adds the events. `t` becomes good_at where the quality is
    /// good. A read may be known to be good only after a later mark of its slot: its event then has the time
    /// of the event before it, so that the events of a slot never go back in time.
    void apply(Instant t, std::span<const Update> updates);

    /// Stores the value that the project wants in the slot. The actual value does not change.
    void want(SlotId id, const Value& value);

    /// Puts what another store held of the same value into a slot, as if it had always been here: no event.
    void carry_over(SlotId id, const Slot& slot);

    /// A copy of all slots, in one consistent state. The index is the id.
    [[nodiscard]] std::vector<Slot> snapshot() const { return slots_; }

    /// The next unread event, advancing the cursor; nullptr: none. A reader that was too slow continues with
    /// the oldest event in the ring, and `missed` grows by the number of lost ones. Valid until the next
    /// apply().
    [[nodiscard]] const Event* next_event(EventCursor& cursor) const;

private:
    void report(Instant t, SlotId id, std::optional<Instant> good_before);

    std::vector<SlotInfo> infos_;
    std::vector<Slot> slots_;
    struct Reported {
        Value value;  // for the dead band
        Instant t = Instant::min();
    };
    std::vector<Reported> reported_;      // the last event of each slot
    std::vector<std::uint32_t> by_name_;  // ids in the order of their names
    std::vector<Event> events_;           // event n is at index (n - 1) % size
    std::uint64_t last_sequence_ = 0;
    std::uint64_t last_batch_ = 0;
};

}  // namespace takt::value
