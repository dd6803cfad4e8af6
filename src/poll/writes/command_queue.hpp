// Commands: they wait, are written with their group or alone, and end with one outcome each.
#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <optional>
#include <span>
#include <vector>

#include "devices/outcome_class.hpp"
#include "takt/base/result.hpp"
#include "takt/value/command.hpp"
#include "writes/single_write.hpp"
#include "writes/write_progress.hpp"
#include "writes/written_values.hpp"

namespace takt::poll {

/// A command that waits or is being written.
struct PendingCommand {
    value::WriteCommand command;
    std::size_t variable = 0;
    std::size_t device = 0;
    bool rounded = false;
    std::uint64_t order = 0;           ///< of arrival; names it
    std::optional<std::size_t> group;  ///< that it is written with; nothing: it is written alone
    WrittenValues::Wanted before;      ///< wanted again if nothing was sent
    std::uint64_t want = 0;            ///< the number of its value
    SingleWrite alone;                 ///< if it is written alone
    WriteProgress progress;  ///< with a group: `writing` from the begin to the end of the group's write
    Execution execution = Execution::not_sent;  ///< by the attempts that have ended
    bool carried = false;                       ///< a write of a group in flight writes its value too
    bool confirmed = false;                     ///< verified, but other members of its group differ
    value::Value read_back;                     ///< if it differs from the value written
};

/// The commands of a line in the order of arrival, and the outcomes that were not taken yet.
///
/// A command leaves the queue with exactly one outcome. A refused or expired one is no longer wanted: the
/// value wanted before it is restored. If an attempt may have executed, a refusal is reported as unknown.
///
/// It does not know groups, requests or the line: groups are numbers of the caller, who chooses what is sent
/// and reports how it ended. Allocates when a command is added and when one ends. One owner, one thread.
class CommandQueue {
public:
    /// @param values  where the wanted values are; must outlive the queue
    /// @param capacity  of commands and outcomes together
    CommandQueue(WrittenValues& values, std::size_t capacity) : values_(values), capacity_(capacity) {}

    // ---- arrival and outcome

    [[nodiscard]] bool full() const { return commands_.size() + outcomes_.size() >= capacity_; }
    [[nodiscard]] bool empty() const { return commands_.empty(); }
    /// Requires that it is not full. A waiting command for the same variable that is written with its group,
    /// and has another value, is refused as superseded: a group is written with the latest value of each
    /// member.
    void add(Instant t, PendingCommand command);
    /// The command ends before it was added.
    void refuse(Instant t, const value::WriteCommand& command, bool rounded, value::Reason reason);
    /// The variable was set to a value: as in add().
    void supersede(Instant t, std::size_t variable, const value::Value& value);
    [[nodiscard]] std::optional<value::CommandOutcome> take_outcome();

    // ---- the end of waiting

    /// When the next waiting command expires.
    [[nodiscard]] Instant next_expiry() const;
    void expire(Instant t);
    /// Nothing can be sent to the device: its waiting commands are refused, or unknown if one may have been
    /// sent.
    void drop_waiting(Instant t, std::size_t device, value::Reason reason);
    /// Commands alone that await their read-back end as unknown.
    /// @returns whether there was one
    bool drop_read_backs(Instant t, std::size_t device, value::Reason reason);
    /// Every command ends: as expired if it was never sent, else as unknown.
    void end_all(Instant t);

    // ---- commands that are written alone

    /// Calls visit(command) for each one of which a transaction may be submitted, in the order of arrival.
    template <class Visit>
    void for_each_startable(const Visit& visit) {
        for (auto& command : commands_)
            if (!command.group && command.progress.may_start()) visit(command);
    }
    /// nullptr: it has ended.
    [[nodiscard]] PendingCommand* find(std::uint64_t order);
    /// Requires that it has not ended.
    [[nodiscard]] PendingCommand& at(std::uint64_t order);
    /// The attempt failed and may be repeated.
    /// @param attempts  of its device
    /// @returns whether it waits again: attempts are left
    bool retry(Instant t, std::uint64_t order, const OutcomeClass& outcome_class, std::uint16_t attempts);
    void finish(Instant t, std::uint64_t order, value::CommandResult result, value::Reason reason);

    // ---- commands that are written with their group

    /// Commands of the group that wait.
    [[nodiscard]] std::size_t waiting(std::size_t group) const {
        return group < waiting_.size() ? waiting_[group] : 0;
    }
    /// Whether a command for the variable waits for its group.
    [[nodiscard]] bool waits_for_group(std::size_t variable) const;
    /// Whether the write of the group that has begun is for a command of the variable too.
    [[nodiscard]] bool begun(std::size_t group, std::size_t variable) const;

    /// A write of the group begins: with all commands that wait for it.
    void begin_group(std::size_t group);
    /// An attempt of it has ended. @param execution  not_sent: it was not sent
    void note_attempt(std::size_t group, Execution execution);
    /// A member was read back. @param differing  the value read if it is not the value written; else empty
    void note_read_back(std::size_t variable, const value::Value& differing);
    /// A member differs: those that do not are confirmed.
    void note_differs(std::size_t group);
    /// Commands of the group's write whose variable was set to another value meanwhile end: done if their own
    /// value was confirmed, else superseded.
    void refuse_outdated(Instant t, std::size_t group);
    /// The group's write is to be repeated: its commands wait again, without the outdated ones.
    void requeue_group(Instant t, std::size_t group);
    /// Members that read back equal are done, though the group differs.
    void finish_group(Instant t, std::size_t group, value::CommandResult result, value::Reason reason);
    /// Other groups write the variables from now on. Waiting commands go with them.
    /// @param place(command)  sets its group and its bucket
    template <class Place>
    void regroup(const Place& place) {
        waiting_.clear();
        for (auto& command : commands_) {
            place(command);
            if (command.group && command.progress.queued()) ++waiting_of(*command.group);
        }
    }

    // ---- commands alone whose value a write of a group writes too

    /// The value is sent with a group.
    void carry(std::size_t variable, const value::Value& value);
    /// The write in flight to the device has ended.
    void end_carry(std::size_t device, bool sent);

private:
    template <class Goes, class End>
    void end_those(const Goes& goes, const End& end);
    [[nodiscard]] std::uint16_t& waiting_of(std::size_t group);
    void withdraw(Instant t, const PendingCommand& command, value::CommandResult unsent,
                  value::Reason reason);
    void conclude(Instant t, const PendingCommand& command, value::CommandResult result,
                  value::Reason reason);
    void forget_wanted(const PendingCommand& command);

    WrittenValues& values_;
    std::size_t capacity_;
    std::vector<PendingCommand> commands_;
    std::list<value::CommandOutcome> outcomes_;  // needs no memory while it is empty
    std::vector<std::uint16_t> waiting_;         // by group; shorter if the last ones have none
};

}  // namespace takt::poll
