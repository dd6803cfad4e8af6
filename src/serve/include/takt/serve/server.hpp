// Units with their banks, and the functions that reach them.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "takt/base/engine.hpp"
#include "takt/serve/answer.hpp"
#include "takt/serve/bank.hpp"
#include "takt/wire/function.hpp"

namespace takt::serve {

/// Existing items of one area that a request reads or writes.
struct Access {
    wire::Function function = wire::Function::read_holding_registers;
    wire::Area area = wire::Area::holding_register;
    std::uint16_t start = 0;
    std::uint16_t count = 0;
    bool write = false;
    /// Of a write, as on the wire: bits from the lowest of the first byte on, registers high byte first.
    /// Valid during the call.
    Bytes values;
};

/// Callbacks of a unit's owner. Called from inside Server::handle().
class UnitHooks {
public:
    /// Before items are read or written: may update them, or refuse the whole request with an exception.
    virtual std::optional<wire::ExceptionCode> before(const Context& context, const Access& access) = 0;

    /// After items were written; the banks hold the new values.
    virtual void written(const Context& context, const Access& access) = 0;

    /// After the unit handled a request, with its answer. The answer to a broadcast is never sent. Not called
    /// for a request that an extension did not admit.
    virtual void handled(const Context& /*context*/, const wire::RequestView& /*request*/,
                         const Answer& /*answer*/) {}

protected:
    ~UnitHooks() = default;
};

struct Unit;

/// Further functions of a unit, and observers of its requests. Optional, so that a small device does not pay
/// for them. This module has Diagnostics, Identification, Files and Fifos; an owner may add its own ones.
/// Called from inside Server::handle(); must not block.
class Extension {
public:
    /// Answers the functions of the extension.
    /// @param request  well formed or not
    /// @param answer   a response without a PDU, to be filled; or set to silence or pending. The answer to a
    ///                 broadcast is never sent
    /// @returns false: another function; `answer` is unchanged
    virtual bool handle(Unit& unit, const Context& context, const wire::RequestView& request,
                        Answer& answer) = 0;

    /// Called before a request to the unit is processed. @returns false: the request is ignored, without
    /// answer
    virtual bool admit(const Context& /*context*/, const wire::RequestView& /*request*/) { return true; }

    /// Called after a request was handled or not admitted, with its answer.
    virtual void done(const Context& /*context*/, const wire::RequestView& /*request*/,
                      const Answer& /*answer*/) {}

    virtual void on_line_event(LineEvent /*event*/) {}

protected:
    ~Extension() = default;
};

struct Unit {
    UnitId id{1};
    Banks banks;
    UnitHooks* hooks = nullptr;  ///< may be absent; outlives the unit
    std::span<Extension* const>
        extensions;  ///< asked in this order; they serve this unit only and outlive it
};

/// Answers functions 1-6, 15, 16, 22 and 23 from the banks of its units, further ones from their extensions.
/// Any other function is exception 1.
///
/// Order of the checks, as in the specification:
///   1. function (exception 1);
///   2. quantity, byte count and length (exception 3);
///   3. addresses, including read-only ones (exception 2);
///   4. limits of values (exception 3);
///   5. the hooks.
/// Function 23 writes, then reads; an invalid read range stops it before the write. A broadcast executes
/// functions 5, 6, 15, 16, 22 and those that extensions accept on every unit, and ignores the others.
///
/// Requests are views of the receive buffer, and answers are built in the transmit buffer.
///
/// Units 0 and 255 without a unit of that number mean the default unit (over TCP the server itself). Any
/// other unknown unit is answered with exception 0x0A. The engine of a serial line does not pass on requests
/// to units that serves() denies.
///
/// Never allocates. The caller owns the units and may change them between calls. One owner, one thread.
class Server final : public Responder {
public:
    /// @param default_unit  the unit for 0 and 255; nothing: the first unit
    explicit Server(std::span<Unit> units, std::optional<UnitId> default_unit = {});

    [[nodiscard]] bool serves(UnitId unit) const override;
    [[nodiscard]] Answer handle(const Context& context, const wire::RequestView& request) override;
    void on_line_event(LineEvent event) override;

    /// The same into the caller's buffer, for targets with little stack.
    /// @param answer  overwritten
    void handle(const Context& context, const wire::RequestView& request, Answer& answer);

    /// The unit that answers requests to `unit`, including the default unit for 0 and 255; nullptr: none.
    [[nodiscard]] Unit* addressed(UnitId unit) const;

private:
    [[nodiscard]] Unit* find(UnitId unit) const;

    std::span<Unit> units_;
    std::optional<UnitId> default_unit_;
};

/// The answer of one unit to one request, without the choice of the unit. For a broadcast:
/// the answer that would not be sent.
[[nodiscard]] Answer respond(Unit& unit, const Context& context, const wire::RequestView& request);
void respond(Unit& unit, const Context& context, const wire::RequestView& request, Answer& answer);

}  // namespace takt::serve
