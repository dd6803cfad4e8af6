#include "place_access.hpp"

#include <algorithm>
#include <utility>

#include "takt/app/console.hpp"
#include "takt/app/project.hpp"

namespace takt::app {

Result<void> PlaceAccess::begin(std::vector<model::AccessRule> rules) {
    std::size_t count = 0;
    for (const auto& place : places_) {
        if (!place.guard) continue;
        const auto& own = options_.access.empty() ? place.access : rules;
        place.guard->set_rules(own);
        count += own.size();
        if (place.audit.empty()) continue;
        auto& log = logs_[place.audit];
        if (!log) {
            TAKT_TRY(log, AuditLog::open(place.audit));
        }
        place.guard->set_log(log);
    }
    has_rules_ = count > 0;
    if (has_rules_) tell(options_.access.empty() ? count : rules.size());
    return {};
}

void PlaceAccess::tell(std::size_t rules) const {
    print_status(texts_("app.access.in_force", {{"count", std::to_string(rules)}}) + '\n');
}

void PlaceAccess::reload() {
    if (options_.access.empty()) return reload_project();
    const auto rules = load_access(texts_, options_.access);
    if (!rules) return print_error(texts_("app.access.kept", {{"file", options_.access}}));
    for (const auto& place : places_)
        if (place.guard) place.guard->set_rules(*rules);
    tell(rules->size());
}

void PlaceAccess::reload_project() {
    const auto loaded = load_project(options_.file);
    const auto server_of = [&](const Place& place) {
        return std::ranges::find(loaded.project.servers, place.line.name, &model::Server::name);
    };
    const bool whole = !loaded.has_errors() && std::ranges::all_of(places_, [&](const Place& place) {
        return !place.guard || server_of(place) != loaded.project.servers.end();
    });
    if (!whole) {
        print_status(findings_text(texts_, loaded));
        return print_error(texts_("app.access.kept", {{"file", options_.file}}));
    }
    std::size_t count = 0;
    for (const auto& place : places_) {
        if (!place.guard) continue;
        place.guard->set_rules(server_of(place)->access);
        count += server_of(place)->access.size();
    }
    tell(count);
}

void PlaceAccess::finish() {
    for (const auto& place : places_)
        if (place.guard) place.guard->set_log(nullptr);
    for (auto& [path, log] : logs_) {
        const std::uint64_t failures = log->finish();
        if (failures > 0)
            print_error(texts_("app.audit.failed", {{"file", path}, {"count", std::to_string(failures)}}));
    }
    logs_.clear();
}

}  // namespace takt::app
