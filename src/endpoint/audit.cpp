// Each request has at most one record of its outcome, written by one of these callbacks:
// - refused by a rule: on_request();
// - write to items of an own unit: UnitAudit::written(), with old and new values. on_request() or on_answer()
//   adds a record if it is refused afterwards;
// - other write to an own unit: on_request(), or on_answer() or on_forget() while its answer is pending;
// - relayed write: on_relayed() or on_relay_forgotten(), or on_request() if the gateway rejects it;
// - read that new rules refuse while it waits: on_refused_waiting().
// A broadcast to own units and to a line has the records of both.
#include "takt/endpoint/audit.hpp"

#include <algorithm>
#include <utility>

#include "takt/line/loop.hpp"

namespace takt::endpoint {
namespace {

using Decision = serve::AccessControl::Decision;
using Outcome = AuditRecord::Outcome;

constexpr bool is_exception(Bytes pdu) {
    return pdu.size() > 1 && wire::is_exception(pdu[0]);
}

std::string_view reason(Decision decision) {
    switch (decision) {
        case Decision::denied: return "rule";
        case Decision::read_only: return "read_only";
        case Decision::too_fast: return "rate";
        case Decision::allowed: break;
    }
    return "exception";
}

AuditRecord record_of(const serve::Context& context) {
    AuditRecord record;
    record.time = line::wall_clock(context.time);
    record.peer.assign(context.peer);
    record.role.assign(context.role);
    record.unit = context.unit.value;
    record.broadcast = context.broadcast;
    return record;
}

AuditRecord record_of(const serve::Context& context, const wire::RequestView& request) {
    AuditRecord record = record_of(context);
    record.function = static_cast<std::uint8_t>(request.function());
    record.request.assign(request.pdu());
    for (const auto& [area, write, start, count] : request.accesses())
        if (!record.items || write) record.items = AuditRecord::Items{area, start, count};
    return record;
}

AuditRecord record_of(const AuditedRequest& request) {
    AuditRecord record = record_of(request.context, request.request);
    if (const auto& target = request.path.target) {
        record.broadcast = record.broadcast || target->broadcast;
        record.relayed_to = target->unit.value;
    }
    return record;
}

void set_own_unit(AuditRecord& record, UnitId unit) {
    if (unit.value != record.unit) record.own_unit = unit.value;
}

bool is_refusal(const serve::Answer& answer) {
    return answer.kind == serve::Answer::Kind::response && is_exception(answer.pdu.span());
}

void mark_refused(AuditRecord& record, Decision decision, Bytes answer) {
    record.event = AuditRecord::Event::refused;
    record.why = reason(decision);
    if (is_exception(answer)) record.exception = answer[1];
}

// Exceptions 5 (acknowledge) and 11 (the target of a further gateway does not respond) leave open whether the
// write was executed.
bool leaves_open(Bytes exception) {
    const wire::ExceptionCode code{exception[1]};
    return code == wire::ExceptionCode::acknowledge ||
           code == wire::ExceptionCode::gateway_target_failed_to_respond;
}

Outcome outcome_of(const serve::Gateway::Reply& reply, bool broadcast) {
    switch (reply.fate) {
        case serve::Fate::unknown: return Outcome::unknown;
        case serve::Fate::not_sent: return Outcome::not_sent;
        case serve::Fate::answered: break;
    }
    if (!is_exception(reply.pdu.span())) return broadcast ? Outcome::sent : Outcome::done;
    return leaves_open(reply.pdu.span()) ? Outcome::unknown : Outcome::refused;
}

}  // namespace

std::optional<wire::ExceptionCode> Audit::UnitAudit::before(const serve::Context&,
                                                            const serve::Access& access) {
    if (!audit_.sink_ || !access.write) return std::nullopt;
    old_.clear();
    const serve::Banks& banks = unit_.banks;
    for (unsigned i = 0; i < access.count; ++i) {
        const auto address = static_cast<std::uint16_t>(access.start + i);
        if (wire::is_bit_area(access.area)) {
            if (i % 8 == 0) old_.push_back(0);
            if (banks.bit(access.area, address))
                old_[i / 8] = static_cast<std::uint8_t>(old_[i / 8] | 1U << (i % 8));
        } else {
            const unsigned value = banks.registers(access.area).get(address);
            old_.push_back(static_cast<std::uint8_t>(value >> 8));
            old_.push_back(static_cast<std::uint8_t>(value));
        }
    }
    return std::nullopt;
}

void Audit::UnitAudit::written(const serve::Context& context, const serve::Access& access) {
    if (!audit_.sink_) return;
    AuditRecord record = record_of(context);
    set_own_unit(record, unit_.id);
    record.function = static_cast<std::uint8_t>(access.function);
    record.items = AuditRecord::Items{access.area, access.start, access.count};
    record.old_values = old_;
    record.new_values.assign(access.values);
    audit_.sink_->put(context.time, record);
}

serve::UnitHooks& Audit::watch(serve::Unit& unit) {
    return watched_.emplace_back(*this, unit);
}

void Audit::set_sink(std::shared_ptr<AuditSink> sink) {
    while (!unanswered_.empty()) on_forget(line::now(), unanswered_.begin()->first);
    while (!on_the_way_.empty())
        on_relay_forgotten(line::now(), on_the_way_.begin()->first, serve::Fate::unknown);
    sink_ = std::move(sink);
}

void Audit::on_request(const AuditedRequest& request, Decision decision, const serve::Answer& answer) {
    if (!sink_) return;
    if (decision != Decision::allowed) {
        AuditRecord record = record_of(request);
        mark_refused(record, decision, answer.pdu.span());
        return sink_->put(request.context.time, record);
    }
    if (request.request.effect() != wire::Effect::write) return;
    if (request.path.target) on_relay_request(request);
    if (!request.context.broadcast && !request.path.target) on_own_request(request, answer);
}

// The answers of the units to a broadcast are known here only.
void Audit::on_unit_answer(UnitId unit, const serve::Context& context, const wire::RequestView& request,
                           const serve::Answer& answer) {
    if (!sink_ || request.effect() != wire::Effect::write) return;
    if (!context.broadcast) {
        handled_by_ = unit;
        return;
    }
    if (!request.accesses().empty() && !is_refusal(answer)) return;  // recorded by written()
    AuditRecord record = record_of(context, request);
    set_own_unit(record, unit);
    if (is_refusal(answer)) mark_refused(record, Decision::allowed, answer.pdu.span());
    sink_->put(context.time, record);
}

void Audit::on_own_request(const AuditedRequest& request, const serve::Answer& answer) {
    using Kind = serve::Answer::Kind;
    const auto unit = std::exchange(handled_by_, std::nullopt);
    const bool refused = is_refusal(answer);
    const bool ignored = !unit && answer.kind == Kind::silence;
    const bool recorded = !request.request.accesses().empty();  // by the hooks of the unit
    if (ignored || (!refused && answer.kind != Kind::pending && recorded)) return;
    AuditRecord record = record_of(request);
    if (unit) set_own_unit(record, *unit);
    if (refused) mark_refused(record, Decision::allowed, answer.pdu.span());
    if (answer.kind == Kind::pending)
        unanswered_.insert_or_assign(answer.token, Unanswered{record, recorded});
    else
        sink_->put(request.context.time, record);
}

void Audit::on_relay_request(const AuditedRequest& request) {
    AuditRecord record = record_of(request);
    if (request.path.relayed) {
        on_the_way_.insert_or_assign(*request.path.relayed, record);
        return;
    }
    mark_refused(record, Decision::allowed, request.path.rejection->span());
    record.outcome = Outcome::not_sent;
    sink_->put(request.context.time, record);
}

void Audit::on_answer(Instant t, serve::Token token, Bytes pdu) {
    const auto found = unanswered_.extract(token);
    if (found.empty() || !sink_) return;
    auto& [record, recorded] = found.mapped();
    const bool refused = is_exception(pdu);
    if (refused) mark_refused(record, Decision::allowed, pdu);
    if (refused || !recorded) sink_->put(t, record);
}

void Audit::on_forget(Instant t, serve::Token token) {
    const auto found = unanswered_.extract(token);
    if (!found.empty() && sink_ && !found.mapped().recorded) sink_->put(t, found.mapped().record);
}

// A write has its record already, which on_relayed() ends.
void Audit::on_refused_waiting(const AuditedRequest& request, Decision decision) {
    if (!sink_ || request.request.effect() == wire::Effect::write) return;
    AuditRecord record = record_of(request);
    mark_refused(record, decision, serve::rejection(request.context, request.request, decision).pdu.span());
    sink_->put(request.context.time, record);
}

void Audit::on_relayed(Instant t, const serve::Gateway::Reply& reply, Decision decision) {
    const auto found = on_the_way_.extract(reply.token);
    if (found.empty() || !sink_) return;
    AuditRecord& record = found.mapped();
    record.outcome = outcome_of(reply, record.broadcast);
    if (record.outcome == Outcome::refused || record.outcome == Outcome::not_sent)
        mark_refused(record, decision, reply.pdu.span());
    sink_->put(t, record);
}

void Audit::on_relay_forgotten(Instant t, serve::Token token, serve::Fate fate) {
    const auto found = on_the_way_.extract(token);
    if (found.empty() || !sink_) return;
    AuditRecord& record = found.mapped();
    record.outcome = fate == serve::Fate::not_sent ? Outcome::not_sent : Outcome::unknown;
    if (record.outcome == Outcome::not_sent) {
        record.event = AuditRecord::Event::refused;
        record.why = "disconnected";
    }
    sink_->put(t, record);
}

}  // namespace takt::endpoint
