#include "takt/serve/server.hpp"

#include <algorithm>

#include "takt/base/assert.hpp"

namespace takt::serve {
namespace {

bool is_broadcast_write(std::uint8_t function) {
    switch (static_cast<wire::Function>(function)) {
        case wire::Function::write_single_coil:
        case wire::Function::write_single_register:
        case wire::Function::write_multiple_coils:
        case wire::Function::write_multiple_registers:
        case wire::Function::mask_write_register: return true;
        default: return false;
    }
}

}  // namespace

Server::Server(std::span<Unit> units, std::optional<UnitId> default_unit)
    : units_(units), default_unit_(default_unit) {}

Unit* Server::find(UnitId unit) const {
    const auto found = std::ranges::find(units_, unit, &Unit::id);
    return found == units_.end() ? nullptr : &*found;
}

Unit* Server::addressed(UnitId unit) const {
    if (Unit* exact = find(unit)) return exact;
    if (unit.value != 0 && unit.value != 255) return nullptr;
    if (default_unit_) return find(*default_unit_);
    return units_.empty() ? nullptr : &units_.front();
}

bool Server::serves(UnitId unit) const {
    return find(unit) != nullptr;
}

Answer Server::handle(const Context& context, Bytes pdu) {
    TAKT_ASSERT(!pdu.empty());
    if (context.broadcast) {
        if (is_broadcast_write(pdu[0]))
            for (Unit& unit : units_) (void)respond(unit, context, pdu);
        return {};
    }
    Unit* unit = addressed(context.unit);
    if (!unit) return Answer::response(exception_to(pdu[0], wire::ExceptionCode::gateway_path_unavailable));
    return Answer::response(respond(*unit, context, pdu));
}

}  // namespace takt::serve
