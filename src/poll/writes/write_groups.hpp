// The write halves of the requests of a plan: groups of variables that one request writes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "devices/outcome_class.hpp"
#include "devices/rate_limited_event.hpp"
#include "takt/bus/health.hpp"
#include "takt/plan/plan.hpp"
#include "writes/command_queue.hpp"
#include "writes/read_back.hpp"
#include "writes/write_progress.hpp"
#include "writes/written_values.hpp"

namespace takt::poll {

/// How a request writes.
enum class WriteKind : std::uint8_t {
    whole,     // all members with 0x05, 0x06, 0x0F, 0x10
    mask,      // bits of one register with 0x16
    modify,    // bits of one register: read, then written with 0x06 or 0x10
    exchange,  // with 0x17, which reads too
};

/// One group: what asks for its write, and the write that was begun last.
struct WriteGroup {
    const plan::Request* plan = nullptr;
    wire::Function function = wire::Function::write_multiple_registers;
    WriteKind kind = WriteKind::whole;
    std::vector<std::size_t> members;  ///< the variables that it writes
    bus::AnswerShape shape;            ///< of the answer to its first transaction
    std::size_t rank = 0;              ///< among all jobs of the line, in the order of the plan
    RateLimitedEvent event;
    std::unique_ptr<ReadBack> read_back;  ///< if some of its variables have `verify`

    bool asked = false;      ///< by a value that was set, or by a retry that is not for commands alone
    bool triggered = false;  ///< by its trigger
    bool reported_waiting = false;
    std::uint16_t failures = 0;
    bus::Backoff busy = bus::busy_backoff();
    Instant not_before = Instant::min();

    WriteProgress progress;
    std::vector<std::size_t> sending;  ///< bits that are written
    bool sent_asked = false;           ///< the write is not for commands alone
    bool sent_triggered = false;       ///< it, or a failed attempt before it, was asked for by its trigger
    bool token_taken = false;          ///< without a bucket: it has taken its token of the line
    std::uint64_t sent_want = 0;       ///< WrittenValues::last_number() when it was last begun
    std::uint64_t settled_want = 0;    ///< sent_want of the last write that ended

    /// It changes single bits of a register and keeps the others.
    [[nodiscard]] bool writes_bits() const { return kind == WriteKind::mask || kind == WriteKind::modify; }
    /// What its write changes.
    [[nodiscard]] std::span<const std::size_t> written() const { return writes_bits() ? sending : members; }
};

/// The groups of a line. A group is named by the index of its request, its members by the indices of their
/// variables.
///
/// A group is due when a member was set, its trigger fired, or a command waits for it. It is written with the
/// latest value of each member; of the bits of a register only those that were set change. What arrives
/// while a write is on its way leads to another one.
///
/// The caller chooses when a step is sent and reports its end; every write that was begun ends with retry()
/// or finish(). One owner, one thread. Allocates while groups are added; afterwards only `sending` and
/// scratch memory may grow, up to the number of members.
class WriteGroups {
public:
    WriteGroups(WrittenValues& values, CommandQueue& commands, ArrivalCounter& arrivals)
        : values_(values), commands_(commands), arrivals_(arrivals) {}

    // ---- groups and members

    /// @param on_change, by_trigger  how its members find it
    void add(std::size_t group, WriteGroup added, bool on_change, bool by_trigger);
    [[nodiscard]] bool has(std::size_t group) const { return group < groups_.size() && groups_[group]; }
    [[nodiscard]] const WriteGroup& operator[](std::size_t group) const { return *groups_[group]; }
    /// The group that writes the variable on change.
    [[nodiscard]] std::optional<std::size_t> on_change(std::size_t variable) const;
    /// The group that writes the variable by a trigger.
    [[nodiscard]] std::optional<std::size_t> by_trigger(std::size_t variable) const;

    // ---- what asks for a write

    /// The variable was set: the group that writes it on change is due, if there is one.
    void set(Instant t, std::size_t variable);
    void pull_trigger(Instant t, std::size_t group);
    void drop_trigger(std::size_t group) { groups_[group]->triggered = false; }
    /// A command is about to wait for the group.
    void ask(Instant t, std::size_t group);

    // ---- the choice

