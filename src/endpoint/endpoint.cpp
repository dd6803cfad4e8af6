#include "takt/endpoint/endpoint.hpp"

#include <algorithm>
#include <deque>
#include <span>
#include <utility>

#include "hook_chain.hpp"
#include "listener.hpp"
#include "retained_unit.hpp"
#include "stored_units.hpp"
#include "takt/endpoint/gateway_set.hpp"
#include "takt/sim/devices.hpp"

namespace takt::endpoint {

/// Units that are asked without regard to what they are.
struct UnitsView {
    std::shared_ptr<serve::Responder> responder;
    std::span<serve::Unit> units;
    sim::Devices* devices = nullptr;  // the responder, where it is a line's devices
};

namespace {

template <class... Cases>
struct Overloaded : Cases... {
    using Cases::operator()...;
};

template <class Units>
UnitsView view_of(std::shared_ptr<Units> made) {
    const auto units = made->units();
    return {std::move(made), units};
}

UnitsView view_of_devices(const model::Line& line) {
    const auto devices = std::make_shared<sim::Devices>(line, sim::Devices::Options{.prompt = true});
    auto view = view_of(devices);
    view.devices = devices.get();
    return view;
}

UnitsView make_units(const EndpointSpec& spec) {
    return std::visit(Overloaded{[](const ServerUnits& server) {
                                     return view_of(std::make_shared<StoredUnits>(server.units, server.fill));
                                 },
                                 [](const LineDevices& devices) { return view_of_devices(devices.line); }},
                      spec.units);
}

/// The own units in their order, then the relayed ones that are not among them.
std::vector<UnitId> all_units(std::span<const serve::Unit> own, const std::vector<model::Relay>& relays) {
    std::vector<UnitId> units;
    for (const auto& unit : own) units.push_back(unit.id);
    const std::vector<UnitId> before = units;
    std::ranges::copy_if(relayed_units(relays), std::back_inserter(units),
                         [&](UnitId unit) { return std::ranges::find(before, unit) == before.end(); });
    return units;
}

}  // namespace

struct Endpoint::OwnUnits {
    explicit OwnUnits(const EndpointSpec& spec) : view(make_units(spec)), chains(view.units.size()) {}

    UnitsView view;
    std::deque<UnitHookChain> chains;  // by unit
};

Endpoint::Endpoint(std::uint32_t id, EndpointSpec spec, const Environment& environment)
    : id_(id), spec_(std::move(spec)), environment_(environment), own_(std::make_unique<OwnUnits>(spec_)) {
    const auto units = own_->view.units;
    handler_ = std::make_unique<RequestHandler>(units.empty() ? nullptr : own_->view.responder.get(),
                                                all_units(units, spec_.relays), environment_.faults,
                                                own_->view.devices ? spec_.name : std::string());
    handler_->set_access(spec_.access);
    add_hooks();
}

sim::Devices* Endpoint::devices() {
    return own_->view.devices;
}

Endpoint::~Endpoint() {
    disconnect();
}

// The order is that of UnitHookChain.
void Endpoint::add_hooks() {
    const auto units = own_->view.units;
    for (std::size_t i = 0; i < units.size(); ++i) {
        if (units[i].hooks) own_->chains[i].add(*units[i].hooks);
        units[i].hooks = &own_->chains[i];
    }
    const auto* const server = std::get_if<ServerUnits>(&spec_.units);
    const auto is_bound = [](const model::ServerUnit& unit) { return !unit.bindings.empty(); };
    if (server && std::ranges::any_of(server->units, is_bound)) {
        bindings_ = std::make_unique<endpoint::Bindings>(
            server->units, units, [this] { return handler_->pending().put_off_until_called(); });
        for (std::size_t i = 0; i < units.size(); ++i) own_->chains[i].add(bindings_->hooks(i));
    }
    for (const auto& retained : spec_.retained) {
        retained_.push_back(std::make_unique<RetainedUnit>(units[retained.unit], retained,
                                                           handler_->pending(), environment_.notify));
        own_->chains[retained.unit].add(*retained_.back());
    }
    for (std::size_t i = 0; i < units.size(); ++i) own_->chains[i].add(handler_->audit().watch(units[i]));
}

Result<void> Endpoint::connect(endpoint::Feeds& feeds, endpoint::ProjectValues& values) {
    if (bindings_) TAKT_CHECK(bindings_->connect(feeds, values));
    return {};
}

void Endpoint::disconnect() {
    if (bindings_) bindings_->disconnect();
}

void Endpoint::enter(const EndpointSpec& spec) {
    spec_.relays = spec.relays;
    spec_.access = spec.access;
    spec_.access_is_override = spec.access_is_override;
    handler_->set_access(spec_.access);
}

Result<void> Endpoint::reconnect(endpoint::Feeds& feeds, endpoint::ProjectValues& values) {
    if (bindings_) TAKT_CHECK(bindings_->reconnect(feeds, values));
    return {};
}

Result<void> Endpoint::open_retained() {
    for (const auto& unit : retained_)
        TAKT_CHECK(unit->open(
            [&loop = environment_.loop](std::function<void()> task) { loop.post(std::move(task)); }));
    return {};
}

Result<void> Endpoint::listen() {
    for (const auto& listener : spec_.listeners) {
        listeners_.push_back(
            std::make_unique<Listener>(listener, environment_, *handler_, handler_->pending()));
        if (auto opened = listeners_.back()->open(); !opened) {
            listeners_.pop_back();
            return opened;
        }
        environment_.notify({Notice::Severity::status,
                             "endpoint.serving",
                             {{"where", listeners_.back()->name()}, {"units", units_text(handler_->units())}},
                             {}});
    }
    return {};
}

void Endpoint::add_statistics(Statistics& statistics) const {
    for (const auto& listener : listeners_) statistics.listeners.push_back(listener->statistics());
    for (const auto& unit : retained_) statistics.retained.push_back(unit->statistics());
}

void Endpoint::refresh(std::span<ListenerStatistics>& listeners,
                       std::span<RetainedStatistics>& retained) const {
    for (std::size_t i = 0; i < listeners_.size(); ++i) listeners_[i]->refresh(listeners[i]);
    for (std::size_t i = 0; i < retained_.size(); ++i) retained_[i]->refresh(retained[i]);
    listeners = listeners.subspan(listeners_.size());
    retained = retained.subspan(retained_.size());
}

void Endpoint::finish_retained(Statistics& statistics) {
    for (const auto& unit : retained_) {
        unit->finish();
        statistics.retained.push_back(unit->statistics());
    }
}

void Endpoint::close(Statistics& statistics) {
    for (const auto& listener : listeners_) statistics.listeners.push_back(listener->close());
}

std::string units_text(std::vector<UnitId> units) {
    constexpr std::size_t kFew = 3;
    std::ranges::sort(units);
    std::string text;
    for (std::size_t i = 0; i < units.size();) {
        std::size_t run = 1;
        while (i + run < units.size() && units[i + run].value == units[i].value + run) ++run;
        if (run <= kFew) run = 1;
        text += (text.empty() ? "" : ", ") + std::to_string(units[i].value);
        if (run > 1) text += ".." + std::to_string(units[i + run - 1].value);
        i += run;
    }
    return text;
}

}  // namespace takt::endpoint
