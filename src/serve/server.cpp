#include "takt/serve/server.hpp"

#include <algorithm>

#include "pdu_bytes.hpp"
#include "takt/base/assert.hpp"

namespace takt::serve {
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

Answer Server::handle(const Context& context, const wire::RequestView& request) {
    Answer answer;
    handle(context, request, answer);
    return answer;
}

void Server::handle(const Context& context, const wire::RequestView& request, Answer& answer) {
    TAKT_ASSERT(!request.empty());
    if (context.broadcast) {
        for (Unit& unit : units_) respond(unit, context, request, answer);
        answer.kind = Answer::Kind::silence;
    } else if (Unit* const unit = addressed(context.unit)) {
        respond(*unit, context, request, answer);
    } else {
        answer.kind = Answer::Kind::response;
        refuse(answer, request, wire::ExceptionCode::gateway_path_unavailable);
    }
}

void Server::on_line_event(LineEvent event) {
    for (Unit& unit : units_)
        for (Extension* extension : unit.extensions) extension->on_line_event(event);
}

}  // namespace takt::serve
