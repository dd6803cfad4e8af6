#include "takt/endpoint/endpoint_set.hpp"

#include <algorithm>
#include <filesystem>
#include <span>
#include <utility>

namespace takt::endpoint {
namespace {

std::string folder_of(const model::Project& project) {
    if (project.files.empty()) return {};
    return std::filesystem::path(project.files[0]).parent_path().string();
}

}  // namespace

EndpointSet::EndpointSet(std::vector<EndpointSpec> specs, Environment environment)
    : environment_(std::move(environment)),
      relay_(environment_.loop, [this](const relay::Gateway::Reply& reply) {
          endpoints_[reply.server]->handler().on_relayed(reply);
      }) {
    std::vector<bool> added;
    for (auto& spec : specs) {
        for (const auto& relay : spec.relays) {
            added.resize(std::max(added.size(), relay.line + 1));
            if (!added[relay.line])
                relay_.add(relay.line, environment_.project->lines[relay.line],
                           environment_.lines(relay.line));
            added[relay.line] = true;
        }
        endpoints_.push_back(std::make_unique<Endpoint>(std::move(spec), environment_));
        Endpoint& made = *endpoints_.back();
        made.handler().set_routes(relay_.routes(endpoints_.size() - 1, made.spec().relays));
    }
}

// Bindings must not outlive what feeds them.
EndpointSet::~EndpointSet() {
    for (const auto& endpoint : endpoints_) endpoint->disconnect();
}

Result<void> EndpointSet::open() {
    TAKT_CHECK(open_audits());
    TAKT_CHECK(open_sources());
    for (const auto& endpoint : endpoints_) TAKT_CHECK(endpoint->open_retained());
    for (const auto& endpoint : endpoints_) TAKT_CHECK(endpoint->listen());
    return {};
}

Result<void> EndpointSet::open_audits() {
    std::size_t rules = 0;
    for (const auto& endpoint : endpoints_) {
        const EndpointSpec& spec = endpoint->spec();
        rules = spec.access.size() + (spec.access_is_override ? 0 : rules);
        if (spec.audit.empty()) continue;
        if (!audits_.contains(spec.audit)) {
            TAKT_TRY(auto log, AuditLog::open(spec.audit));
            audits_.emplace(spec.audit, std::move(log));
        }
        std::shared_ptr<AuditSink> sink = audits_.at(spec.audit);
        if (environment_.audit) sink = std::make_shared<ObservedAudit>(std::move(sink), environment_.audit);
        endpoint->handler().audit().set_sink(std::move(sink));
    }
    if (rules > 0) report_access(rules);
    return {};
}

Result<void> EndpointSet::open_sources() {
    if (!environment_.project || !environment_.values || endpoints_.empty()) return {};
    feeds_.emplace(environment_.loop, *environment_.project, folder_of(*environment_.project),
                   environment_.values->store(), environment_.source_log);
    for (const auto& endpoint : endpoints_) TAKT_CHECK(endpoint->connect(*feeds_, *environment_.values));
    return feeds_->open();
}

void EndpointSet::set_access(const std::vector<model::AccessRule>& rules) {
    for (const auto& endpoint : endpoints_) endpoint->handler().set_access(rules);
    report_access(rules.size());
}

bool EndpointSet::set_access(const model::Project& project) {
    const auto server_of = [&](const auto& endpoint) {
        return std::ranges::find(project.servers, endpoint->spec().name, &model::Server::name);
    };
    if (std::ranges::any_of(
            endpoints_, [&](const auto& endpoint) { return server_of(endpoint) == project.servers.end(); }))
        return false;
    std::size_t rules = 0;
    for (const auto& endpoint : endpoints_) {
        endpoint->handler().set_access(server_of(endpoint)->access);
        rules += server_of(endpoint)->access.size();
    }
    report_access(rules);
    return true;
}

void EndpointSet::report_access(std::size_t rules) const {
    environment_.notify(make_notice("app.access.in_force", {{"count", std::to_string(rules)}}));
}

Statistics EndpointSet::statistics() const {
    Statistics statistics;
    for (const auto& endpoint : endpoints_) endpoint->add_statistics(statistics);
    statistics.relayed = relay_.statistics();
    return statistics;
}

void EndpointSet::refresh(Statistics& statistics) const {
    std::span listeners(statistics.listeners);
    std::span retained(statistics.retained);
    for (const auto& endpoint : endpoints_) endpoint->refresh(listeners, retained);
    relay_.refresh(statistics.relayed);
}

Statistics EndpointSet::close() {
    Statistics statistics;
    for (const auto& endpoint : endpoints_) endpoint->finish_retained(statistics);
    for (const auto& endpoint : endpoints_) endpoint->close(statistics);
    for (const auto& endpoint : endpoints_) endpoint->handler().forget_relayed();
    statistics.relayed = relay_.statistics();
    for (const auto& endpoint : endpoints_) endpoint->handler().audit().set_sink(nullptr);
    for (auto& [path, log] : audits_)
        if (const std::uint64_t failures = log->finish(); failures > 0)
            environment_.notify(
                make_notice("app.audit.failed", {{"file", path}, {"count", std::to_string(failures)}}));
    audits_.clear();
    return statistics;
}

bool has_access_rules(const std::vector<EndpointSpec>& specs) {
    return std::ranges::any_of(specs, [](const EndpointSpec& spec) { return !spec.access.empty(); });
}

}  // namespace takt::endpoint
