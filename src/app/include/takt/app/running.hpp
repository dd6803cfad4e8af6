// A project at work: lines opened and polled, commands taken, changes told.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
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

    /// Prepares the devices of a simulated line before it starts.
    using Prepare = std::function<void(std::size_t line, sim::Devices& devices)>;

    /// Opens the lines and begins. Simulated lines get the devices of the project.
    /// @param reporter  outlives it
    /// @param prepare   may be empty
    /// @returns what opening a serial port returns; hosts are connected to in the background
    [[nodiscard]] Result<void> begin(Reporter& reporter, const Prepare& prepare);

    /// Carries out a command; `quit` stops the loop.
    void execute(const ControlCommand& command, Reply reply);

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
    };

    [[nodiscard]] Result<void> open(std::size_t line, const Prepare& prepare);

    void on_device_state(Instant t, std::size_t line, std::size_t device, poll::DeviceState state) override;
    void on_overrun(Instant t, std::size_t line, std::size_t request, Duration period,
                    Duration real) override;
    void on_write_waiting(Instant t, std::size_t line, std::size_t request, std::size_t variable) override;
    void on_learnt(Instant t, std::size_t line, const poll::Lesson& lesson) override;

    void on_verify_failed(Instant t, std::size_t line, std::size_t device, std::size_t variable,
                          const value::Value& written, const value::Value& read) override;

    void tell_soon(Instant t);
    void later(std::function<void()> news);
    void set(const ControlCommand& command, value::SlotId slot, const value::Value& value,
             const Reply& reply);
    void write(const ControlCommand& command, value::SlotId slot, const value::Value& value, Reply reply);
    void get(const ControlCommand& command, value::SlotId slot, const Reply& reply) const;
    void take_outcomes();
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
    Reporter* reporter_ = nullptr;
    value::EventCursor cursor_;
    std::vector<std::function<void()>> news_;  // what the engines told, to be told on outside their calls
    line::Timer tell_timer_;
    line::Timer refresh_timer_;
    struct Pending {
        ControlCommand command;
        Reply reply;
    };
    std::map<value::CommandId, Pending> pending_;
    value::CommandId next_command_ = 1;
};

}  // namespace takt::app
