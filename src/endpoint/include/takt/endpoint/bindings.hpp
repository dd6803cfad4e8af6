// The variables of a server that are bound to sources. Writes to them are passed on.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "takt/endpoint/feed.hpp"
#include "takt/model/project.hpp"
#include "takt/serve/server.hpp"
#include "takt/value/codec.hpp"
#include "takt/value/command.hpp"
#include "takt/value/store.hpp"

namespace takt::endpoint {

/// The project whose variables and locals are served. The loop's thread only.
class ProjectValues {
public:
    virtual ~ProjectValues() = default;
    [[nodiscard]] virtual const value::Store& store() const = 0;

    /// Sets a local. @returns what poll::Master::set() returns
    [[nodiscard]] virtual Result<bool> set(value::SlotId local, const value::Value& value) = 0;

    /// Commands the write of a polled variable.
    /// @param done  called once, later, never from inside write()
    /// @returns what poll::Master::write() returns; then `done` is not called
    [[nodiscard]] virtual Result<bool> write(value::SlotId variable, const value::Value& value,
                                             std::function<void(const value::CommandOutcome&)> done) = 0;
};

/// The result of a write that was passed on: an exception, or nothing for success.
using Refusal = std::optional<wire::ExceptionCode>;
using Passed = std::function<void(const Refusal&)>;

/// The sink of a binding in the connected project.
struct Destination {
    const model::Sink& sink;
    std::optional<value::SlotId> slot;  ///< of a variable or local; nothing: the project does not have it
};

/// Passes a value on to the sink of a binding.
/// @param passed  called once, inside the call or later
using PassOn = std::function<void(const Destination& to, const value::Value& value, Passed passed)>;

/// Whether the sink of a binding takes a value: else its exception. Nothing is passed on.
using CheckValue = std::function<Refusal(const Destination& to, const value::Value& value)>;

/// Defers the answer to the current request. Called inside UnitHooks::written(), once for each value that
/// must be passed on before the answer.
/// @returns the function to be called, once, when the value was passed on or refused
using PutOffAnswer = std::function<Passed()>;

/// The bound variables of one unit.
///
/// Reads: all items of a request are updated from their sources at one instant. A value that is older than
/// allowed or was never read is exception 0x0B; a value that does not fit its registers is exception 4.
/// Writes: a variable with a source but no sink is exception 2. Writing a part of a variable needs a known
/// value of the rest. If the sink of one value does not take it, no value of the request is passed on. A
/// value that was passed on successfully is shown until its source has a newer one.
class BoundUnit final : public serve::UnitHooks {
public:
    /// @param unit   the served unit with its banks; outlives this, as `settings` does
    /// @param check, pass, put_off  outlive it
    BoundUnit(const model::ServerUnit& settings, serve::Unit& unit, const CheckValue& check,
              const PassOn& pass, const PutOffAnswer& put_off);
    ~BoundUnit();
    BoundUnit(const BoundUnit&) = delete;
    BoundUnit& operator=(const BoundUnit&) = delete;

    /// Sets the feed of the binding. Without a feed its reads are exception 0x0B.
    void connect(const model::Binding& binding, std::unique_ptr<Feed> feed);

    /// Finds the variables and locals that are written to, in the slots of the connected project.
    void find_sinks(const value::Store& store);

    std::optional<wire::ExceptionCode> before(const serve::Context& context,
                                              const serve::Access& access) override;
    void written(const serve::Context& context, const serve::Access& access) override;

private:
    struct Bound {
        const model::Variable* variable = nullptr;
        const model::Binding* binding = nullptr;
        std::unique_ptr<Feed> feed;
        std::optional<value::SlotId> sink;  // Destination::slot
        std::uint16_t start = 0;            // first item in the storage
        std::uint16_t count = 1;
        value::Layout layout;
        bool is_bit = false;  // in a bit area without overlay
        value::Value held;    // written value, shown until the source has a newer one
        std::optional<Instant> held_at;
    };
    struct Items {
        wire::Area area = wire::Area::holding_register;
        std::uint32_t first = 0;
        std::uint32_t last = 0;
        bool whole = true;  // whole registers are accessed
    };

    void add(const model::Binding& binding, const model::Variable& variable);
    [[nodiscard]] Items stored(const serve::Access& access) const;
    template <class Each>
    Refusal each_touched(const Items& items, const Each& each);
    Refusal refresh(Bound& bound, Instant t);
    Refusal show(Bound& bound, const value::Value& value);
    [[nodiscard]] value::Value shown(const Bound& bound) const;
    void pass(Bound& bound, const value::Value& value, const Refusal& refused);

    serve::Unit& unit_;
    const CheckValue& check_;
    const PassOn& pass_;
    const PutOffAnswer& put_off_;
    std::array<std::vector<Bound>, 4> bound_;  // by area, by start
    std::array<std::uint16_t, 4> longest_{};
    std::shared_ptr<BoundUnit*> alive_;  // lets late callbacks detect that this object is gone
};

/// The bindings of all units of a server. The answer to a write is deferred until its values are passed on.
class Bindings {
public:
    /// @param settings  outlive it, as the units do
    /// @param units     in the order of the settings
    Bindings(std::span<const model::ServerUnit> settings, std::span<serve::Unit> units, PutOffAnswer put_off);
    ~Bindings();
    Bindings(const Bindings&) = delete;
    Bindings& operator=(const Bindings&) = delete;

    /// Connects the bindings. Before this call reads of bound variables are exception 0x0B.
    /// @returns what Feeds::feed() returns
    [[nodiscard]] Result<void> connect(Feeds& feeds, ProjectValues& project);

    /// Connects with another project of which the unchanged parts continue: variables and locals are those of
    /// that project; all other feeds go on, generators in their motion and files with what was read.
    /// @param feeds  those of connect()
    /// @returns what Feeds::feed() returns
    [[nodiscard]] Result<void> reconnect(Feeds& feeds, ProjectValues& project);

    /// Removes all feeds: reads are exception 0x0B again.
    void disconnect();

    /// The hooks of a unit, by its index.
    [[nodiscard]] serve::UnitHooks& hooks(std::size_t unit) { return *units_[unit]; }

private:
    template <class Condition>
    Result<void> connect_if(const Condition& condition, Feeds& feeds, ProjectValues& project);
    [[nodiscard]] Refusal check(const Destination& to, const value::Value& value) const;
    void pass_on(const Destination& to, const value::Value& value, const Passed& passed);
    void pass_to_variable(value::SlotId slot, const value::Value& value, const Passed& passed);
    void pass_to_local(value::SlotId slot, const value::Value& value, const Passed& passed);
    void pass_to_instrument(const model::InstrumentSink& sink, const value::Value& value,
                            const Passed& passed);
    void pass_to_command(const model::Command& command, const value::Value& value, const Passed& passed);

    std::span<const model::ServerUnit> settings_;
    PutOffAnswer put_off_;
    CheckValue check_;
    PassOn pass_;
    std::vector<std::unique_ptr<BoundUnit>> units_;
    Feeds* feeds_ = nullptr;
    ProjectValues* project_ = nullptr;
};

}  // namespace takt::endpoint
