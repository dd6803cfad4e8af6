// Fairness: a client has at most one request in the order of the line. Each further request of the client
// waits until that one is answered; promote() then appends it to the order. Among the requests in the order,
// start-time fair queueing over the peers decides: a request gets the turn after the last one of its peer, or
// the present turn if the peer has none, and the least turn goes first. A peer that was served in the present
// turn is remembered, so that it cannot take the turn twice.
//
// Consistency: each write to a unit increments the unit's epoch. A read shares a transaction or a cached
// answer only with reads of the same epoch, so no read returns a value from before an accepted write.
#include "takt/serve/gateway.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

#include "relay/requests.hpp"

namespace takt::serve {
namespace {

using wire::ExceptionCode;

constexpr std::uint16_t kFailures = 3;  // in a row, until a unit counts as not answering

/// The exceptions of another gateway whose device did not answer.
bool came_from_gateway(const bus::Outcome& outcome) {
    const ExceptionCode code{outcome.exception};
    return code == ExceptionCode::gateway_path_unavailable ||
           code == ExceptionCode::gateway_target_failed_to_respond;
}

bool held(UnitId unit, const wire::PreparedRequest& request, const Gateway::MayStart& may_start) {
    return may_start && !may_start(unit, bus::answer_shape(request.shape()));
}

bool same_client(const Requester& requester, std::uint32_t server, std::uint64_t client) {
    return requester.server == server && requester.client == client;
}

}  // namespace

Gateway::Gateway(const GatewayConfig& config) : config_(config), cache_(config.cached), health_(kFailures) {}

template <class Condition>
std::size_t Gateway::refuse_if(const Condition& condition, ExceptionCode code) {
    const std::size_t before = waiting_.size();
    for (auto entry = waiting_.begin(); entry != waiting_.end();)
        entry = condition(*entry) ? refuse(entry, code) : std::next(entry);
    return before - waiting_.size();
}

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
    if (backs_off(t, unit, requester.peer)) {
        ++counters_.not_asked;
        return exception(request.function(), ExceptionCode::gateway_target_failed_to_respond);
    }
    if (static_cast<std::size_t>(before) >= config_.per_client ||
        (waiting_.size() >= config_.requests && !make_room(requester.peer)))
        return exception(request.function(), ExceptionCode::server_device_busy);
    if (spare_.empty()) spare_.emplace_back();
    waiting_.splice(waiting_.end(), spare_, spare_.begin());
    Entry& entry = waiting_.back();
    entry = {.requester = requester,
             .policy = policy,
             .unit = unit,
             .request = request,
             .read = request.only_reads()};
    entry.give_up = after(t, policy.max_wait);
    if (before == 0) accept(entry);
    return std::nullopt;
}

std::optional<wire::Pdu> Gateway::answer_at_once(Instant t, const RequestPolicy& policy, UnitId unit,
                                                 const wire::PreparedRequest& request, bool first) {
    if (const auto code = refusal(request, broadcasts(unit))) return exception(request.function(), *code);
    if (!up_) return exception(request.function(), ExceptionCode::gateway_path_unavailable);
    if (!first || !request.only_reads() || policy.cache <= Duration::zero()) return std::nullopt;
    const wire::Pdu* const kept = cache_.find(t, unit, request.pdu(), policy.cache);
    if (!kept) return std::nullopt;
    ++counters_.from_cache;
    return *kept;
}

void Gateway::accept(Entry& entry) {
    entry.turn = turn_of(entry.requester.peer);
    entry.order = ++last_order_;
    if (!entry.read) note_write(entry.unit);
    entry.epoch = epochs_[entry.unit.value];
}

void Gateway::note_write(UnitId unit) {
    if (broadcasts(unit)) {
        for (auto& epoch : epochs_) ++epoch;
        return cache_.clear();
    }
    ++epochs_[unit.value];
    cache_.drop(unit);
}

