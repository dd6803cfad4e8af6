// A host's engine on simulated lines in virtual time, with sessions: no thread, no port, no clock.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "allocations.hpp"
#include "engine/endpoints.hpp"
#include "engine/host_link.hpp"
#include "engine/project_engine.hpp"
#include "engine/traffic_publisher.hpp"
#include "takt/host/session.hpp"
#include "takt/sim/simulated_line.hpp"

namespace takt::host::test {

using namespace std::chrono_literals;

/// The project of a YAML text; a text with errors fails the test.
[[nodiscard]] model::Project project_of(const std::string& yaml);
[[nodiscard]] ConfigurationPtr configuration_of(const std::string& yaml, std::uint32_t generation = 1);

using takt::test::CountingAllocations;

/// Calls an engine with the allocation counter on, and `then` after each call, before the driver sends.
class CountedEngine final : public Engine {
public:
    using Then = std::function<void(Instant t)>;

    CountedEngine(Engine& engine, Then then) : engine_(&engine), then_(std::move(then)) {}
    void call(Engine& engine, Then then) {
        engine_ = &engine;
        then_ = std::move(then);
    }
    void on_link(Instant t, bool up) override;
    void on_bytes(Instant t, Bytes bytes) override;
    void on_tick(Instant t) override;
    Bytes transmit(Instant t) override;
    Instant next_wakeup() const override { return engine_->next_wakeup(); }

private:
    Engine* engine_;
    Then then_;
};

class Rig {
public:
    static constexpr std::size_t kRingWords = std::size_t{1} << 18;  // more than the events of a store

    /// @param start  of virtual time
    explicit Rig(const std::string& yaml, const ProjectEngine::Options& options = {},
                 Instant start = Instant{1s});

    /// Advances virtual time; publishes after each step of a line, serves requests and ticks as the I/O
    /// thread does.
    void run(Duration length);
    /// Serves what sessions asked for, without advancing time.
    void serve();

    /// A snapshot that was served; serving counts as I/O thread.
    /// @param more  as make_snapshot_buffer()
    [[nodiscard]] std::shared_ptr<SnapshotBuffer> snapshot(const SnapshotParts& parts, std::size_t more = 0);

    /// The driver of a line has something to send.
    void poke(std::size_t line) { lines_[line]->advance(now); }

    /// Applies another project as IoThread does. A line continues if its name and devices are the same.
    void apply(const std::string& yaml);

    [[nodiscard]] std::unique_ptr<Session> open(const SessionOptions& options = {});
    [[nodiscard]] value::SlotId slot(const std::string& name) const;
    [[nodiscard]] sim::Devices& devices(std::size_t line) { return lines_[line]->devices(); }

    std::shared_ptr<HostLink> link = std::make_shared<HostLink>(kRingWords);
    Instant now;
    std::unique_ptr<ProjectEngine> engine;
    Endpoints* endpoints = nullptr;  ///< the servers of the project; called as IoThread does

private:
    [[nodiscard]] Instant next() const;
    void step();
    [[nodiscard]] std::unique_ptr<ProjectEngine> make_engine(const ConfigurationPtr& configuration);
    void start_line(std::size_t index);
    [[nodiscard]] CountedEngine::Then then(std::size_t line);

    ProjectEngine::Options options_;

    std::vector<std::unique_ptr<TrafficPublisher>> traffic_;
    std::vector<std::unique_ptr<CountedEngine>> counted_;
    std::vector<std::unique_ptr<sim::SimulatedLine>> lines_;
    Instant next_tick_ = now;
};

/// All events of a session, oldest first.
[[nodiscard]] std::vector<Event> take_events(Session& session);

template <class Body>
[[nodiscard]] std::vector<Body> take_events_of(Session& session) {
    std::vector<Body> bodies;
    while (const auto event = session.next_event())
        if (const auto* body = std::get_if<Body>(&event->body)) bodies.push_back(*body);
    return bodies;
}

}  // namespace takt::host::test
