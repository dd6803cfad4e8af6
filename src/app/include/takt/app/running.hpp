// A project at work: lines opened and polled, commands taken, changes told.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "takt/app/answer.hpp"
#include "takt/app/control.hpp"
#include "takt/app/learner.hpp"
#include "takt/app/log.hpp"
#include "takt/app/reporter.hpp"
#include "takt/app/retention.hpp"
#include "takt/app/texts.hpp"
#include "takt/app/traffic_log.hpp"
#include "takt/line/connect_gate.hpp"
#include "takt/line/driver.hpp"
#include "takt/line/loop.hpp"
#include "takt/poll/master.hpp"
#include "takt/sim/simulated_line.hpp"

namespace takt::app {

/// Gets the answer to one command; may be called later, and is not called when the run ends before.
using Reply = std::function<void(const Answer&)>;

/// The master of a project on its lines. Everything happens on the loop's thread; what is to be told is told
/// a few milliseconds after it happened, so that formatting never delays the line.
class Running final : private poll::PollObserver {
public:
    /// @param project, plan, loop  outlive it
    /// @param traffic    may be nullptr
    /// What lasts longer than the run; each may be nullptr.
    struct Keepers {
        std::unique_ptr<Retention> retention;
        std::unique_ptr<Learner> learner;  ///< without it exactly the plan is run
    };
    Running(line::Loop& loop, const model::Project& project, const plan::Plan& plan, const Texts& texts,
            TrafficLog* log, Keepers keepers);
    ~Running();
    Running(const Running&) = delete;
    Running& operator=(const Running&) = delete;

    [[nodiscard]] Scene scene() const { return {project_, plan_, *master_, start_}; }

    [[nodiscard]] poll::LinePoller& line(std::size_t index) { return master_->line(index); }

    /// Whom to tell after everything that happens on a line, before it sends; at most one, empty: nobody.
    void watch_lines(std::function<void(Instant t, std::size_t line)> watcher) {
        watcher_ = std::move(watcher);
    }

    /// Something was given to a line to be sent.
    void poke_line(std::size_t line) {
        if (lines_[line].driver) lines_[line].driver->poke();
    }

    /// Prepares the devices of a simulated line before it starts.
    using Prepare = std::function<void(std::size_t line, sim::Devices& devices)>;

    /// Opens the lines and begins. Simulated lines get the devices of the project.
    /// @param reporter  outlives it
    /// @param prepare   may be empty
    /// @returns what opening a serial port returns; hosts are connected to in the background
    [[nodiscard]] Result<void> begin(Reporter& reporter, const Prepare& prepare);

    /// Whether the reporter, too, gets what is answered.
    enum class Hearer { asker, reporter };

    /// Carries out a command; `quit` stops the loop. What is not written, or not for sure, is told to the
    /// reporter whoever asked for it. A `set` that is written on change is answered when it was written or
    /// refused; or that it waits, when that cannot be soon, at the latest after ten seconds.
    /// @param hearer  reporter: `reply` tells it
    void execute(const ControlCommand& command, const Reply& reply, Hearer hearer = Hearer::asker);

    [[nodiscard]] const value::Store& values() const { return master_->store(); }

    /// Sets a local. @returns what poll::Master::set() returns
    [[nodiscard]] Result<bool> set_local(value::SlotId slot, const value::Value& value);

    using Written = std::function<void(const value::CommandOutcome&)>;
    /// Commands the write of a variable, for somebody who waits for it.
    /// @param written  called once when its outcome is known, never from inside; not when the run ends before
    /// @returns what poll::Master::write() returns; connection_lost while its line is not open: what is asked
    /// now is not to be written when it comes back. Then `written` is not called
    [[nodiscard]] Result<bool> write_value(value::SlotId slot, const value::Value& value, Written written);

    /// Tells what has happened and not been told yet.
    void tell();

    /// The run is over: writes what is retained, and answers who waited for it.
    void finish();

private:
    class Tap;
    struct Line {
        std::unique_ptr<LineTraffic> traffic;
        std::unique_ptr<Tap> tap;
        std::unique_ptr<sim::SimulatedLine> simulated;
        std::unique_ptr<line::Driver> driver;
        bool up = false;
    };

    [[nodiscard]] Result<void> open(std::size_t line, const Prepare& prepare);

    void on_device_state(Instant t, std::size_t line, std::size_t device, poll::DeviceState state) override;
    void on_overrun(Instant t, std::size_t line, std::size_t request, Duration period, Duration real,
                    bool overrun) override;
    void on_group_settled(Instant t, std::size_t line, std::size_t device,
                          std::span<const std::size_t> variables, value::CommandResult result,
                          value::Reason reason) override;
    void on_write_waiting(Instant t, std::size_t line, std::size_t request, std::size_t variable) override;
    void on_learnt(Instant t, std::size_t line, const poll::GapEvent& lesson) override;

    void on_verify_failed(Instant t, std::size_t line, std::size_t device, std::size_t variable,
                          const value::Value& written, const value::Value& read) override;

    void tell_soon(Instant t);
    void later(std::function<void()> news);
    // running_commands.cpp
    struct Asked {
        ControlCommand command;
        Reply reply;
        Hearer hearer = Hearer::asker;
        value::CommandId id = 0;
    };
    struct WaitingSet;
    void set(Asked asked, value::SlotId slot, const value::Value& value);
    void write(Asked asked, value::SlotId slot, const value::Value& value);
    void get(const Asked& asked, value::SlotId slot) const;
    void take_outcomes();
    [[nodiscard]] bool is_written_on_change(value::SlotId slot) const;
    [[nodiscard]] bool is_written_soon(value::SlotId slot) const;
    [[nodiscard]] Answer outcome_answer(const value::CommandOutcome& outcome) const;
    void settle_set(const value::CommandOutcome& outcome);
    void give_up_sets(const std::function<bool(value::SlotId, const WaitingSet&)>& which);
    void give_up_sets_of(std::size_t line, std::size_t device);
    void tell_unwritten(Instant t, const value::CommandOutcome& outcome, const Answer& answer);
    void answer_when_kept(value::SlotId slot, Answer answer, const Reply& reply);
    void poke(value::SlotId changed);
    [[nodiscard]] Answer error_answer(const ControlCommand& command, const Error& error) const;

    line::Loop& loop_;
    line::ConnectGate gate_;
    const model::Project& project_;
    const plan::Plan& plan_;
    Texts texts_;
    TrafficLog* traffic_;
    Log log_;
    Instant start_;
    std::vector<Line> lines_;
    std::unique_ptr<Retention> retention_;
    std::unique_ptr<Learner> learner_;
    std::unique_ptr<poll::Master> master_;
    std::function<void(Instant t, std::size_t line)> watcher_;
    Reporter* reporter_ = nullptr;
    value::EventCursor cursor_;
    std::vector<std::function<void()>> news_;  // what the engines told, to be told on outside their calls
    line::Timer tell_timer_;
    line::Timer refresh_timer_;
    std::map<value::CommandId, Asked> pending_;
    std::map<value::SlotId, std::shared_ptr<WaitingSet>> sets_;  // the last of each variable
    std::map<value::SlotId, value::CommandOutcome> differing_;   // what was read back of a group just now
    std::map<value::CommandId, Written> passed_on_;
    value::CommandId next_command_ = 1;
};

}  // namespace takt::app
