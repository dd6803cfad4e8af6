// One run of the program under test: the I/O thread, the sampling thread and the thread of the output of a
// host, driven step by step.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "bus.hpp"
#include "clock.hpp"
#include "disk.hpp"
#include "engine/host_link.hpp"
#include "engine/project_engine.hpp"
#include "network.hpp"
#include "scenario.hpp"
#include "takt/publish/output_engine.hpp"
#include "takt/publish/sampler.hpp"

namespace takt::gatewaysim {

/// What the rest of the world learns of the program.
class GatewayObserver {
public:
    /// Samples enter the output.
    /// @param fits  the queue of the output takes them
    virtual void on_queued(const publish::QueuedSamples& samples, bool fits) = 0;
    /// The sampling thread begins a step, and has ended it.
    virtual void before_sampling() = 0;
    virtual void after_sampling() = 0;
    virtual void on_host_event(const host::Event& event) = 0;
    virtual void on_audit(std::string_view line) = 0;

protected:
    ~GatewayObserver() = default;
};

class Gateway final : private publish::SamplerOwner, private LineOwner {
public:
    Gateway(const Scenario& scenario, const Clock& clock, Bus& bus, Disk& disk, Network& network,
            GatewayObserver& observer, std::uint64_t random);
    ~Gateway();
    Gateway(const Gateway&) = delete;
    Gateway& operator=(const Gateway&) = delete;

    /// Something happened on the lines.
    void after_lines();
    /// The earliest step of any thread.
    [[nodiscard]] Instant next_step() const;
    /// Does the steps that are due. @returns whether the output did one
    bool step();

    void stall_sampler(Instant until) { sampler_stalled_ = until; }
    void stall_output(Instant until) { output_stalled_ = until; }
    void begin_stop();
    [[nodiscard]] bool is_stopped() const { return stopped_; }

    [[nodiscard]] publish::OutputStatus status() const { return output_->status(); }

private:
    std::vector<publish::SampleFeed*> on_configuration(Instant now,
                                                       const host::ConfigurationPtr& configuration) override;
    void on_enqueued(std::size_t feed) override;
    void on_state_changed() override;
    Engine& engine(std::size_t line) override { return engine_->master().line(line); }
    void on_link(Instant t, std::size_t line, bool up) override;
    bool must_reconnect(std::size_t line) override { return engine_->master().line(line).must_reconnect(); }

    void make_engine();
    void make_output();
    [[nodiscard]] std::unique_ptr<publish::OutputWork> make_work();
    [[nodiscard]] std::unique_ptr<host::Session> open_session(const host::SessionOptions& options);
    void on_posted(const host::HostRequest& request);
    void step_host();
    void step_sampler();
    void step_output();
    void publish();
    void move_queue();
    void wake_sampler();
    void wake_output();
    [[nodiscard]] Duration latency();

    const Scenario& scenario_;
    const Clock& clock_;
    Bus& bus_;
    Disk& disk_;
    Network& network_;
    GatewayObserver& observer_;
    sim::Random random_;
    std::uint64_t run_;  // a number that no other run has

    std::shared_ptr<host::HostLink> link_;
    std::unique_ptr<host::ProjectEngine> engine_;
    std::unique_ptr<host::Session> judge_session_;
    std::unique_ptr<host::Session> events_;
    publish::SampleQueue sampled_;  // between the feed and the queue of the output
    std::unique_ptr<publish::SampleFeed> feed_;
    std::optional<publish::Sampler> sampler_;
    std::unique_ptr<publish::OutputEngine> output_;
    host::SessionId output_session_ = 0;

    Instant host_due_;
    Instant requests_due_ = kNever;
    Instant sampler_due_;
    Instant output_due_;
    Instant sampler_stalled_{};
    Instant output_stalled_{};
    std::uint64_t events_seen_ = 0;
    bool state_changed_ = false;
    bool stopping_ = false;
    bool stopped_ = false;
};

}  // namespace takt::gatewaysim