// Appends the client's next request to the order.
void Gateway::promote(std::uint32_t server, std::uint64_t client) {
    const auto next = std::ranges::find_if(
        waiting_, [&](const Entry& entry) { return same_client(entry.requester, server, client); });
    if (next != waiting_.end() && next->order == 0) accept(*next);
}

Gateway::Entries::iterator Gateway::find(std::uint32_t server, serve::Token token) {
    return std::ranges::find_if(waiting_, [&](const Entry& entry) {
        return entry.requester.server == server && entry.requester.token == token;
    });
}

std::optional<Fate> Gateway::forget(std::uint32_t server, serve::Token token) {
    const auto found = find(server, token);
    if (found == waiting_.end()) return std::nullopt;
    ++counters_.forgotten;
    const Fate fate = is_in_flight(server, token) ? Fate::unknown : found->fate;
    const std::uint64_t client = found->requester.client;
    spare_.splice(spare_.end(), waiting_, found);
    promote(server, client);
    return fate;
}

bool Gateway::refuse(std::uint32_t server, serve::Token token, ExceptionCode code) {
    const auto found = find(server, token);
    if (found == waiting_.end() || is_in_flight(server, token)) return false;
    refuse(found, code);
    return true;
}

bool Gateway::is_in_flight(std::uint32_t server, serve::Token token) const {
    return flight_ && std::ranges::any_of(waiting_, [&](const Entry& entry) {
               return entry.requester.server == server && entry.requester.token == token &&
                      entry.order == flight_->order;
           });
}

void Gateway::on_withdrawn() {
    flight_.reset();
}

void Gateway::on_link(bool up) {
    up_ = up;
    health_.clear();
    if (up) return;
    cache_.clear();
    refuse_if([this](const Entry& entry) { return !concerns(entry); },
              ExceptionCode::gateway_path_unavailable);
}

void Gateway::on_tick(Instant t) {
    refuse_if([&](const Entry& entry) { return t >= entry.give_up && !concerns(entry); },
              ExceptionCode::server_device_busy);
}

Instant Gateway::next_wakeup() const {
    Instant wakeup = kNever;
    for (const Entry& entry : waiting_)
        if (!concerns(entry)) wakeup = std::min(wakeup, entry.give_up);
    return wakeup;
}

std::uint64_t Gateway::turn_of(std::uint64_t peer) const {
    std::uint64_t turn = turn_ + (std::ranges::find(served_, peer) != served_.end() ? 1U : 0U);
    for (const Entry& entry : waiting_)
        if (entry.order > 0 && entry.requester.peer == peer) turn = std::max(turn, entry.turn + 1);
    return turn;
}

void Gateway::note_turn(const Entry& entry) {
    if (entry.turn > turn_) {
        turn_ = entry.turn;
        served_.clear();
    }
    if (served_.size() < kServed) served_.push_back(entry.requester.peer);
}

bool Gateway::waits_for_write(const Entry& entry) const {
    return entry.read && std::ranges::any_of(waiting_, [&](const Entry& other) {
               return !other.read && other.order > 0 && other.order < entry.order &&
                      (other.unit == entry.unit || broadcasts(other.unit));
           });
}

// Refuses the latest request of the peer that has most, if that is more than the other one has.
bool Gateway::make_room(std::uint64_t for_peer) {
    const auto count = [this](std::uint64_t peer) {
        return std::ranges::count(waiting_, peer, [](const Entry& entry) { return entry.requester.peer; });
    };
    auto latest = waiting_.end();
    std::ptrdiff_t most = count(for_peer) + 1;
    for (auto entry = waiting_.begin(); entry != waiting_.end(); ++entry) {
        if (concerns(*entry)) continue;
        const auto own = count(entry->requester.peer);
        if (own < most || (own == most && latest == waiting_.end())) continue;
        most = own;
        latest = entry;
    }
    if (latest == waiting_.end()) return false;
    refuse(latest, ExceptionCode::server_device_busy);
    return true;
}

