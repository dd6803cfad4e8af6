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

/// Items of one area that a request is about to touch, or has touched. They all exist.
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

/// The owner's eyes and hands on a unit. Called from inside Server::handle().
class UnitHooks {
public:
    /// Before items are read or written: may bring them up to date, may refuse with an exception (then
    /// nothing of the request is done).
    virtual std::optional<wire::ExceptionCode> before(const Context& context, const Access& access) = 0;

    /// After items were written; the banks hold the new values.
    virtual void written(const Context& context, const Access& access) = 0;

protected:
    ~UnitHooks() = default;
};

struct Unit;

/// Further functions of a unit, and who watches its requests: what a small device does without it does not
/// pay for. Those that come with this room: Diagnostics, Identification, Files, Fifos; an owner's own one
/// adds functions of its own. Called from inside Server::handle(); must not block.
class Extension {
public:
    /// Answers the functions it knows.
    /// @param request  1..253 bytes; nothing is assumed of them
    /// @param answer   a response without a PDU, to be filled; or made silence or pending. Of a broadcast
    ///                 nothing is ever sent
    /// @returns false: not one of its functions; `answer` is as it was
    virtual bool handle(Unit& unit, const Context& context, Bytes request, Answer& answer) = 0;

    /// Before any request to the unit is looked at. @returns false: nothing is done and nothing sent
    virtual bool admit(const Context& /*context*/, Bytes /*request*/) { return true; }

    /// After a request was handled, or not admitted: with what becomes of it.
    virtual void done(const Context& /*context*/, Bytes /*request*/, const Answer& /*answer*/) {}

    virtual void heard(LineEvent /*event*/) {}

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

/// Answers functions 1-6, 15, 16, 22 and 23 from the banks of its units, further ones from their extensions;
/// any other function is exception 1.
///
/// Checks come in the order of the specification: function, then quantity, byte count and length (exception
/// 3), then addresses (exception 2; also for read-only ones), then the limits of values (exception 3), then
/// the hooks. Function 23 writes, then reads; a bad read range stops it before the write. A broadcast runs
/// functions 5, 6, 15, 16 and 22 on every unit and those that extensions take for one, and ignores the
/// others.
///
/// Requests are read where they lie and answers made where they are sent from; nothing is decoded into a
/// structure in between.
///
/// A unit that is not there: units 0 and 255 mean the default unit (over TCP the server itself; a serial
/// line's engine does not ask for units that serves() denies), any other is answered with exception 0x0A.
///
/// Never allocates; the units are the caller's and may be changed by it between calls. One owner, one thread.
class Server final : public Responder {
public:
    /// @param default_unit  whom 0 and 255 address; nothing: the first unit
    explicit Server(std::span<Unit> units, std::optional<UnitId> default_unit = {});

    [[nodiscard]] bool serves(UnitId unit) const override;
    [[nodiscard]] Answer handle(const Context& context, Bytes pdu) override;
    void heard(LineEvent event) override;

    /// The same into the caller's room, for those with little of it.
    /// @param answer  whatever it was, it is the answer now
    void handle(const Context& context, Bytes pdu, Answer& answer);

    /// Who answers requests to `unit`, the default unit for 0 and 255; nullptr: nobody.
    [[nodiscard]] Unit* addressed(UnitId unit) const;

private:
    [[nodiscard]] Unit* find(UnitId unit) const;

    std::span<Unit> units_;
    std::optional<UnitId> default_unit_;
};

/// What one unit answers to one request, 1..253 bytes; the part of Server::handle() without the choice of the
/// unit. Of a broadcast: what it would answer.
[[nodiscard]] Answer respond(Unit& unit, const Context& context, Bytes pdu);
void respond(Unit& unit, const Context& context, Bytes pdu, Answer& answer);

}  // namespace takt::serve
