#include "takt/endpoint/audit.hpp"

#include <algorithm>
#include <utility>

#include "takt/line/loop.hpp"

namespace takt::endpoint {
namespace {

using Decision = serve::AccessControl::Decision;

constexpr bool is_exception(Bytes pdu) {
    return pdu.size() > 1 && (pdu[0] & 0x80) != 0;
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
    record.unit = context.unit.value;
    record.broadcast = context.broadcast;
    return record;
}

AuditRecord record_of(const serve::Context& context, Bytes request, const serve::RequestScope& scope) {
    AuditRecord record = record_of(context);
    record.function = scope.function;
    record.request.assign(request);
    for (std::size_t i = 0; i < scope.touches; ++i) {
        const auto& [area, first, last, write] = scope.touched[i];
        if (!record.items || write)
            record.items = AuditRecord::Items{area, first, static_cast<std::uint16_t>(last - first + 1)};
    }
    return record;
}

void mark_refused(AuditRecord& record, Decision decision, Bytes answer) {
    record.event = AuditRecord::Event::refused;
    record.why = reason(decision);
    if (is_exception(answer)) record.exception = answer[1];
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
    record.unit = unit_.id.value;
    record.function = static_cast<std::uint8_t>(access.function);
    record.items = AuditRecord::Items{access.area, access.start, access.count};
    record.old_values = old_;
    record.new_values.assign(access.values);
    audit_.sink_->put(context.time, record);
}

serve::UnitHooks& Audit::watch(serve::Unit& unit) {
    is_watched_.set(unit.id.value);
    return watched_.emplace_back(*this, unit);
}

void Audit::set_sink(std::shared_ptr<AuditSink> sink) {
    while (!unanswered_.empty()) on_forget(line::now(), unanswered_.begin()->first);
    sink_ = std::move(sink);
}

// Units 0 and 255, and a broadcast, mean own units; only a relayed unit has no hooks.
bool Audit::is_recorded_by_unit(UnitId unit) const {
    return is_watched_.test(unit.value) || std::ranges::find(units_, unit) == units_.end();
}

void Audit::on_request(const serve::Context& context, Bytes request, const serve::RequestScope& scope,
                       Decision decision, const serve::Answer& answer) {
    if (!sink_) return;
    const bool exception = answer.kind == serve::Answer::Kind::response && is_exception(answer.pdu.span());
    const bool pending = answer.kind == serve::Answer::Kind::pending && scope.writes;
    const bool refused = decision != Decision::allowed || (exception && scope.writes);
    const bool recorded = scope.touches > 0 && is_recorded_by_unit(context.unit);
    if (!refused && !pending && (!scope.writes || recorded)) return;
    AuditRecord record = record_of(context, request, scope);
    if (refused) mark_refused(record, decision, answer.pdu.span());
    if (pending)
        unanswered_.insert_or_assign(answer.token, Unanswered{std::move(record), recorded});
    else
        sink_->put(context.time, record);
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

}  // namespace takt::endpoint
