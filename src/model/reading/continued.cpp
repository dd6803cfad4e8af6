// Things are compared as values: each is copied without its locations, and indices of the older project are
// replaced by those of the newer one.
#include "takt/model/continued.hpp"

#include <algorithm>

namespace takt::model {
namespace {

Instrument without_locations(Instrument instrument) {
    instrument.location = {};
    for (auto& exchange : instrument.exchanges) exchange.location = {};
    for (auto& command : instrument.start) command.location = {};
    for (auto& command : instrument.commands) {
        command.location = {};
        if (command.read_back) command.read_back->location = {};
    }
    return instrument;
}

void remove_locations(ServerUnit& unit) {
    unit.location = {};
    for (auto& overlay : unit.overlays)
        if (overlay) overlay->location = {};
    for (auto& limits : unit.limits) limits.location = {};
    for (auto& variable : unit.variables) variable.location = {};
    for (auto& binding : unit.bindings) binding.location = {};
}

/// The properties of a server that are compared.
Server comparable(Server server) {
    server.location = {};
    server.access.clear();
    for (auto& unit : server.units) remove_locations(unit);
    for (auto& relay : server.relays) relay.location = {};
    return server;
}

/// The index in the newer project of what was `before` in the older one.
std::optional<std::size_t> now_at(const Continued& continued, std::size_t before) {
    const auto found = std::ranges::find(continued, std::optional(before));
    return found == continued.end() ? std::nullopt : std::optional<std::size_t>(found - continued.begin());
}

/// Replaces an index of the older project. @returns false: there is none in the newer one
bool renumber(std::size_t& index, const Continued& continued) {
    const auto now = now_at(continued, index);
    if (now) index = *now;
    return now.has_value();
}

/// @returns nothing where it refers to something that does not continue
std::optional<Server> in_terms_of_the_newer(Server server, const Continued& lines,
                                            const Continued& instruments) {
    for (auto& relay : server.relays)
        if (!renumber(relay.line, lines)) return std::nullopt;
    for (auto& unit : server.units)
        for (auto& binding : unit.bindings) {
            auto* const measured = binding.source ? std::get_if<InstrumentSource>(&*binding.source) : nullptr;
            if (measured && !renumber(measured->instrument, instruments)) return std::nullopt;
            auto* const commanded = binding.sink ? std::get_if<InstrumentSink>(&*binding.sink) : nullptr;
            if (commanded && !renumber(commanded->instrument, instruments)) return std::nullopt;
        }
    return server;
}

}  // namespace

Continued continued_instruments(const Project& before, const Project& now) {
    Continued continued;
    for (const auto& instrument : now.instruments) {
        const auto found = std::ranges::find(before.instruments, instrument.name, &Instrument::name);
        const bool same =
            found != before.instruments.end() && without_locations(*found) == without_locations(instrument);
        continued.push_back(same ? std::optional<std::size_t>(found - before.instruments.begin())
                                 : std::nullopt);
    }
    return continued;
}

Continued continued_gateways(const Project& before, const Project& now) {
    Continued continued;
    for (const auto& line : now.lines) {
        const auto found = std::ranges::find(before.lines, line.name, &Line::name);
        const bool same = found != before.lines.end() && found->framing == line.framing;
        continued.push_back(same ? std::optional<std::size_t>(found - before.lines.begin()) : std::nullopt);
    }
    return continued;
}

Continued continued_servers(const Project& before, const Project& now) {
    const auto lines = continued_gateways(before, now);
    const auto instruments = continued_instruments(before, now);
    Continued continued;
    for (const auto& server : now.servers) {
        const auto found = std::ranges::find(before.servers, server.name, &Server::name);
        const auto old = found == before.servers.end()
                             ? std::nullopt
                             : in_terms_of_the_newer(comparable(*found), lines, instruments);
        const bool same = old && *old == comparable(server);
        continued.push_back(same ? std::optional<std::size_t>(found - before.servers.begin()) : std::nullopt);
    }
    return continued;
}

}  // namespace takt::model
