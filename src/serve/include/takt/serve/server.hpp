// Units with their banks, and the functions that reach them.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

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

struct Unit {
    UnitId id{1};
    Banks banks;
    UnitHooks* hooks = nullptr;  ///< may be absent; outlives the unit
};

/// Answers functions 1-6, 15, 16, 22 and 23 from the banks of its units; any other function is exception 1.
///
/// Checks come in the order of the specification: function, then quantity, byte count and length (exception
/// 3), then addresses (exception 2; also for read-only ones), then the hooks. Function 23 writes, then reads;
/// a bad read range stops it before the write. A broadcast runs functions 5, 6, 15, 16 and 22 on every unit
/// and ignores the others.
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

    /// Who answers requests to `unit`, the default unit for 0 and 255; nullptr: nobody.
    [[nodiscard]] Unit* addressed(UnitId unit) const;

private:
    [[nodiscard]] Unit* find(UnitId unit) const;

    std::span<Unit> units_;
    std::optional<UnitId> default_unit_;
};

/// What one unit answers to one request; the part of Server::handle() without the choice of the unit.
[[nodiscard]] wire::Pdu respond(Unit& unit, const Context& context, Bytes pdu);

}  // namespace takt::serve
