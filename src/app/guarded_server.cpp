#include "guarded_server.hpp"

#include <algorithm>
#include <utility>

#include "takt/app/console.hpp"
#include "takt/app/project.hpp"
#include "takt/file/load.hpp"
#include "takt/line/loop.hpp"

namespace takt::app {
namespace {

using Decision = serve::AccessControl::Decision;

serve::AccessRule::Verdict verdict_of(model::AccessVerdict verdict) {
    switch (verdict) {
        case model::AccessVerdict::allow: return serve::AccessRule::Verdict::allow;
        case model::AccessVerdict::read_only: return serve::AccessRule::Verdict::read_only;
        case model::AccessVerdict::deny: break;
    }
    return serve::AccessRule::Verdict::deny;
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

}  // namespace

AuditedUnit::AuditedUnit(serve::Unit& unit) : unit_(unit), next_(std::exchange(unit.hooks, this)) {}

std::optional<wire::ExceptionCode> AuditedUnit::before(const serve::Context& context,
                                                       const serve::Access& access) {
    if (next_)
        if (const auto refusal = next_->before(context, access)) return refusal;
    if (!log_ || !access.write) return std::nullopt;
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

void AuditedUnit::written(const serve::Context& context, const serve::Access& access) {
    if (next_) next_->written(context, access);
    if (!log_) return;
    AuditRecord record = record_of(context);
    record.unit = unit_.id.value;
    record.function = static_cast<std::uint8_t>(access.function);
    record.items = AuditRecord::Items{access.area, access.start, access.count};
    record.old_values = old_;
    record.new_values.assign(access.values);
    log_->put(context.time, record);
}

GuardedServer::GuardedServer(std::shared_ptr<serve::Responder> responder, std::vector<UnitId> units)
    : responder_(std::move(responder)),
      units_(std::move(units)),
      guard_(*responder_, control_, units_, this) {}

void GuardedServer::set_rules(const std::vector<model::AccessRule>& rules) {
    control_.set_rules({});
    storage_.clear();
    rules_.clear();
    for (const auto& rule : rules) {
        Storage& storage = storage_.emplace_back();
        for (const auto [first, last] : rule.units)
            storage.units.push_back({static_cast<std::uint8_t>(first), static_cast<std::uint8_t>(last)});
        for (const auto [first, last] : rule.items) storage.items.push_back({first, last});
        storage.networks = rule.networks;
    }
    for (std::size_t i = 0; i < rules.size(); ++i) {
        const model::AccessRule& rule = rules[i];
        serve::AccessRule own;
        own.networks = storage_[i].networks;
        own.serial = rule.serial;
        own.every_peer = rule.every_peer;
        own.units = storage_[i].units;
        if (!rule.every_function) own.functions = {};
        for (const std::uint8_t code : rule.functions) own.functions.add(code);
        own.area = rule.area;
        own.items = storage_[i].items;
        own.verdict = verdict_of(rule.verdict);
        if (rule.rate) own.rate = serve::RateLimit{rule.rate->per_second, rule.rate->burst};
        rules_.push_back(own);
    }
    control_.set_rules(rules_);
}

void GuardedServer::set_log(std::shared_ptr<AuditLog> log) {
    while (!unanswered_.empty()) tell_unanswered(unanswered_.begin()->first);
    log_ = std::move(log);
    for (const auto& unit : audited_) unit->set_log(log_.get());
}

void GuardedServer::watch(serve::Unit& unit) {
    audited_.push_back(std::make_unique<AuditedUnit>(unit));
    watched_.set(unit.id.value);
}

/// Of units that are not its own (requests to them are passed on) nobody else tells.
bool GuardedServer::is_told_by_unit(const serve::Context& context) const {
    return watched_.test(context.unit.value) || std::ranges::find(units_, context.unit) == units_.end();
}

// What was written to items its unit has told already; what is not answered yet may still be refused.
void GuardedServer::asked(const serve::Context& context, Bytes request, const serve::RequestScope& scope,
                          Decision decision, const serve::Answer& answer) {
    if (!log_) return;
    const bool exception = answer.kind == serve::Answer::Kind::response && (answer.pdu[0] & 0x80) != 0;
    const bool pending = answer.kind == serve::Answer::Kind::pending && scope.writes;
    const bool refused = decision != Decision::allowed || (exception && scope.writes);
    const bool told = scope.touches > 0 && is_told_by_unit(context);
    if (!refused && !pending && (!scope.writes || told)) return;
    AuditRecord record = record_of(context);
    record.event = refused ? AuditRecord::Event::refused : AuditRecord::Event::write;
    record.function = scope.function;
    record.request.assign(request);
    for (std::size_t i = 0; i < scope.touches; ++i) {
        const auto& [area, first, last, write] = scope.touched[i];
        if (!record.items || write)
            record.items = AuditRecord::Items{area, first, static_cast<std::uint16_t>(last - first + 1)};
    }
    if (refused) record.why = reason(decision);
    if (exception) record.exception = answer.pdu[1];
    if (pending && unanswered_.size() < kUnanswered)
        unanswered_.insert_or_assign(answer.token, Unanswered{record, told});
    else if (refused || !told)
        log_->put(context.time, record);
}

void GuardedServer::answered(serve::Token token, Bytes pdu) {
    const auto found = unanswered_.extract(token);
    if (found.empty() || !log_) return;
    auto& [record, told] = found.mapped();
    const bool exception = pdu.size() > 1 && (pdu[0] & 0x80) != 0;
    if (exception) {
        record.event = AuditRecord::Event::refused;
        record.why = reason(Decision::allowed);
        record.exception = pdu[1];
    }
    if (exception || !told) log_->put(line::now(), record);
}

void GuardedServer::forget(serve::Token token) {
    tell_unanswered(token);
    guard_.forget(token);
}

/// It may have been done.
void GuardedServer::tell_unanswered(serve::Token token) {
    const auto found = unanswered_.extract(token);
    if (!found.empty() && log_ && !found.mapped().told) log_->put(line::now(), found.mapped().record);
}

std::optional<std::vector<model::AccessRule>> load_access(const Texts& texts, const std::string& path) {
    auto read = file::load_project(path);
    LoadedProject told;
    told.readable = read.readable;
    told.files = read.document.files;
    told.findings = std::move(read.findings);
    std::vector<model::AccessRule> rules;
    if (read.readable) {
        auto checked = model::interpret_access(read.document);
        rules = std::move(checked.rules);
        std::ranges::move(checked.findings, std::back_inserter(told.findings));
    }
    print_status(findings_text(texts, told));
    if (told.has_errors()) return std::nullopt;
    return rules;
}

}  // namespace takt::app
