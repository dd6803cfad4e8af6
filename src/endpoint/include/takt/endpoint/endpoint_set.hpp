// All endpoints of a program.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "takt/base/result.hpp"
#include "takt/endpoint/endpoint.hpp"
#include "takt/endpoint/environment.hpp"
#include "takt/endpoint/gateway_set.hpp"
#include "takt/endpoint/spec.hpp"
#include "takt/endpoint/statistics.hpp"

namespace takt::endpoint {

/// The endpoints with what they share: audit logs by path, sources, gateways to the project's lines. The
/// loop's thread only.
class EndpointSet {
public:
    EndpointSet(std::vector<EndpointSpec> specs, Environment environment);
    ~EndpointSet();
    EndpointSet(const EndpointSet&) = delete;
    EndpointSet& operator=(const EndpointSet&) = delete;

    /// Opens everything: audit logs, sources, retained registers, listeners, in this order. Once.
    /// @returns what opening one of them returns
    [[nodiscard]] Result<void> open();

    /// Called from inside a line's driver after each call of the line's engine, before the driver sends.
    void after_line_event(Instant t, std::size_t line) { gateways_.after_line_event(t, line); }

    /// Puts these rules in force at all endpoints. Reports how many ("endpoint.access.in_force").
    void set_access(const std::vector<model::AccessRule>& rules);
    /// Puts the rules of the project's servers in force, each at the endpoint of its name. Reports likewise.
    /// @returns false, and changes nothing, where the project has no server for one of the endpoints
    [[nodiscard]] bool set_access(const model::Project& project);

    /// Another project is about to run, and no relayed transaction is in flight. Servers that continue stay
    /// open (model::continued_servers()), with their clients, what was written to them and what they counted;
    /// their relayed requests wait. The others are closed: their addresses are free. enter() must follow
    /// before the loop goes on. The project that runs and its values are valid until then.
    void leave(const model::Project& next);
    /// The other project runs: connects what stayed open with it, and opens the rest.
    /// @param specs  from all servers of `next`, in their order
    /// @returns the first error of what open() would return; the endpoint that has it is closed, the others
    /// work
    [[nodiscard]] Result<void> enter(std::vector<EndpointSpec> specs, ServedProject served);

    /// The counters so far.
    [[nodiscard]] Statistics statistics() const;
    /// The same into what statistics() returned after open(), without allocating.
    void refresh(Statistics& statistics) const;

    /// Closes everything, and writes what is left to be written. After open() only, also if it failed.
    /// @returns what was counted
    Statistics close();

    [[nodiscard]] std::size_t size() const { return endpoints_.size(); }
    [[nodiscard]] Endpoint& operator[](std::size_t index) { return *endpoints_[index]; }

private:
    using Endpoints = std::span<const std::unique_ptr<Endpoint>>;

    void add(EndpointSpec spec);
    Result<void> open(Endpoints endpoints);
    Result<void> open_audit(Endpoint& endpoint);
    Result<void> open_sources(Endpoints endpoints);
    void end(Endpoints endpoints, Statistics& statistics);
    void finish_unused_audits();
    void finish(const std::string& path, AuditLog& log) const;
    void add_instruments(Statistics& statistics) const;
    void report_access() const;
    void report_access(std::size_t rules) const;

    Environment environment_;
    GatewaySet gateways_;
    std::uint32_t next_id_ = 0;
    std::vector<std::unique_ptr<Endpoint>> endpoints_;
    std::map<std::string, std::shared_ptr<AuditLog>> audits_;  // by path
    std::optional<endpoint::Feeds> feeds_;
};

/// Whether any of them has access rules.
[[nodiscard]] bool has_access_rules(const std::vector<EndpointSpec>& specs);

}  // namespace takt::endpoint
