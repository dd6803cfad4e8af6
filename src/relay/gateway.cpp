#include "takt/relay/gateway.hpp"

#include <algorithm>

#include "requests.hpp"

namespace takt::relay {
namespace {

using wire::ExceptionCode;

bool same_client(const Requester& requester, std::uint32_t server, std::uint64_t client) {
    return requester.server == server && requester.client == client;
}

}  // namespace

Gateway::Gateway(const GatewayConfig& config) : config_(config), cache_(config.cached) {}

wire::Pdu Gateway::exception(std::uint8_t function, ExceptionCode code) {
    switch (code) {
        case ExceptionCode::server_device_busy: ++counters_.busy; break;
        case ExceptionCode::gateway_path_unavailable: ++counters_.no_path; break;
        case ExceptionCode::gateway_target_failed_to_respond: ++counters_.no_answer; break;
        default: ++counters_.refused; break;
    }
    return serve::exception_to(function, code);
}

std::optional<wire::Pdu> Gateway::ask(Instant t, const Requester& requester, const RequestPolicy& policy,
                                      UnitId unit, const wire::PreparedRequest& request) {
    ++counters_.asked;
    const auto before = std::ranges::count_if(waiting_, [&](const Entry& entry) {
        return same_client(entry.requester, requester.server, requester.client);
    });
    if (auto answer = answer_at_once(t, policy, unit, request, before == 0)) return answer;
    if (waiting_.size() >= config_.requests || static_cast<std::size_t>(before) >= config_.per_client)
        return exception(request.function(), ExceptionCode::server_device_busy);
    if (spare_.empty()) spare_.emplace_back();
    waiting_.splice(waiting_.end(), spare_, spare_.begin());
    Entry& entry = waiting_.back();
    entry = {.requester = requester,
             .policy = policy,
             .unit = unit,
             .request = request,
             .read = wire::only_reads(request.pdu())};
    entry.give_up = after(t, policy.max_wait);
    if (before == 0) accept(entry);
    return std::nullopt;
}

std::optional<wire::Pdu> Gateway::answer_at_once(Instant t, const RequestPolicy& policy, UnitId unit,
                                                 const wire::PreparedRequest& request, bool first) {
    if (const auto code = refusal(request, config_.broadcast && unit == kBroadcast))
        return exception(request.function(), *code);
    if (!up_) return exception(request.function(), ExceptionCode::gateway_path_unavailable);
    if (!first || !wire::only_reads(request.pdu()) || policy.cache <= Duration::zero()) return std::nullopt;
    const wire::Pdu* const kept = cache_.find(t, unit, request.pdu(), policy.cache);
    if (!kept) return std::nullopt;
    ++counters_.from_cache;
    return *kept;
}

void Gateway::accept(Entry& entry) {
    entry.order = ++last_order_;
    if (!entry.read) note_write(entry.unit);
    entry.epoch = epochs_[entry.unit.value];
}

void Gateway::note_write(UnitId unit) {
    if (config_.broadcast && unit == kBroadcast) {
        for (auto& epoch : epochs_) ++epoch;
        return cache_.clear();
    }
    ++epochs_[unit.value];
    cache_.drop(unit);
}

// The next of that client, now that it has none in the order.
void Gateway::promote(std::uint32_t server, std::uint64_t client) {
    const auto next = std::ranges::find_if(
        waiting_, [&](const Entry& entry) { return same_client(entry.requester, server, client); });
    if (next != waiting_.end() && next->order == 0) accept(*next);
}

void Gateway::forget(std::uint32_t server, serve::Token token) {
    const auto is_it = [&](const Entry& entry) {
        return entry.requester.server == server && entry.requester.token == token;
    };
    const auto found = std::ranges::find_if(waiting_, is_it);
    if (found == waiting_.end()) return;
    ++counters_.forgotten;
    const std::uint64_t client = found->requester.client;
    spare_.splice(spare_.end(), waiting_, found);
    promote(server, client);
}

void Gateway::on_link(bool up) {
    up_ = up;
    if (up) return;
    cache_.clear();
    for (auto entry = waiting_.begin(); entry != waiting_.end();)
        entry = concerns(*entry) ? std::next(entry) : refuse(entry, ExceptionCode::gateway_path_unavailable);
}

void Gateway::on_tick(Instant t) {
    for (auto entry = waiting_.begin(); entry != waiting_.end();) {
        const bool stays = t < entry->give_up || concerns(*entry);
        entry = stays ? std::next(entry) : refuse(entry, ExceptionCode::server_device_busy);
    }
}

Instant Gateway::next_wakeup() const {
    Instant wakeup = kNever;
    for (const Entry& entry : waiting_)
        if (!concerns(entry)) wakeup = std::min(wakeup, entry.give_up);
    return wakeup;
}

// None while one is under way, or none can be.
const Gateway::Entry* Gateway::first_in_order() const {
    if (flight_ || !up_) return nullptr;
    const Entry* first = nullptr;
    for (const Entry& entry : waiting_)
        if (entry.order > 0 && (!first || entry.order < first->order)) first = &entry;
    return first;
}

std::optional<bus::Transaction> Gateway::next(Instant t) {
    if (flight_ || !up_) return std::nullopt;
    on_tick(t);
    const Entry* const first = first_in_order();
    if (!first) return std::nullopt;
    flight_ = Flight{++last_id_, first->unit, first->request, first->read, first->order, first->epoch};
    ++counters_.sent;
    return bus::Transaction{.id = flight_->id,
                            .unit = first->unit,
                            .request = first->request,
                            .wait = first->policy.response_timeout,
                            .late_limit = std::nullopt};
}

// Whether the transaction under way answers it.
bool Gateway::concerns(const Entry& entry) const {
    if (!flight_ || entry.order == 0) return false;
    if (entry.order == flight_->order) return true;
    return flight_->read && entry.read && entry.unit == flight_->unit && entry.epoch == flight_->epoch &&
           entry.request == flight_->request;
}

void Gateway::on_outcome(const bus::Outcome& outcome) {
    if (!flight_ || outcome.id != flight_->id) return;
    switch (outcome.status) {
        case bus::Status::ok:
            cache(outcome);
            answer_all(outcome.response.empty() ? answer_to_broadcast(flight_->request.pdu()).span()
                                                : outcome.response.pdu());
            break;
        case bus::Status::exception: answer_all(outcome.response.pdu()); break;
        case bus::Status::timeout:
        case bus::Status::bad_checksum:
        case bus::Status::unexpected_reply:
            retry_or_give_up(ExceptionCode::gateway_target_failed_to_respond);
            break;
        case bus::Status::link_lost:
        case bus::Status::cancelled:
        case bus::Status::line_busy: {
            const auto code = outcome.sent ? ExceptionCode::gateway_target_failed_to_respond
                                           : ExceptionCode::gateway_path_unavailable;
            for (auto entry = waiting_.begin(); entry != waiting_.end();)
                entry = concerns(*entry) ? refuse(entry, code) : std::next(entry);
            break;
        }
    }
    flight_.reset();
}

void Gateway::cache(const bus::Outcome& outcome) {
    if (!flight_->read || epochs_[flight_->unit.value] != flight_->epoch) return;
    const bool wanted = std::ranges::any_of(waiting_, [this](const Entry& entry) {
        return concerns(entry) && entry.policy.cache > Duration::zero();
    });
    if (wanted) cache_.keep(outcome.sent_at, flight_->unit, flight_->request.pdu(), outcome.response.pdu());
}

// What is asked again goes to the end: others had their turn to wait.
void Gateway::retry_or_give_up(ExceptionCode code) {
    std::uint64_t again = 0;
    for (auto entry = waiting_.begin(); entry != waiting_.end();) {
        if (!concerns(*entry)) {
            ++entry;
        } else if (!entry->read || ++entry->failures >= entry->policy.attempts) {
            entry = refuse(entry, code);
        } else {
            ++again;
            ++entry;
        }
    }
    if (again == 0) return;
    for (Entry& entry : waiting_)
        if (concerns(entry)) entry.order = ++last_order_;
}

void Gateway::answer_all(Bytes pdu) {
    std::uint64_t answered = 0;
    for (auto entry = waiting_.begin(); entry != waiting_.end();) {
        if (!concerns(*entry)) {
            ++entry;
            continue;
        }
        entry = answer(entry, pdu);
        ++answered;
    }
    if (answered > 1) counters_.shared += answered - 1;
}

Gateway::Entries::iterator Gateway::answer(Entries::iterator entry, Bytes pdu) {
    const Requester requester = entry->requester;
    const bool in_order = entry->order > 0;
    entry->answer.assign(pdu);
    const auto following = std::next(entry);
    answered_.splice(answered_.end(), waiting_, entry);
    if (in_order) promote(requester.server, requester.client);
    return following;
}

Gateway::Entries::iterator Gateway::refuse(Entries::iterator entry, ExceptionCode code) {
    return answer(entry, exception(entry->request.function(), code).span());
}

std::optional<Gateway::Reply> Gateway::take_reply() {
    if (answered_.empty()) return std::nullopt;
    const Entry& entry = answered_.front();
    const Reply reply{entry.requester.server, entry.requester.token, entry.answer};
    spare_.splice(spare_.end(), answered_, answered_.begin());
    return reply;
}

}  // namespace takt::relay
