// Carries out the commands of sessions and endpoints on a poll::Master, each with exactly one outcome.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "engine/host_link.hpp"
#include "takt/base/result.hpp"
#include "takt/host/configuration.hpp"
#include "takt/host/event.hpp"
#include "takt/poll/master.hpp"
#include "takt/value/command.hpp"

namespace takt::host {

/// Makes a value survive the end of the run; what Retention does.
class ValuePersistence {
public:
    [[nodiscard]] virtual bool keeps(value::SlotId slot) const = 0;
    /// No further keep() is accepted until some have completed.
    [[nodiscard]] virtual bool full() const = 0;
    /// @param then  called once, perhaps from inside, with whether the value is on the disk
    virtual void keep(value::SlotId slot, std::function<void(bool kept)> then) = 0;

protected:
    ~ValuePersistence() = default;
};

/// The services that the executor needs of its surroundings.
class CommandSurroundings {
public:
    /// A slot was set or is to be written: the lines it concerns have something to do.
    virtual void on_changed(value::SlotId slot) = 0;
    virtual void on_finished(std::unique_ptr<CommandRequest> command) = 0;
    [[nodiscard]] virtual value::Value service_value(Instant t,
                                                     const model::ServiceVariable& variable) const = 0;
    /// For every write that ended, with or without a command, except those of endpoints.
    virtual void on_write_finished(const Outcome& outcome, SessionId session) = 0;
    /// For every write of a client of an endpoint.
    virtual void on_client_write_finished(const Outcome& outcome) = 0;

protected:
    ~CommandSurroundings() = default;
};

/// The life of a command: accepted by the master → outcome of the device → on the disk, where the variable is
/// retained → outcome to the session. A `set` of a variable that is written on change waits for the write for
/// at most kLongestSet; then it ends as `waiting`.
///
/// The I/O thread only. settle() hands on the reports that the engines make from inside their calls.
class CommandExecutor {
public:
    static constexpr Duration kCommandExpires = std::chrono::seconds(10);
    static constexpr Duration kLongestSet = std::chrono::seconds(10);
    /// A client of an endpoint waits no longer for the answer to its write.
    static constexpr Duration kEndpointWriteExpires = std::chrono::seconds(5);

    /// @param persistence  may be nullptr; all outlive it
    CommandExecutor(const Configuration& configuration, poll::Master& master, ValuePersistence* persistence,
                    CommandSurroundings& surroundings)
        : configuration_(configuration),
          master_(master),
          persistence_(persistence),
          surroundings_(surroundings) {}

    /// Of a service variable only `get` is executed: all others end with Code::read_only.
    void execute(Instant t, std::unique_ptr<CommandRequest> command);

    using Written = std::function<void(const value::CommandOutcome&)>;
    /// Writes a variable for a client of an endpoint.
    /// @param written  called once by settle(), unless the host stops before
    /// @returns what poll::Master::write() returns
    [[nodiscard]] Result<bool> write(Instant t, value::CommandId id, value::SlotId slot,
                                     const value::Value& value, Written written);

    /// From poll::PollObserver.
    void on_group_settled(Instant t, const poll::SettledGroup& group);
    void on_verify_failed(Instant t, value::SlotId slot, const value::Value& written,
                          const value::Value& read);
    /// A device does not answer, or a group waits for a value: its sets are not waited for any longer.
    void on_device_unavailable(std::size_t line, std::size_t device) {
        unavailable_.emplace_back(line, device);
    }

    /// Takes the outcomes of the master and hands on what has ended. After every call of an engine.
    void settle();
    /// Gives up waiting for sets that were accepted too long ago.
    void on_tick(Instant t);

    /// The run ends or the project changes: every command ends now, but for those that wait for the disk.
    void finish(Instant t);
    /// Last call: commands that still wait for the disk end as not retained. The retention may call back
    /// afterwards.
    void abandon_kept();

private:
    /// A `set` whose outcome waits until it is written, on the disk, or both.
    struct WaitingSet {
        std::unique_ptr<CommandRequest> command;
        Instant until = kNever;
        int parts = 1;
    };
    struct EndpointWrite {
        value::Value value;
        Written written;
    };
    /// The end of the write of one variable of a group.
    struct Settled {
        value::CommandOutcome outcome;
        std::optional<value::SlotId> trigger;
    };
    using WaitingSetPtr = std::shared_ptr<WaitingSet>;
    using KeptCommands = std::vector<WaitingSetPtr>;

    void set(Instant t, std::unique_ptr<CommandRequest> command);
    void pull(Instant t, std::unique_ptr<CommandRequest> command);
    void write(Instant t, std::unique_ptr<CommandRequest> command);
    [[nodiscard]] std::string service_name(const Command& command) const;
    void get(Instant t, std::unique_ptr<CommandRequest> command);
    void probe(Instant t, std::unique_ptr<CommandRequest> command);
    void refuse(Instant t, std::unique_ptr<CommandRequest> command, const Error& error);
    void part_done(WaitingSet& set);
    void end(std::unique_ptr<CommandRequest> command);
    void end_when_kept(std::unique_ptr<CommandRequest> command);
    void keep(const WaitingSetPtr& waiting);
    void take_outcomes();
    void settle_set(const Settled& settled);
    void give_up_sets(const std::function<bool(value::SlotId, const WaitingSet&)>& which);
    void give_up_unavailable();
    [[nodiscard]] bool is_written_on_change(value::SlotId slot) const;
    [[nodiscard]] bool is_written_soon(value::SlotId slot) const;

    const Configuration& configuration_;
    poll::Master& master_;
    ValuePersistence* persistence_;
    CommandSurroundings& surroundings_;
    std::map<value::CommandId, std::unique_ptr<CommandRequest>> pending_;  // writes without an outcome
    std::map<value::CommandId, EndpointWrite> endpoint_writes_;
    std::map<value::SlotId, WaitingSetPtr> sets_;               // the last of each variable
    std::map<value::SlotId, value::CommandOutcome> differing_;  // read back of a group at this moment
    std::shared_ptr<KeptCommands> kept_ = std::make_shared<KeptCommands>();  // wait for the disk
    std::vector<Settled> settled_;                                  // of groups, to be handed on by settle()
    std::vector<std::pair<std::size_t, std::size_t>> unavailable_;  // line and device, likewise
};

}  // namespace takt::host