    [[nodiscard]] bool due(std::size_t group) const;
    /// Every member has a value, except for bits of a register: their neighbours are kept.
    /// take_waiting() then gives a group that is not ready, once.
    [[nodiscard]] bool ready(std::size_t group);
    /// A group that waits for the value of a member.
    struct Waiting {
        std::size_t group = 0;
        std::size_t variable = 0;
    };
    [[nodiscard]] std::optional<Waiting> take_waiting();
    /// Whether its bucket admits it.
    [[nodiscard]] bool admit(Instant t, std::size_t group) { return groups_[group]->event.admit(t); }
    /// nullptr: it has none.
    [[nodiscard]] TokenBucket* bucket(std::size_t group);
    /// Without a bucket: whether it has taken its token of the line; else nullptr.
    [[nodiscard]] bool* line_token(std::size_t group);

    // ---- the steps of a write

    /// Begins the write of a group that is due and ready.
    /// @returns its first transaction; an error: finish() must end it
    [[nodiscard]] Result<wire::PreparedRequest> begin(std::size_t group);
    /// The second transaction of a read-modify-write. Values that were set since the read are written too.
    /// @param old  the register as read
    /// @returns an error: finish() must end it
    [[nodiscard]] Result<wire::PreparedRequest> modify(Instant t, std::size_t group, std::uint16_t old);
    void second_step_submitted(std::size_t group) { groups_[group]->progress.write(); }
    void transaction_ended(std::size_t group) { groups_[group]->progress.transaction_ended(); }
    /// The device has confirmed the write; it is to be read back.
    void await_read_back(std::size_t group);
    void read_back_submitted(std::size_t group) { groups_[group]->progress.read_back(); }
    /// The read-back failed.
    /// @returns whether it is tried again
    bool read_back_again(Instant t, std::size_t group, const OutcomeClass& outcome_class,
                         std::uint16_t attempts);

    // ---- the end of a write

    /// The attempt failed and may be repeated.
    /// @param attempts  of its device
    /// @returns whether it is repeated: attempts are left
    bool retry(Instant t, std::size_t group, const OutcomeClass& outcome_class, std::uint16_t attempts);
    /// It waits again, without a new admission. If only commands wanted it and none is left, it is not sent.
    void requeue(Instant t, std::size_t group);

    /// Of a write that ends: the variables that were set since the last one, or all if none was; without
    /// those whose commands have outcomes of their own. Valid until the next call.
    struct Settled {
        std::span<const std::size_t> variables;
        bool by_trigger = false;
    };
    /// The write ends with this result; so do its commands.
    Settled finish(Instant t, std::size_t group, value::CommandResult result, value::Reason reason);

    // ---- another plan, another poller

    /// Removes all groups. Members that were set stay so.
    [[nodiscard]] std::vector<std::unique_ptr<WriteGroup>> take_groups();
    /// A new group goes on where those of an old plan are that wrote its first member in the same way.
    /// @returns the index of that group
    std::optional<std::size_t> carry(std::size_t group, const std::vector<std::unique_ptr<WriteGroup>>& old);
    /// A group of this line goes on where one of the line before is.
    /// @param same_members  it writes the same variables in the same order
    void take_over(std::size_t group, const WriteGroup& old, bool same_members);
    /// A member was set and not written by the line before.
    void take_over_member(std::size_t variable, const WriteGroups& old, std::size_t old_variable);

private:
    static constexpr std::uint32_t kNone = UINT32_MAX;
    struct Member {
        std::uint32_t on_change = kNone;
        std::uint32_t by_trigger = kNone;
        bool pending = false;       // a bit that set() or a retry wants written, not in flight
        bool sent_pending = false;  // `pending` when its write began
    };

    [[nodiscard]] std::optional<std::size_t> missing(std::size_t group);
    void choose_bits(const WriteGroup& group);
    [[nodiscard]] Result<RegisterBits> bits_of(std::span<const std::size_t> variables);
    [[nodiscard]] Result<wire::Request> first_request(const WriteGroup& group);
    void carry_values(const WriteGroup& group);
    Settled settle(std::size_t group);

    WrittenValues& values_;
    CommandQueue& commands_;
    ArrivalCounter& arrivals_;
    std::vector<std::unique_ptr<WriteGroup>> groups_;  // by request; empty if the line has none
    std::vector<Member> members_;                      // by variable; likewise
    std::vector<std::size_t> bits_;                    // scratch, so that a choice allocates nothing
    std::vector<std::size_t> settled_;                 // likewise
    std::vector<Waiting> waiting_;                     // not taken yet
};

}  // namespace takt::poll