bool Gateway::ready(const Entry& entry) const {
    return entry.order > 0 && !waits_for_write(entry);
}

// Returns nullptr while a transaction is in flight, the link is down, or no request is queued.
const Gateway::Entry* Gateway::first_in_order(const MayStart& may_start) const {
    if (flight_ || !up_) return nullptr;
    const Entry* first = nullptr;
    const auto rank = [&](const Entry& entry) {
        return std::tuple(held(entry.unit, entry.request, may_start), entry.turn, entry.order);
    };
    for (const Entry& entry : waiting_)
        if (ready(entry) && (!first || rank(entry) < rank(*first))) first = &entry;
    return first;
}

bool Gateway::should_withdraw(const MayStart& may_start) const {
    return flight_ && held(flight_->unit, flight_->request, may_start) &&
           std::ranges::any_of(waiting_, [&](const Entry& entry) {
               return ready(entry) && !concerns(entry) && !held(entry.unit, entry.request, may_start);
           });
}

std::optional<bus::Transaction> Gateway::next(Instant t, const MayStart& may_start) {
    if (flight_ || !up_) return std::nullopt;
    on_tick(t);
    const Entry* const first = first_in_order(may_start);
    if (!first) return std::nullopt;
    note_turn(*first);
    flight_ = Flight{++last_id_,   first->unit,  first->request,       first->read,
                     first->order, first->epoch, first->requester.peer};
    return bus::Transaction{.id = flight_->id,
                            .unit = first->unit,
                            .request = first->request,
                            .wait = first->policy.response_timeout,
                            .late_limit = std::nullopt};
}

// Whether the transaction in flight answers the request.
bool Gateway::concerns(const Entry& entry) const {
    if (!flight_ || entry.order == 0) return false;
    if (entry.order == flight_->order) return true;
    return flight_->read && entry.read && entry.unit == flight_->unit && entry.epoch == flight_->epoch &&
           entry.request == flight_->request;
}

void Gateway::on_outcome(const bus::Outcome& outcome) {
    if (!flight_ || outcome.id != flight_->id) return;
    if (outcome.sent) ++counters_.sent;
    switch (outcome.status) {
        case bus::Status::ok:
            cache(outcome);
            answer_all(outcome.response.empty() ? answer_to_broadcast(flight_->request.pdu()).span()
                                                : outcome.response.pdu());
            break;
        case bus::Status::exception: answer_all(outcome.response.pdu()); break;
        case bus::Status::timeout:
        case bus::Status::bad_checksum:
        case bus::Status::ambiguous:
        case bus::Status::unexpected_reply:
            if (outcome.sent) {
                note_sent();
                retry_or_give_up(bus::status_of(outcome).status);
            } else {  // polling knows that the device does not answer
                counters_.not_asked += refuse_if([this](const Entry& entry) { return concerns(entry); },
                                                 ExceptionCode::gateway_target_failed_to_respond);
            }
            break;
        case bus::Status::link_lost:
        case bus::Status::closed:
        case bus::Status::cancelled:
        case bus::Status::line_busy: {
            const auto code = outcome.sent ? ExceptionCode::gateway_target_failed_to_respond
                                           : ExceptionCode::gateway_path_unavailable;
            if (outcome.sent) note_sent();
            refuse_if([this](const Entry& entry) { return concerns(entry); }, code);
            break;
        }
    }
    const std::uint64_t peer = flight_->peer;
    flight_.reset();
    note_health(outcome, peer);
}

// While a probe waits or is in flight, no other request of the peer to the unit is accepted.
bool Gateway::backs_off(Instant t, UnitId unit, std::uint64_t peer) const {
    if (health_.answering(unit, peer)) return false;
    return t < health_.probe_at(unit, peer) ||
           std::ranges::any_of(
               waiting_,
               [&](const Entry& entry) { return entry.unit == unit && entry.requester.peer == peer; });
}

