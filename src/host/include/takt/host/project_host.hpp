// A project at work: its lines polled, its servers answering, for any number of faces. docs/architecture.md.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>

#include "takt/base/log.hpp"
#include "takt/base/result.hpp"
#include "takt/endpoint/statistics.hpp"
#include "takt/host/configuration.hpp"
#include "takt/host/session.hpp"
#include "takt/model/project.hpp"
#include "takt/plan/plan.hpp"
#include "takt/sim/devices.hpp"

namespace takt::line {
class Loop;
}

namespace takt::host {

struct HostOptions {
    std::string project_file;  ///< the files of servers are beside it
    std::string state_file;    ///< of retained values; empty: nothing is kept
    bool learn = true;         ///< devices with `gaps: learn` are tried; false: exactly the plan is run
    std::string learnt_file;   ///< where that is kept; empty: nowhere
    /// Frames are recorded from the start on, also while no tap is open: a session that is opened with
    /// `from_beginning` then gets the first one.
    bool record_traffic = false;
    /// Prepares the devices of a simulated line before it starts; may be empty.
    std::function<void(std::size_t line, sim::Devices& devices)> prepare;
    /// The I/O thread calls it once, before its loop runs; may be empty.
    std::function<void(line::Loop& loop)> begin_thread;
    std::function<Log(std::string_view category)> log;  ///< may be empty: silent
    /// Gets the notices of a start that fails, which no session can read; may be empty.
    std::function<void(const Notice&)> on_failed_start;
};

/// Runs a project on an I/O thread of its own, which opens its lines and servers, polls and writes.
///
/// Threads: every member except the destructor may be called from any thread. Nothing that a session does
/// or leaves undone can hold up the I/O thread. In steady state (polling and publishing: no command, no
/// apply(), no client whose answer must wait) it allocates nothing, and takes only the mutex of its loop's
/// task queue, which other threads hold to enqueue a task. Exception: with `retain` it enqueues the values
/// that changed, each second, for the thread that writes them. This allocates, and takes the mutex of that
/// queue, which the writing thread does not hold while it writes to the disk.
class ProjectHost {
public:
    /// Opens everything and begins. Hosts are connected to in the background.
    /// @returns what opening a serial port, a server's address, its files or its sources returns
    [[nodiscard]] static Result<std::unique_ptr<ProjectHost>> start(model::Project project, plan::Plan plan,
                                                                    const HostOptions& options);
    /// stop()
    ~ProjectHost();
    ProjectHost(const ProjectHost&) = delete;
    ProjectHost& operator=(const ProjectHost&) = delete;

    /// Ends polling and serving, gives every command its outcome and writes what is retained and learnt. A
    /// second call does nothing.
    void stop();

    /// @returns queue_full (HostLink::kMostSessions), connection_lost after stop()
    [[nodiscard]] Result<std::unique_ptr<Session>> open_session(const SessionOptions& options = {});

    [[nodiscard]] ConfigurationPtr configuration() const;
    /// When start() was called.
    [[nodiscard]] Instant started() const;

    /// Runs another project in place of the one that runs. Lines with the same name and connection stay open,
    /// and their devices keep health, phases and statistics where nothing about them changed; values of the
    /// same name and type are kept. A value that is newly retained, and was neither read nor set yet, has the
    /// value of the state file. Other lines are closed, or opened in the background. Polling pauses until the
    /// transactions in flight have ended; commands that wait longer than a second expire. Servers that
    /// continue (model::continued_servers()) keep their clients, what was written to them and their
    /// statistics, and relayed requests wait; the others are closed, or opened. Plan and engine are made on
    /// the calling thread.
    /// @returns connection_lost after stop(); the error of opening a server: the project runs without that
    /// server. One call at a time works, others wait.
    [[nodiscard]] Result<void> apply(model::Project project, plan::Plan plan);

    /// Puts the access rules of the project's servers in force, each at the running server of its name.
    /// Blocks until the I/O thread has done it. @returns false, and changes nothing, where a running server
    /// is not among them
    [[nodiscard]] bool set_access(const model::Project& project);

    /// The counters of the project's servers and gateways. After stop().
    [[nodiscard]] const endpoint::Statistics& served() const;

private:
    struct Impl;
    explicit ProjectHost(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace takt::host
