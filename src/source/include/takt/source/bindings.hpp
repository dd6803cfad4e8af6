// The variables of a server that are bound to sources, and the way of values that clients write to them.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "takt/model/project.hpp"
#include "takt/serve/server.hpp"
#include "takt/source/feed.hpp"
#include "takt/value/codec.hpp"
#include "takt/value/command.hpp"
#include "takt/value/store.hpp"

namespace takt::source {

/// The project whose variables and locals are served. The loop's thread only.
class ProjectValues {
public:
    virtual ~ProjectValues() = default;
    [[nodiscard]] virtual const value::Store& store() const = 0;

    /// Sets a local. @returns what poll::Master::set() returns
    [[nodiscard]] virtual Result<bool> set(value::SlotId local, const value::Value& value) = 0;

    /// Commands the write of a polled variable.
    /// @param done  called once, later, never from inside
    /// @returns what poll::Master::write() returns; then `done` is not called
    [[nodiscard]] virtual Result<bool> write(value::SlotId variable, const value::Value& value,
                                             std::function<void(const value::CommandOutcome&)> done) = 0;
};

/// What a write that was passed on comes to; nothing: it was done.
using Refusal = std::optional<wire::ExceptionCode>;
using Passed = std::function<void(const Refusal&)>;

/// Passes a value on to where a binding says.
/// @param passed  called once, at once or later
using PassOn = std::function<void(const model::Sink& sink, const value::Value& value, Passed passed)>;

/// Puts off the answer to the request at hand. Called inside UnitHooks::written(), once for each value that
/// is passed on before the answer may be given.
/// @returns the function to be called, once, when the value was passed on or refused
using PutOffAnswer = std::function<Passed()>;

/// The bound variables of one unit.
///
/// Before items are read they are brought up to date, all of a request at one moment. What is older than
/// allowed or was never there is exception 0x0B, and a value that does not fit the registers exception 4.
/// A write to a variable that only has a source is exception 2; one to a part of a variable needs the rest
/// of it to be known. A value that was passed on with success is shown until its source has a newer one.
class BoundUnit final : public serve::UnitHooks {
public:
    /// @param unit   the unit as it is served, for its banks; outlives it, as `settings` does
    /// @param pass, put_off  outlive it
    BoundUnit(const model::ServerUnit& settings, serve::Unit& unit, const PassOn& pass,
              const PutOffAnswer& put_off);
    ~BoundUnit();
    BoundUnit(const BoundUnit&) = delete;
    BoundUnit& operator=(const BoundUnit&) = delete;

    /// What feeds the binding; until then its reads are exception 0x0B.
    void connect(const model::Binding& binding, std::unique_ptr<Feed> feed);

    std::optional<wire::ExceptionCode> before(const serve::Context& context,
                                              const serve::Access& access) override;
    void written(const serve::Context& context, const serve::Access& access) override;

private:
    struct Bound {
        const model::Variable* variable = nullptr;
        const model::Binding* binding = nullptr;
        std::unique_ptr<Feed> feed;
        std::uint16_t start = 0;  // of the items as they are stored
        std::uint16_t count = 1;
        value::Layout layout;
        bool is_bit = false;  // it is an item of a bit area with bits of its own
        value::Value held;    // was written: shown as long as the source was asked before
        std::optional<Instant> held_at;
    };
    struct Items {
        wire::Area area = wire::Area::holding_register;
        std::uint32_t first = 0;
        std::uint32_t last = 0;
        bool whole = true;  // registers are touched wholly
    };

    void add(const model::Binding& binding, const model::Variable& variable);
    [[nodiscard]] Items stored(const serve::Access& access) const;
    template <class Each>
    Refusal each_touched(const Items& items, const Each& each);
    Refusal refresh(Bound& bound, Instant t);
    Refusal show(Bound& bound, const value::Value& value);
    [[nodiscard]] value::Value shown(const Bound& bound) const;
    void pass(Bound& bound, const value::Value& value);

    serve::Unit& unit_;
    const PassOn& pass_;
    const PutOffAnswer& put_off_;
    std::array<std::vector<Bound>, 4> bound_;  // by area, by start
    std::array<std::uint16_t, 4> longest_{};
    std::shared_ptr<BoundUnit*> alive_;  // what comes later finds out whether it still is there
};

/// The bindings of all units of a server. The answer to a write is put off until its values are passed on.
class Bindings {
public:
    /// @param settings  outlive it, as the units do
    /// @param units     in the order of the settings
    Bindings(std::span<const model::ServerUnit> settings, std::span<serve::Unit> units, PutOffAnswer put_off);
    ~Bindings();
    Bindings(const Bindings&) = delete;
    Bindings& operator=(const Bindings&) = delete;

    /// Until then reads of bound variables are exception 0x0B.
    /// @returns what Feeds::feed() returns
    [[nodiscard]] Result<void> connect(Feeds& feeds, ProjectValues& project);

    /// Nothing is bound any more: reads are exception 0x0B again.
    void disconnect();

    /// By the unit's index.
    [[nodiscard]] serve::UnitHooks& hooks(std::size_t unit) { return *units_[unit]; }

private:
    void pass_on(const model::Sink& sink, const value::Value& value, const Passed& passed);
    void pass_to_variable(const std::string& name, const value::Value& value, const Passed& passed);
    void pass_to_local(const std::string& name, const value::Value& value, const Passed& passed);
    void pass_to_command(const model::Command& command, const value::Value& value, const Passed& passed);

    std::span<const model::ServerUnit> settings_;
    PutOffAnswer put_off_;
    PassOn pass_;
    std::vector<std::unique_ptr<BoundUnit>> units_;
    Feeds* feeds_ = nullptr;
    ProjectValues* project_ = nullptr;
};

}  // namespace takt::source
