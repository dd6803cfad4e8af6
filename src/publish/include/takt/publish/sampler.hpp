// The samples of all outputs, without a thread: from the events of a host into the feeds.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "takt/host/session.hpp"
#include "takt/publish/sample_feed.hpp"
#include "takt/publish/wall_clock.hpp"

namespace takt::publish {

/// What a Sampler needs of its owner. Called from inside its functions.
class SamplerOwner {
public:
    /// Another configuration runs. The feeds of the former one are not used any more.
    /// @returns the feeds of the outputs, which live until the next call
    virtual std::vector<SampleFeed*> on_configuration(Instant now,
                                                      const host::ConfigurationPtr& configuration) = 0;
    /// Samples are in a queue that was empty. @param feed  index in the list of on_configuration()
    virtual void on_enqueued(std::size_t feed) = 0;
    /// The state of a line or device changed.
    virtual void on_state_changed() = 0;

protected:
    ~SamplerOwner() = default;
};

/// Reads the events of a host for all outputs, samples what is due, and collects samples for 50 ms. Events
/// that were lost are counted in every feed, and the current state of all values follows them. A feed whose
/// destination has lost the values that it keeps gets these again (SampleQueue::request_retained()).
///
/// Reads no clock and waits for snapshots only, so that tests and the simulation drive it by hand. One
/// thread.
class Sampler {
public:
    /// @param session, owner  outlive it; the session has events
    Sampler(host::Session& session, SamplerOwner& owner, WallClock wall_ns, Instant now);

    /// To be called when the session has something to be read, and at next_wakeup().
    void step(Instant now);
    [[nodiscard]] Instant next_wakeup() const;
    /// The last call: samples what the session still has.
    void finish(Instant now);

private:
    /// How long samples are collected before they go to the journal together.
    static constexpr Duration kCollect = std::chrono::milliseconds(50);
    static constexpr Duration kSnapshotAgain = std::chrono::seconds(1);

    void follow_configuration(Instant now);
    void read_events(Instant now);
    void on_event(const host::Event& event);
    void count_lost(Instant now, Instant next_event);
    void sample_due(Instant now);
    void deliver_current(Instant now);
    /// When values that a destination has lost are to be delivered again; kNever: none has lost them.
    [[nodiscard]] Instant retained_at() const;
    void deliver_retained(Instant now);
    [[nodiscard]] std::optional<host::Snapshot> take_snapshot(Instant now);
    void flush();
    void set_clocks(Instant now);

    host::Session& session_;
    SamplerOwner& owner_;
    WallClock wall_ns_;
    host::ConfigurationPtr configuration_;
    std::vector<SampleFeed*> feeds_;
    Instant flush_at_ = kNever;
    Instant current_at_ = kNever;              // when the current state of all values is to be delivered
    Instant retained_again_ = Instant::min();  // of deliver_retained(), after a snapshot that failed
    Instant last_event_;                       // time of the last event that was read
    std::uint64_t missed_ = 0;                 // of the session, counted so far
    std::uint64_t lost_ = 0;                   // reported by the host, not counted yet
};

}  // namespace takt::publish
