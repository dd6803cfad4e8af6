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

bool relays_to(const EndpointSpec& spec, std::size_t line) {
    return std::ranges::find(spec.relays, line, &model::Relay::line) != spec.relays.end();
}

}  // namespace

// A reply for an endpoint that was closed is dropped.
EndpointSet::EndpointSet(std::vector<EndpointSpec> specs, Environment environment)
    : environment_(std::move(environment)),
      gateways_(environment_.loop, [this](const serve::Gateway::Reply& reply) {
          const auto found = std::ranges::find(endpoints_, reply.server, &Endpoint::id);
          if (found != endpoints_.end()) (*found)->handler().on_relayed(reply);
      }) {
    for (auto& spec : specs) add(std::move(spec));
}

// Bindings must not outlive what feeds them.
EndpointSet::~EndpointSet() {
    for (const auto& endpoint : endpoints_) endpoint->disconnect();
}

void EndpointSet::add(EndpointSpec spec) {
    const ServedProject& served = environment_.served;
    for (const auto& relay : spec.relays)
        if (!gateways_.has(relay.line))
            gateways_.add(relay.line, served.project->lines[relay.line], served.lines(relay.line));
    auto& made =
        *endpoints_.emplace_back(std::make_unique<Endpoint>(next_id_++, std::move(spec), environment_));
    made.handler().set_routes(gateways_.routes(made.id(), made.spec().relays));
}

Result<void> EndpointSet::open() {
    report_access();
    return open(endpoints_);
}

Result<void> EndpointSet::open(Endpoints endpoints) {
    for (const auto& endpoint : endpoints) TAKT_CHECK(open_audit(*endpoint));
    TAKT_CHECK(open_sources(endpoints));
    for (const auto& endpoint : endpoints) TAKT_CHECK(endpoint->open_retained());
    for (const auto& endpoint : endpoints) TAKT_CHECK(endpoint->listen());
    return {};
}

Result<void> EndpointSet::open_audit(Endpoint& endpoint) {
    const std::string& path = endpoint.spec().audit;
    if (path.empty()) return {};
    if (!audits_.contains(path)) {
        TAKT_TRY(auto log, AuditLog::open(path));
        audits_.emplace(path, std::move(log));
    }
    std::shared_ptr<AuditSink> sink = audits_.at(path);
    if (environment_.audit) sink = std::make_shared<ObservedAudit>(std::move(sink), environment_.audit);
    endpoint.handler().audit().set_sink(std::move(sink));
    return {};
}

Result<void> EndpointSet::open_sources(Endpoints endpoints) {
    const auto& [project, values, lines] = environment_.served;
    if (!project || !values || endpoints.empty()) return {};
    if (!feeds_)
        feeds_.emplace(environment_.loop, *project, folder_of(*project), values->store(),
                       environment_.source_log);
    for (const auto& endpoint : endpoints) TAKT_CHECK(endpoint->connect(*feeds_, *values));
    return feeds_->open();
}

void EndpointSet::leave(const model::Project& next) {
    gateways_.take_back();
    const auto& project = *environment_.served.project;
    const auto continued = model::continued_servers(project, next);
    const auto stays = [&](const std::unique_ptr<Endpoint>& endpoint) {
        const auto in_next = std::ranges::find(next.servers, endpoint->spec().name, &model::Server::name);
        return in_next != next.servers.end() &&
               continued[static_cast<std::size_t>(in_next - next.servers.begin())].has_value();
    };
    const auto leaving = std::ranges::stable_partition(endpoints_, stays);
    Statistics dropped;
    end(Endpoints(leaving), dropped);
    endpoints_.erase(leaving.begin(), leaving.end());
    finish_unused_audits();
    auto gateways = model::continued_gateways(project, next);
    for (auto& line : gateways)
        if (line && std::ranges::none_of(
                        endpoints_, [&](const auto& endpoint) { return relays_to(endpoint->spec(), *line); }))
            line.reset();
    gateways_.renumber(gateways);
}

