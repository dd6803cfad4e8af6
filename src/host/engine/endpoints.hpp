// The servers of a running project.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "engine/project_engine.hpp"
#include "engine/traffic_publisher.hpp"
#include "takt/endpoint/endpoint_set.hpp"
#include "takt/host/configuration.hpp"
#include "takt/host/project_host.hpp"
#include "takt/line/loop.hpp"

namespace takt::host {

/// The endpoints of the project that runs, on its values and lines. The I/O thread only, or while there is
/// none.
class Endpoints {
public:
    struct Surroundings {
        line::Loop& loop;
        HostLink& link;
        /// Describes the servers of a project; with a port, or without one for tests.
        std::function<std::vector<endpoint::EndpointSpec>(const model::Project&)> specs;
        std::function<Instant()> now;
        std::function<ProjectEngine&()> engine;  ///< the one that runs
        endpoint::NoticeSink notify;
        std::function<Log(std::string_view category)> log;
        std::function<void(std::size_t line)> poke;  ///< the driver of a line has something to send
    };

    /// Opens the project's servers. @returns as endpoint::EndpointSet::open()
    [[nodiscard]] static Result<std::unique_ptr<Endpoints>> open(Surroundings surroundings);
    ~Endpoints();
    Endpoints(const Endpoints&) = delete;
    Endpoints& operator=(const Endpoints&) = delete;

    /// Another project is about to run: its lines are idle. As endpoint::EndpointSet::leave(). Until enter()
    /// the running engine exists, also when the next one has taken over.
    void leave(const model::Project& next);
    /// It runs. @returns as endpoint::EndpointSet::enter()
    [[nodiscard]] Result<void> enter();

    /// Called after each call of a line's engine, before the driver sends.
    void after_line_event(Instant t, std::size_t line) { set_->after_line_event(t, line); }

    /// @returns as endpoint::EndpointSet::set_access()
    [[nodiscard]] bool set_access(const model::Project& project) { return set_->set_access(project); }

    /// As ProjectEngine::EndpointCounters.
    [[nodiscard]] bool copy_counters(const EndpointNames& names, endpoint::Statistics& into) const;

    /// Of the server of that index in the project.
    [[nodiscard]] endpoint::Endpoint& operator[](std::size_t index) { return (*set_)[index]; }

    /// Closes everything and writes the rest of the retained registers.
    endpoint::Statistics close() { return set_->close(); }

private:
    class PolledLine;
    class Values;

    explicit Endpoints(Surroundings surroundings);
    [[nodiscard]] ProjectEngine& engine() const { return surroundings_.engine(); }
    [[nodiscard]] endpoint::ServedProject served();
    [[nodiscard]] line::TrafficFactory traffic();
    void publish_names();

    ConfigurationPtr configuration_;
    Surroundings surroundings_;
    std::unique_ptr<Values> values_;
    std::vector<std::unique_ptr<PolledLine>> lines_;  // by index
    std::vector<std::weak_ptr<TrafficPublisher>> traffic_;
    std::unique_ptr<endpoint::EndpointSet> set_;
    EndpointNames names_;
};

}  // namespace takt::host
