// One write of a line, whether of a group or of a command alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "devices/outcome_class.hpp"
#include "line/job_id.hpp"
#include "takt/base/result.hpp"
#include "writes/command_queue.hpp"
#include "writes/read_back.hpp"
#include "writes/write_groups.hpp"
#include "writes/write_progress.hpp"
#include "writes/written_values.hpp"

namespace takt::poll {

/// The steps of a write, the same for both kinds. It names the write and changes it in its owner: WriteGroups
/// or CommandQueue. The caller chooses when a step is sent and reports its end.
///
/// A handle: copies name the same write. It is valid until the write of a command has ended; spans and
/// references that it returns are valid until a command is added or ends. What it is given must outlive it.
/// Never allocates by itself.
class WriteJob {
public:
    struct Owners {
        WriteGroups& groups;
        CommandQueue& commands;
        WrittenValues& values;
    };

    /// @param id      of a group_write or a command
    /// @param device  that is written
    WriteJob(const Owners& owners, bus::TransactionId id, std::size_t device)
        : owners_(owners), id_(id), device_(device) {}

    [[nodiscard]] bus::TransactionId id() const { return id_; }
    [[nodiscard]] std::size_t device() const { return device_; }
    [[nodiscard]] bool of_group() const { return kind_of(id_) == JobKind::group_write; }
    /// Of the group: its request. Of the command: its order.
    [[nodiscard]] std::uint64_t index() const { return index_of(id_); }

    [[nodiscard]] const WriteProgress& progress() const;
    /// It begins with a read: a read-modify-write.
    [[nodiscard]] bool modifies() const;
    /// Its second step.
    [[nodiscard]] wire::Function function() const;
    /// The variables that it may write.
    [[nodiscard]] std::span<const std::size_t> members() const;
    /// The variables that it writes.
    [[nodiscard]] std::span<const std::size_t> written() const;
    /// Whether they may all be written again.
    [[nodiscard]] bool repeatable(std::span<const std::size_t> variables) const;
    /// The read that verifies it; nullptr: it is not verified.
    [[nodiscard]] const ReadBack* read_back() const;
    /// Without a bucket: whether it has taken its token of the line; else nullptr.
    [[nodiscard]] bool* line_token() const;

    // ---- its steps

    /// @returns its first transaction; an error: finish() must end it
    [[nodiscard]] Result<wire::PreparedRequest> begin();
    /// The second transaction of a read-modify-write. @param old  the register as read
    /// @returns an error: finish() must end it
    [[nodiscard]] Result<wire::PreparedRequest> second_step(Instant t, std::uint16_t old);
    void second_step_submitted();
    void transaction_ended();
    /// An attempt of the write itself has ended.
    void note_attempt(Execution execution);
    /// The device has confirmed it; it is to be read back.
    void await_read_back();
    void read_back_submitted();
    /// The read-back failed. @returns whether it is tried again
    bool read_back_again(Instant t, const OutcomeClass& outcome_class, std::uint16_t attempts);
    /// Another value was read back.
    void note_differs();

    // ---- its end

    /// The attempt failed and may be repeated.
    /// @param attempts  of the device
    /// @returns whether it is repeated: attempts are left
    bool retry(Instant t, const OutcomeClass& outcome_class, std::uint16_t attempts);
    /// It waits again: nothing was written.
    void requeue(Instant t);
    /// @returns what is reported of a group; of a command nothing: its outcome is in the queue
    WriteGroups::Settled finish(Instant t, value::CommandResult result, value::Reason reason);

private:
    [[nodiscard]] const WriteGroup& group() const { return owners_.groups[index()]; }
    [[nodiscard]] PendingCommand& command() const { return owners_.commands.at(index()); }

    Owners owners_;
    bus::TransactionId id_;
    std::size_t device_;
};

}  // namespace takt::poll