void Gateway::note_health(const bus::Outcome& outcome, std::uint64_t peer) {
    const bool broadcast = config_.broadcast && outcome.unit == kBroadcast;
    if (!outcome.sent || broadcast) return;
    switch (outcome.status) {
        case bus::Status::ok:
        case bus::Status::ambiguous: health_.answered(outcome.unit, peer); return;
        case bus::Status::exception:
            if (came_from_gateway(outcome)) break;
            health_.answered(outcome.unit, peer);
            return;
        case bus::Status::timeout:
        case bus::Status::bad_checksum:
        case bus::Status::unexpected_reply:
        case bus::Status::closed: break;
        case bus::Status::link_lost:
        case bus::Status::cancelled:
        case bus::Status::line_busy: return;
    }
    health_.failed(outcome.ended_at, outcome.unit, peer);
    if (health_.answering(outcome.unit, peer)) return;
    counters_.not_asked += refuse_if(
        [&](const Entry& entry) { return entry.unit == outcome.unit && entry.requester.peer == peer; },
        ExceptionCode::gateway_target_failed_to_respond);
}

// The transaction in flight was sent, and no answer came.
void Gateway::note_sent() {
    for (Entry& entry : waiting_)
        if (concerns(entry)) entry.fate = Fate::unknown;
}

void Gateway::cache(const bus::Outcome& outcome) {
    if (!flight_->read || epochs_[flight_->unit.value] != flight_->epoch) return;
    const bool wanted = std::ranges::any_of(waiting_, [this](const Entry& entry) {
        return concerns(entry) && entry.policy.cache > Duration::zero();
    });
    if (wanted) cache_.store(outcome.sent_at, flight_->unit, flight_->request.pdu(), outcome.response.pdu());
}

// A retry goes to the end of the order, so that an unresponsive device does not hold up other clients.
void Gateway::retry_or_give_up(StatusCode failure) {
    std::uint64_t again = 0;
    for (auto entry = waiting_.begin(); entry != waiting_.end();) {
        if (!concerns(*entry)) {
            ++entry;
        } else if (!entry->read || !bus::attempts_left(failure, entry->policy.attempts, entry->failures)) {
            entry = refuse(entry, ExceptionCode::gateway_target_failed_to_respond);
        } else {
            ++again;
            ++entry;
        }
    }
    if (again == 0) return;
    for (Entry& entry : waiting_)
        if (concerns(entry)) {
            entry.turn = turn_of(entry.requester.peer);
            entry.order = ++last_order_;
        }
}

void Gateway::answer_all(Bytes pdu) {
    std::uint64_t answered = 0;
    for (auto entry = waiting_.begin(); entry != waiting_.end();) {
        if (!concerns(*entry)) {
            ++entry;
            continue;
        }
        entry = answer(entry, pdu, Fate::answered);
        ++answered;
    }
    if (answered > 1) counters_.shared += answered - 1;
}

Gateway::Entries::iterator Gateway::answer(Entries::iterator entry, Bytes pdu, Fate fate) {
    const Requester requester = entry->requester;
    const bool in_order = entry->order > 0;
    entry->answer.assign(pdu);
    entry->fate = fate;
    const auto following = std::next(entry);
    answered_.splice(answered_.end(), waiting_, entry);
    if (in_order) promote(requester.server, requester.client);
    return following;
}

Gateway::Entries::iterator Gateway::refuse(Entries::iterator entry, ExceptionCode code) {
    return answer(entry, exception(entry->request.function(), code).span(), entry->fate);
}

std::optional<Gateway::Reply> Gateway::take_reply() {
    if (answered_.empty()) return std::nullopt;
    const Entry& entry = answered_.front();
    const Reply reply{entry.requester.server, entry.requester.token, entry.answer, entry.fate};
    spare_.splice(spare_.end(), answered_, answered_.begin());
    return reply;
}

}  // namespace takt::serve
