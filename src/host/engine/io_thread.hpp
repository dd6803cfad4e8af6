// The I/O thread of a host: the event loop, the lines and endpoints, and the engine.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "engine/applied_project.hpp"
#include "engine/endpoints.hpp"
#include "engine/host_link.hpp"
#include "engine/line_set.hpp"
#include "engine/project_engine.hpp"
#include "takt/host/project_host.hpp"
#include "takt/line/loop.hpp"

namespace takt::host {

struct ApplyRequest;

/// Made and opened by the thread that starts the host; from begin() to end() only the I/O thread uses it,
/// except where stated.
class IoThread {
public:
    IoThread(std::shared_ptr<HostLink> link, std::unique_ptr<line::Loop> loop, HostOptions options);
    ~IoThread();
    IoThread(const IoThread&) = delete;
    IoThread& operator=(const IoThread&) = delete;

    /// @returns as ProjectHost::start()
    [[nodiscard]] Result<void> open(const ConfigurationPtr& configuration);
    void begin();
    /// Ends an apply() that waits, too. Any thread.
    void ask_to_end();
    /// Ends the thread. Accepted commands have their outcomes. @returns false when it had ended before
    bool end();

    [[nodiscard]] ProjectEngine& engine() { return *engine_; }
    [[nodiscard]] Instant started() const { return started_; }
    /// The notices of open().
    [[nodiscard]] const std::vector<Notice>& opening_notices() const { return opening_notices_; }

    /// After end().
    [[nodiscard]] const endpoint::Statistics& served() const { return served_; }

    /// The I/O thread: puts the access rules of the project's servers in force. @returns false: they do not
    /// fit
    [[nodiscard]] bool set_access(const model::Project& project);

    /// Makes the engine of another project; the thread that applies it, while no other does.
    [[nodiscard]] std::unique_ptr<ApplyRequest> prepare(const ConfigurationPtr& next);
    /// Begins to hold the running engine; the request is completed when it is quiet.
    void apply(Instant t, std::unique_ptr<ApplyRequest> request);

private:
    [[nodiscard]] Log log(std::string_view category) const;
    [[nodiscard]] endpoint::NoticeSink notices();
    void append(const Notice& notice);
    void append_waiting();
    [[nodiscard]] Result<void> open_endpoints();
    void offer_endpoint_counters();
    void after_line_event(Instant t, std::size_t line);
    void open_files(const Configuration& configuration);
    [[nodiscard]] std::unique_ptr<ProjectEngine> make_engine(
        const ConfigurationPtr& configuration, const std::vector<std::shared_ptr<TrafficPublisher>>& traffic);
    [[nodiscard]] Result<void> watch_requests();
    void run();
    void serve(Instant t);
    void on_tick(Instant t);
    void publish(Instant t);
    void publish_soon(Instant t);
    void switch_when_quiet(Instant t);
    void switch_project(Instant t);

    std::shared_ptr<HostLink> link_;
    std::unique_ptr<line::Loop> loop_;
    HostOptions options_;
    Instant started_;
    std::unique_ptr<Retention> retention_;
    std::unique_ptr<LearningPlanner> learner_;
    std::unique_ptr<ProjectEngine> engine_;
    LineSet lines_;
    std::unique_ptr<Endpoints> endpoints_;    // nullptr: the project has no servers
    endpoint::Statistics served_;             // of the endpoints, after the end
    std::unique_ptr<ApplyRequest> applying_;  // nullptr: no project is being applied
    std::unique_ptr<line::Watch> requests_;
    line::Timer serve_timer_;
    line::Timer publish_timer_;
    line::Timer tick_timer_;
    std::mutex notices_mutex_;             // held for an append or a swap only
    std::vector<Notice> waiting_notices_;  // of other threads
    std::vector<Notice> opening_notices_;
    std::atomic<std::thread::id> io_thread_{};  // none: it has not begun
    std::thread thread_;
};

/// Another project on its way to the I/O thread.
struct ApplyRequest final : HostRequest {
    ApplyRequest(IoThread& thread, std::vector<std::shared_ptr<TrafficPublisher>> observers)
        : io(thread), traffic(std::move(observers)) {}

    void serve(ProjectEngine& running, Instant t, std::unique_ptr<HostRequest> self) override;
    void refuse(HostLink& link, std::unique_ptr<HostRequest> self) override;

    IoThread& io;
    std::vector<std::shared_ptr<TrafficPublisher>> traffic;  // outlive the engine
    std::unique_ptr<ProjectEngine> engine;
    std::vector<std::optional<std::size_t>> continued;  // by line: the running line that it continues
    std::shared_ptr<AppliedProject> applied = std::make_shared<AppliedProject>();
    Instant give_up_at = kNever;  // commands that still wait then expire
};

}  // namespace takt::host
