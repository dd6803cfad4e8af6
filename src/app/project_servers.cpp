#include "project_servers.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>

#include "takt/app/console.hpp"
#include "takt/file/json.hpp"

namespace takt::app {
namespace {

using Named = std::pair<const char*, std::uint64_t>;

std::array<Named, 9> named(const relay::GatewayCounters& counters) {
    return {Named{"asked", counters.asked},    {"sent", counters.sent},
            {"shared", counters.shared},       {"cached", counters.from_cache},
            {"no_answer", counters.no_answer}, {"no_path", counters.no_path},
            {"busy", counters.busy},           {"refused", counters.refused},
            {"forgotten", counters.forgotten}};
}

}  // namespace

ProjectServers::ProjectServers(line::Loop& loop, const model::Project& project, const std::string& file,
                               Running& running, TrafficLog* log, const Texts& texts)
    : loop_(loop),
      project_(project),
      log_(log),
      texts_(texts),
      options_{.file = file},
      values_(running),
      sources_(project, values_),
      relaying_(loop, project, running),
      places_(server_places(project, options_,
                            [this](std::size_t i, Place& place) {
                                sources_.bind(i, place);
                                relay(i, place);
                            })),
      access_(texts_, places_, options_) {}

// The own units stay the first ones: 0 and 255 mean the first.
void ProjectServers::relay(std::size_t server, Place& place) {
    place.responder = relaying_.responder(server, std::move(place.responder), *place.answers);
    std::ranges::copy_if(relaying_.units(server), std::back_inserter(place.units), [&place](UnitId unit) {
        return std::ranges::find(place.units, unit) == place.units.end();
    });
}

Result<void> ProjectServers::open() {
    TAKT_CHECK(access_.begin({}));
    TAKT_CHECK(sources_.open(loop_));
    for (const Place& place : places_) TAKT_CHECK(open_retained(loop_, texts_, place));
    for (const Place& place : places_) {
        TAKT_TRY(auto serving, start_serving(loop_, place, log_));
        print_status(place_text(texts_, place, serving));
        serving_.push_back(std::move(serving));
    }
    return {};
}

void ProjectServers::finish() {
    summary_ = end_serving(places_, serving_);
    access_.finish();
}

std::string ProjectServers::summary_text() const {
    std::string text = report::served_text(texts_, summary_);
    for (std::size_t i = 0; i < project_.lines.size(); ++i) {
        const auto* const counted = relaying_.counters(i);
        if (!counted) continue;
        Texts::Arguments arguments{{"line", project_.lines[i].name}};
        for (const auto& [name, count] : named(*counted)) arguments.emplace_back(name, std::to_string(count));
        text += texts_("app.relayed", arguments) + '\n';
    }
    return text;
}

std::string ProjectServers::summary_json() const {
    std::string text = report::served_json(summary_, "served");
    for (std::size_t i = 0; i < project_.lines.size(); ++i) {
        const auto* const counted = relaying_.counters(i);
        if (!counted) continue;
        auto object = file::Json::object();
        object.set("event", "relayed");
        object.set("line", project_.lines[i].name);
        for (const auto& [name, count] : named(*counted)) object.set(name, count);
        text += object.dump() + '\n';
    }
    return text;
}

}  // namespace takt::app
