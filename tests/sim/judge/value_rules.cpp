// value_own, value_true, recovers.
#include <algorithm>
#include <utility>

#include "line_judge.hpp"

namespace takt::judge {
namespace {

constexpr Duration kSweep = std::chrono::seconds(1);
constexpr std::size_t kServed = 256;
constexpr Duration kLookBack = std::chrono::seconds(2);
constexpr Duration kTransaction = std::chrono::seconds(1);  // an age counts from its start
constexpr Duration kMostHeld = std::chrono::seconds(1);     // docs/guarantees.md, "Values in doubt"
constexpr Duration kDoubted = std::chrono::minutes(5);

double ratio(Duration part, Duration whole) {
    return static_cast<double>(part.count()) / static_cast<double>(whole.count());
}

}  // namespace

// T + R of each variable, with the worst dead device too, and the load of the line.
void LineJudge::set_bounds() {
    std::vector<std::optional<Duration>> later(variables_.size(), Duration::zero());
    reckoned_.resize(requests_.size());
    for (const plan::JobBound& job : guarantee_.jobs) {
        const plan::Request& request = case_.plan.lines[index_].requests[job.request];
        once_ += job.bound.transaction;
        auto& reckoned = reckoned_[job.request];
        reckoned = std::max(reckoned.value_or(Duration::zero()), job.bound.transaction);
        if (job.cause != plan::Cause::period) continue;
        for (const std::size_t v : request.variables) {
            auto& more = later[number_of(request.device, v)];
            if (!more || !job.bound.response || !job.bound.response_with_dead)
                more.reset();
            else
                more = std::max(*more, *job.bound.response_with_dead - *job.bound.response);
        }
    }
    load_ = guarantee_.utilization;
    // On an overloaded line overdue requests are sent first.
    const bool overloaded = case_.plan.lines[index_].utilization > 1;
    for (std::size_t d = 0; d < devices_.size(); ++d)
        for (std::size_t i = 0; i < line_.devices[d].variables.size(); ++i) {
            const auto age = overloaded ? std::nullopt : guarantee_.ages[d][i];
            const auto& more = later[number_of(d, i)];
            ages_.push_back(age);
            dead_ages_.push_back(age && more ? std::optional(*age + *more) : std::nullopt);
            const auto& proved = guarantee_.ages_with_failures;
            fresh_.push_back(guarantee_.feasible && d < proved.size() ? proved[d][i] : std::nullopt);
        }
    set_most_wait();
}

// A poll that waits for four deadlines is overdue. Overdue polls take turns, so each other request of the
// plan goes before it at most twice, with a failed attempt. Commands of clients and relayed requests take
// their share of the line, and one of each may be in flight or saved up.
void LineJudge::set_most_wait() {
    Duration once{};
    Duration longest{};
    for (const plan::JobBound& job : guarantee_.jobs) {
        once += job.bound.failure;
        if (job.cause == plan::Cause::period)
            longest = std::max(longest, job.bound.deadline.value_or(Duration::zero()));
    }
    constexpr Duration kClient = std::chrono::milliseconds(600);  // no transaction takes longer
    double share = 0;
    if (line_.relayed) share += ratio(kClient, line_.relay_interval + kClient);
    share += ratio(kClient, line_.commands.min_interval + kClient);
    const Duration busy = 2 * once + (3 + line_.commands.burst) * kClient;
    const double free = (1 - std::min(share, 1.0));
    constexpr double kLeast = 0.02;
    if (free < kLeast) return;
    most_wait_ = 4 * longest + Duration(static_cast<std::int64_t>(static_cast<double>(busy.count()) / free));
}

// What is known, and what transactions in flight have taken so far.
template <class Count>
void LineJudge::each_excess(Instant t, Count count) const {
    for (const Excess& excess : excess_) count(excess);
    // A transaction at its deadline fails at this instant; an unbounded one may be in flight.
    for (const Transaction& transaction : transactions_) {
        if (transaction.over) continue;
        if (t >= transaction.deadline && !transaction.broadcast)
            count(excess_of_failure(transaction, t, t - transaction.start));
        else if (!transaction.polls() && !transaction.expected)
            count({.t = t, .length = t - transaction.start, .device = {}, .bounded = transaction.client});
        else if (const auto more = beyond(transaction, t - transaction.start); more > Duration::zero())
            count({t, more, {}});
        else if (in_doubt(transaction))
            count(excess_of_confirmation(transaction, t));
    }
}

// Line time that faults, failures and repetitions took since then.
Duration LineJudge::lost_since(Instant from, Instant t) const {
    Duration lost{};
    each_excess(t, [&](const Excess& excess) {
        if (!excess.bounded && excess.t + excess.length >= from) lost += excess.length + excess.hold;
    });
    return lost;
}

// On a line that holds its periods a read is sent within the period of its release, so at least once in two
// periods. What faults and clients took of the line since then comes on top, with what has become due
// meanwhile.
Duration LineJudge::most_wait(const RequestState& request, Instant since, Instant t) const {
    const Duration longest = most_wait_ + 2 * lost_since(since - most_wait_, t);
    constexpr double kFull = 0.7;
    if (line_.relayed || load_ >= kFull || !guarantee_.feasible || in_doubt(since, request.plan->device))
        return longest;
    const Duration period = *request.plan->period;
    Duration taken = once_;
    each_excess(t, [&](const Excess& excess) {
        if (excess.t + excess.length >= since - period) taken += excess.length + excess.hold;
    });
    return std::min(longest, period + Duration(static_cast<Duration::rep>(static_cast<double>(taken.count()) /
                                                                          (1 - load_))));
}

// Transactions beyond their deadline are settled with the next frame.
bool LineJudge::may_have_died(std::size_t device, Instant t) const {
    const auto passed = std::ranges::count_if(transactions_, [&](const Transaction& each) {
        return !each.over && each.device == device && each.deadline < t;
    });
    return devices_[device].possible + static_cast<unsigned>(passed) >= devices_[device].model->attempts;
}

// Polling advances independent of clients: a due poll of a device that answers is sent in bounded time.
void LineJudge::check_advance(Instant t) {
    if (most_wait_ <= Duration::zero() || (link_ != Link::up && link_ != Link::closed)) return;
    for (const auto& request : requests_) {
        const plan::Request& planned = *request.plan;
        if (!planned.read || !planned.period || *planned.period <= Duration::zero() || request.held ||
            request.retry || request.at_once || request.busy)
            continue;
        const DeviceState& device = devices_[planned.device];
        const Instant released = first_release_after(request, request.served_until);
        const Instant since = std::max(released, device.clean_from);
        const Duration most = most_wait(request, since, t);
        if (!device.enabled || may_have_died(planned.device, t) || since <= forgotten_ || t - since <= most)
            continue;
        complain("polling_advances", t,
                 "the read from " + std::to_string(planned.start) + " of " + device.model->name + " within " +
                     milliseconds(most),
                 "it is due for " + milliseconds(t - released));
        return;
    }
}

// In the order of sending. After a suspension of the host some unserved transactions are beyond their time
// but not over: those that may still be served come first.
void LineJudge::on_read(const sim::DeviceItems& items) {
    served_.push_back({items.time, items.unit.value, items.area, items.start,
                       Words(items.values.begin(), items.values.end())});
    if (served_.size() > kServed) served_.pop_front();
    Transaction* served = nullptr;
    for (auto& transaction : transactions_) {
        const Asked& asked = transaction.asked;
        if (!asked.reads || asked.unit != items.unit.value || asked.read_area != items.area ||
            asked.read_start != items.start || asked.read_count != items.values.size() || transaction.served)
            continue;
        if (transaction.over && &transaction != &transactions_.back()) continue;
        if (!served || items.time <= transaction.deadline) served = &transaction;
        if (items.time <= transaction.deadline) break;
    }
    if (!served) return;
    served->served = true;
    served->served_at = items.time;
    served->values.assign(items.values.begin(), items.values.end());
}

// An answer identifies the reading of the device that it belongs to: earlier equal requests that timed out
// may still be answered.
void LineJudge::note_served(Transaction& transaction) const {
    const Asked& asked = transaction.asked;
    const auto found = std::ranges::find_if(served_, [&](const Served& each) {
        return each.t >= transaction.start && each.unit == asked.unit && each.area == asked.read_area &&
               each.start == asked.read_start && each.items == transaction.received.values;
    });
    if (!asked.reads || found == served_.end()) return;
    transaction.served = true;
    transaction.served_at = found->t;
    transaction.values = found->items;
}

std::optional<Words> LineJudge::items_of(const Transaction& transaction, VariableNumber v) const {
    return transaction.served ? items_in(transaction, v, transaction.values) : std::nullopt;
}

std::optional<Words> LineJudge::items_in(const Transaction& transaction, VariableNumber v,
                                         std::span<const std::uint16_t> values) const {
    const Asked& asked = transaction.asked;
    const model::Variable& model = *variables_[v].model;
    const unsigned start = model.start();
    if (transaction.device != variables_[v].device || asked.read_area != model.area ||
        start < asked.read_start || start + model.items() > asked.read_start + values.size())
        return std::nullopt;
    const auto part = values.subspan(start - asked.read_start, model.items());
    return Words(part.begin(), part.end());
}

// The master found the answer between other bytes.
void LineJudge::note_found(Transaction& transaction) {
    DeviceState& device = devices_[transaction.device];
    if (!transaction.over && device.may_be_dead()) came_back(transaction.device);
    transaction.received.answer = Answer::good;
    transaction.received.among_others = false;
    if (!transaction.over) {
        note_event_end(transaction, transaction.heard_at);
        if (transaction.purpose == Purpose::read_back) settle_read_back(transaction, transaction.heard_at);
    }
    transaction.over = true;
    if (in_doubt(transaction)) note_excess(excess_of_confirmation(transaction, transaction.heard_at));
    device.answers();
    if (!transaction.request || !transaction.is_its_read()) return;
    RequestState& request = requests_[*transaction.request];
    request.held = false;
    request.failures = 0;
    if (transaction.purpose != Purpose::trigger)
        request.retry = false;
    else if (transaction.waits_again && !transaction.partial)  // its own; the polling goes on as it stood
        request.edge = std::exchange(request.next_edge, std::nullopt);
}

// The transaction that is answered now. With several in flight: one whose response has just come, else any
// one with a valid answer; unrecognised answers last.
Transaction* LineJudge::source_of(VariableNumber v, const value::Slot& slot) {
    const auto any = [](const Transaction&) { return true; };
    const auto good = [](const Transaction& each) {
        return each.received.answer == Answer::good && !each.received.among_others;
    };
    const auto new_response = [this](const Transaction& each) {
        return each.received.answer == Answer::good && each.heard_at == heard_at_;
    };
    const auto find = [&](const auto& accepted) -> Transaction* {
        for (auto i = transactions_.rbegin(); i != transactions_.rend(); ++i) {
            const auto items = items_of(*i, v);
            if (items && i->heard_something && accepted(*i) && takes(*i, v) &&
                holds(*variables_[v].model, *items, slot.value, false))
                return &*i;
            if (one_at_a_time()) break;
        }
        return nullptr;
    };
    if (auto* const found = find(new_response)) return found;
    if (auto* const found = find(good)) return found;
    return find(any);
}

// The device has failed, or has answered once too often. For how long that is doubted depends on its times.
bool LineJudge::may_be_doubted(Instant t, std::size_t device) const {
    const auto& state = devices_[device];
    return one_at_a_time() &&
           (t <= after(state.clean_from, kDoubted) || ledger_.may_check(t, state.model->address.value));
}

// The master says that it was read before the last request.
bool LineJudge::was_held(const value::Slot& slot) const {
    return one_at_a_time() && !transactions_.empty() && slot.good_at <= transactions_.back().start;
}

// The transaction before the last one, whose values were held back: that which was answered when the master
// says that the value was read.
Transaction* LineJudge::held_source_of(Instant t, VariableNumber v, const value::Slot& slot) {
    if (!may_be_doubted(t, variables_[v].device) || t - slot.good_at.value_or(t) > kMostHeld) return nullptr;
    for (auto i = transactions_.rbegin(); i != transactions_.rend(); ++i) {
        if (i->start >= slot.good_at || i->device != variables_[v].device) continue;
        const auto items = items_of(*i, v);
        if (items && i->received.answer == Answer::good && i->served_at >= variables_[v].sampled_at &&
            takes(*i, v) && holds(*variables_[v].model, *items, slot.value, false))
            return &*i;
        for (const FalseHistory& history : i->false_histories)
            if (shows(t, *i, history, v, slot)) return &*i;
        return nullptr;
    }
    return nullptr;
}

// Before another request is sent, or the connection ends.
void LineJudge::keep_false_histories(Instant t) {
    if (transactions_.empty() || transactions_.back().start != last_start_) return;
    Transaction& last = transactions_.back();
    if (may_be_doubted(t, last.device)) last.false_histories = false_histories(t, last);
}

std::vector<FalseHistory> LineJudge::false_histories(Instant t, const Transaction& transaction) const {
    std::vector<FalseHistory> found;
    if (!one_at_a_time() || !transaction.asked.reads) return found;
    for (const ByteVector& pdu : ledger_.candidates(transaction.asked)) {
        Words values = values_in(transaction.asked, pdu);
        if (transaction.served && values == transaction.values) continue;
        if (const auto exempt = ledger_.exemption(t, transaction.start, transaction.asked, pdu))
            found.push_back({std::move(values), *exempt});
    }
    return found;
}

// The value is wrong, and the bytes show a history in which it is true.
bool LineJudge::shows_false_history(Instant t, VariableNumber v, const value::Slot& slot) {
    if (transactions_.empty()) return false;
    Transaction& last = transactions_.back();
    const bool kept = !last.false_histories.empty();  // a relayed request was sent after it
    for (const FalseHistory& history : kept ? last.false_histories : false_histories(t, last)) {
        if (!shows(t, last, history, v, slot)) continue;
        note_found(last);
        if (variables_[v].model->read) note_sample(v, last);
        return true;
    }
    return false;
}

bool LineJudge::shows(Instant t, Transaction& transaction, const FalseHistory& history, VariableNumber v,
                      const value::Slot& slot) {
    const auto items = items_in(transaction, v, history.values);
    if (!items || !takes(transaction, v) || !holds(*variables_[v].model, *items, slot.value, false))
        return false;
    ++recoveries_[history.exemption];
    ledger_.note_exempt(t, transaction.asked);
    transaction.served = true;
    transaction.served_at = std::max(transaction.end, transaction.heard_at);  // some time between the two
    transaction.values = Words(history.values);
    return true;
}

// Whether the request is also sent for that variable.
bool LineJudge::takes(const Transaction& transaction, VariableNumber v) const {
    if (!transaction.request) return true;
    const plan::Request& request = *requests_[*transaction.request].plan;
    const std::size_t index = v - devices_[variables_[v].device].first_variable;
    return std::ranges::find(request.variables, index) != request.variables.end();
}

// Not before its time, and with the last value.
void LineJudge::check_stale(Instant t, VariableNumber v, const value::Slot& slot) const {
    if (slot.reason != value::Reason::stale || !variables_[v].good || !fresh_[v]) return;
    if (t - variables_[v].sampled_at + kTransaction < *fresh_[v])
        complain("value_true", t,
                 name_of(v) + " not stale before it is older than " + milliseconds(*fresh_[v]),
                 "it is from " + milliseconds(t - variables_[v].sampled_at) + " ago");
}

// A good value is no longer good: its device was switched, did not answer, or has refused something, or the
// line was lost. A late answer in doubt is in the ledger.
void LineJudge::check_quality(Instant t, VariableNumber v, const value::Slot& slot) const {
    const auto& variable = variables_[v];
    if (!variable.good || slot.quality == value::Quality::good || slot.reason == value::Reason::stale ||
        (slot.reason == value::Reason::ambiguous && may_be_doubted(t, variable.device)))
        return;
    if (devices_[variable.device].clean_from >= variable.sampled_at || in_doubt(t, variable.device)) return;
    const auto times_out = [&](const Transaction& each) {
        return !each.over && each.device == variable.device && each.deadline <= t;
    };
    if (std::ranges::any_of(transactions_, times_out)) return;
    complain("quality_own", t,
             name_of(v) + " good: nothing happened to " + devices_[variable.device].model->name +
                 " since it was read",
             std::string(name(slot.quality)) + ", reason " + std::to_string(static_cast<int>(slot.reason)));
}

void LineJudge::check_sample(Instant t, VariableNumber v, const value::Slot& slot) {
    check_stale(t, v, slot);
    check_quality(t, v, slot);
    auto& variable = variables_[v];
    const model::Variable& model = *variable.model;
    variable.good = false;
    if (slot.quality != value::Quality::good) return;
    if (!model.read) {
        const auto held = [&](const Executed& executed) {
            return holds(model, executed.items, slot.value, true);
        };
        const bool was =
            std::ranges::any_of(variable.executed, held) || std::ranges::any_of(variable.believed, held);
        if (!was && !(was_held(slot) ? held_source_of(t, v, slot) : source_of(v, slot)) &&
            !shows_false_history(t, v, slot))
            complain("value_own", t, name_of(v) + ", which is not read, shows what was written",
                     text(slot.value));
        return;
    }
    const auto whole = [&](const RequestState& request) {
        const plan::Request& planned = *request.plan;
        return planned.read && planned.device == variable.device && planned.start <= model.start() &&
               model.start() + unsigned{model.items()} <= unsigned{planned.start} + planned.quantity;
    };
    if (std::ranges::none_of(requests_, whole)) return;  // read in parts
    const bool held = was_held(slot);
    Transaction* source = held ? held_source_of(t, v, slot) : source_of(v, slot);
    if (!source && !held && shows_false_history(t, v, slot)) return;
    if (!source) {
        const bool any = !transactions_.empty();
        const auto items = any ? items_of(transactions_.back(), v) : std::nullopt;
        complain(
            "value_own", t,
            name_of(v) +
                (items ? " = " + text(value_of(model, *items)) + ", as the device has answered the "
                       : ": nothing, the device has not given it in answer to the ") +
                (any ? describe(transactions_.back()) : "requests so far"),
            text(slot.value) +
                (any ? ledger_.describe(t, transactions_.back().start, transactions_.back().asked) : ""));
        return;
    }
    const bool unsure = source->received.answer != Answer::good || source->received.among_others;
    if (unsure && !held) note_found(*source);
    note_sample(v, *source);
}

// Only of a variable that is read. Another one has no age, and keeps the value last written or compared while
// its device is away.
void LineJudge::note_sample(VariableNumber v, const Transaction& source) {
    variables_[v].good = true;
    variables_[v].sampled_at = source.served_at;
    variables_[v].read_items = items_of(source, v);
}

// The time beyond C of an answer in pieces, behind disturbances, or behind others in its server.
Duration LineJudge::beyond(const Transaction& transaction, Duration occupied) const {
    if (!transaction.request || !transaction.is_its_read() || *transaction.request >= reckoned_.size())
        return {};
    return std::max(Duration::zero(), occupied - reckoned_[*transaction.request].value_or(occupied));
}

// Within the assumptions the bound is T + R, or the bound with one dead device. Otherwise the response grows
// by the lost time X and by the requests that became due meanwhile: (X + all requests once) / (1 - U) with
// the line's load U.
std::optional<Duration> LineJudge::bound(VariableNumber v, Instant t) const {
    const auto& age = ages_[v];
    if (!age) return std::nullopt;
    const std::size_t own = variables_[v].device;
    const Instant from = variables_[v].sampled_at - std::max(*age, kLookBack);
    if (from <= forgotten_) return std::nullopt;  // it was judged while all that was lost was known
    Duration lost{};
    std::optional<std::size_t> culprit;
    bool one_device = true;
    each_excess(t, [&](const Excess& excess) {
        const Duration length = excess.length + (excess.device == own ? excess.hold : Duration::zero());
        if (excess.t > t || excess.t + length < from) return;
        lost += length;
        one_device = one_device && !excess.unproved && excess.device && excess.device != own &&
                     (!culprit || culprit == excess.device);
        culprit = excess.device;
    });
    if (lost == Duration::zero()) return age;
    constexpr double kFull = 0.95;
    std::optional<Duration> longest;
    if (load_ < kFull) {
        const double delay = static_cast<double>((lost + once_).count()) / (1 - load_);
        longest = *age + once_ + Duration(static_cast<std::int64_t>(delay));
    }
    if (one_device && dead_ages_[v]) longest = std::min(longest.value_or(*dead_ages_[v]), *dead_ages_[v]);
    return longest;
}

void LineJudge::check_age(Instant t, VariableNumber v) {
    if (!variables_[v].good) return;
    const Duration age = t - variables_[v].sampled_at;
    if (fresh_[v] && age > *fresh_[v] && t > stood_still_until_ + std::chrono::milliseconds(1)) {
        complain("value_true", t, name_of(v) + " stale when it is older than " + milliseconds(*fresh_[v]),
                 "it is from " + milliseconds(age) + " ago and shown as good");
        return;
    }
    if (!ages_[v] || age <= *ages_[v]) return;
    const auto longest = bound(v, t);
    if (!longest || age <= *longest) return;
    complain("value_true", t,
             name_of(v) + " no older than " + milliseconds(*longest) + " (guaranteed " +
                 milliseconds(*ages_[v]) + ")",
             "it is from " + milliseconds(age) + " ago and shown as good");
}

// The master marks the values when it counts a device as not answering, and when the link is lost.
void LineJudge::check_outage(Instant t, VariableNumber v) const {
    const std::size_t device = variables_[v].device;
    const auto answers_now = [device](const Transaction& each) {
        return !each.over && each.device == device;
    };
    if (!variables_[v].good || std::ranges::any_of(transactions_, answers_now)) return;
    if (link_ == Link::lost)
        complain("value_true", t, name_of(v) + " not good while its line is closed", "shown as good");
    else if (devices_[device].dead())
        complain("value_true", t, name_of(v) + " not good while its device does not answer", "shown as good");
}

void LineJudge::look(Instant t, const value::Store& store, std::uint32_t first_slot,
                     const std::vector<std::uint64_t>& ended) {
    check_length(t, ended);
    const bool sweep = t >= next_sweep_;
    if (sweep) {
        next_sweep_ = t + kSweep;
        check_expired(t);
    }
    for (VariableNumber v = 0; v < variables_.size(); ++v) {
        const value::Slot& slot = store[{first_slot + static_cast<std::uint32_t>(v)}];
        if (slot.batch == variables_[v].batch) {
            if (!sweep) continue;
            check_age(t, v);
            check_outage(t, v);
            continue;
        }
        variables_[v].batch = slot.batch;
        check_age(t - Duration(1), v);  // it was shown until this instant: it may have become stale in time
        check_sample(t, v, slot);
    }
    if (sweep) check_advance(t);
}

// The events of a value are in the order of their times, and no good value of a device overtakes an earlier
// one.
void LineJudge::on_event(Instant t, const value::Event& event, std::uint32_t first_slot) {
    const VariableNumber v = event.slot.value - first_slot;
    if (event.slot.value < first_slot || v >= variables_.size()) return;
    auto& last_event = variables_[v].event_at;
    if (event.t < last_event)
        complain("value_own", t, name_of(v) + ": an event not before " + milliseconds(last_event - Instant{}),
                 text(event.value) + ", at " + milliseconds(event.t - Instant{}));
    last_event = event.t;
    if (event.quality != value::Quality::good) return;
    auto& last = devices_[variables_[v].device].good_at;
    const Instant good_at = event.good_at.value_or(event.t);
    if (good_at < last)
        complain("value_own", t, name_of(v) + ": good not before " + milliseconds(last - Instant{}),
                 text(event.value) + ", good at " + milliseconds(good_at - Instant{}));
    last = good_at;
}

// After a surplus response each read waits for a sign that its response is its own, for kMostHeld at most.
// The read before it was good.
bool LineJudge::is_held(Instant t, VariableNumber v, const value::Slot& slot, Duration period) const {
    return slot.reason == value::Reason::ambiguous && t - variables_[v].sampled_at <= 2 * period + kMostHeld;
}

void LineJudge::finish(Instant t, const value::Store& store, std::uint32_t first_slot) {
    for (VariableNumber v = 0; v < variables_.size(); ++v) {
        const auto& variable = variables_[v];
        const auto polls = [&](const RequestState& request) {
            return request.plan->period && request.plan->device == variable.device &&
                   std::ranges::find(request.plan->variables, v - devices_[variable.device].first_variable) !=
                       request.plan->variables.end();
        };
        const value::Slot& slot = store[{first_slot + static_cast<std::uint32_t>(v)}];
        if (!variable.model->read || !variable.model->used || !devices_[variable.device].enabled ||
            answers_too_late(t, devices_[variable.device]))
            continue;
        const auto polled = std::ranges::find_if(requests_, polls);
        if (polled == requests_.end()) continue;
        // A late answer may still hold it back, or be mistaken for its own.
        const bool doubted = in_doubt(t, {.unit = devices_[variable.device].model->address.value,
                                          .function = static_cast<std::uint8_t>(*variable.model->read)});
        if (slot.quality != value::Quality::good && devices_[variable.device].clean_from <= t && !doubted &&
            !is_held(t, v, slot, *polled->plan->period))
            complain("recovers", t, name_of(v) + " is good again, all faults are over",
                     std::string(name(slot.quality)) + ", reason " +
                         std::to_string(static_cast<int>(slot.reason)));
    }
    for (const auto& [id, command] : commands_) {
        const auto group = variables_[command.variable].change_group;
        if (devices_[variables_[command.variable].device].clean_from > t) continue;
        if (group ? group_waits(requests_[*group]) : queues_for_bucket(command.variable, t)) continue;
        complain("outcome_once", t, "an outcome of command " + std::to_string(id), "none");
    }
}

}  // namespace takt::judge