Result<void> EndpointSet::enter(std::vector<EndpointSpec> specs, ServedProject served) {
    environment_.served = std::move(served);
    std::optional<Error> error;
    const auto note = [&error](const Result<void>& done) {
        if (!done && !error) error = done.error();
        return done.has_value();
    };
    if (feeds_) (void)note(feeds_->change(*environment_.served.project, environment_.served.values->store()));
    auto kept = std::exchange(endpoints_, {});
    for (auto& spec : specs) {
        const auto stays = std::ranges::find_if(
            kept, [&](const auto& endpoint) { return endpoint && endpoint->spec().name == spec.name; });
        if (stays != kept.end()) {
            (*stays)->enter(spec);
            if (feeds_) (void)note((*stays)->reconnect(*feeds_, *environment_.served.values));
            endpoints_.push_back(std::move(*stays));
            continue;
        }
        add(std::move(spec));
        const Endpoints added = std::span(endpoints_).last(1);
        if (note(open(added))) continue;
        Statistics dropped;
        end(added, dropped);
        endpoints_.pop_back();
    }
    finish_unused_audits();
    report_access();
    if (error) return std::unexpected(*error);
    return {};
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

void EndpointSet::report_access() const {
    std::size_t rules = 0;
    for (const auto& endpoint : endpoints_) {
        const EndpointSpec& spec = endpoint->spec();
        rules = spec.access.size() + (spec.access_is_override ? 0 : rules);
    }
    if (rules > 0) report_access(rules);
}

void EndpointSet::report_access(std::size_t rules) const {
    environment_.notify(
        {Notice::Severity::status, "endpoint.access.in_force", {{"count", std::to_string(rules)}}, {}});
}

Statistics EndpointSet::statistics() const {
    Statistics statistics;
    for (const auto& endpoint : endpoints_) endpoint->add_statistics(statistics);
    statistics.relayed = gateways_.statistics();
    add_instruments(statistics);
    return statistics;
}

void EndpointSet::add_instruments(Statistics& statistics) const {
    for (std::size_t i = 0; feeds_ && i < feeds_->instruments(); ++i)
        statistics.instruments.push_back({feeds_->instrument_name(i), feeds_->state(i), feeds_->counters(i)});
}

void EndpointSet::refresh(Statistics& statistics) const {
    std::span listeners(statistics.listeners);
    std::span retained(statistics.retained);
    for (const auto& endpoint : endpoints_) endpoint->refresh(listeners, retained);
    gateways_.refresh(statistics.relayed);
    for (std::size_t i = 0; i < statistics.instruments.size() && feeds_ && i < feeds_->instruments(); ++i) {
        statistics.instruments[i].state = feeds_->state(i);
        statistics.instruments[i].counters = feeds_->counters(i);
    }
}

Statistics EndpointSet::close() {
    Statistics statistics;
    end(endpoints_, statistics);
    statistics.relayed = gateways_.statistics();
    add_instruments(statistics);
    for (auto& [path, log] : audits_) finish(path, *log);
    audits_.clear();
    return statistics;
}

void EndpointSet::end(Endpoints endpoints, Statistics& statistics) {
    for (const auto& endpoint : endpoints) endpoint->finish_retained(statistics);
    for (const auto& endpoint : endpoints) endpoint->close(statistics);
    for (const auto& endpoint : endpoints) endpoint->handler().forget_relayed();
    for (const auto& endpoint : endpoints) endpoint->handler().audit().set_sink(nullptr);
}

void EndpointSet::finish_unused_audits() {
    std::erase_if(audits_, [&](auto& audit) {
        const auto& [path, log] = audit;
        if (std::ranges::any_of(endpoints_, [&](const auto& user) { return user->spec().audit == path; }))
            return false;
        finish(path, *log);
        return true;
    });
}

void EndpointSet::finish(const std::string& path, AuditLog& log) const {
    if (const std::uint64_t failures = log.finish(); failures > 0)
        environment_.notify({Notice::Severity::error,
                             "endpoint.audit.failed",
                             {{"file", path}, {"count", std::to_string(failures)}},
                             {}});
}

bool has_access_rules(const std::vector<EndpointSpec>& specs) {
    return std::ranges::any_of(specs, [](const EndpointSpec& spec) { return !spec.access.empty(); });
}

}  // namespace takt::endpoint
