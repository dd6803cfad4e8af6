// Records the events of the line: plans, links, sent and received bytes.
#include <algorithm>
#include <utility>

#include "line_judge.hpp"

namespace takt::judge {
namespace {

constexpr std::size_t kKept = 256;
constexpr Duration kStandstill = std::chrono::milliseconds(1);
constexpr Duration kFrameBreak = std::chrono::milliseconds(25);  // shorter ones part no frame

bool same_read(const plan::Request& a, const plan::Request& b) {
    return a.read && a.read == b.read && a.start == b.start && a.quantity == b.quantity &&
           a.period == b.period && a.phase == b.phase && a.read_trigger == b.read_trigger &&
           a.variables == b.variables;
}

}  // namespace

LineJudge::LineJudge(const Case& judged, std::size_t line, Complaints& complaints, const Adapter& adapter)
    : case_(judged),
      line_(judged.project.lines[line]),
      guarantee_(judged.guarantees[line]),
      index_(line),
      complaints_(complaints),
      arithmetic_(judged.project, line_),
      ledger_(line_.framing),
      adapter_(adapter) {
    for (std::size_t d = 0; d < line_.devices.size(); ++d) {
        const model::Device& device = line_.devices[d];
        devices_.push_back({.model = &device, .first_variable = variables_.size()});
        if (device.poll_enable) {
            const auto& initial = judged.project.locals[*device.poll_enable].default_value;
            devices_.back().enabled = initial && initial->integer != 0;
        }
        for (const auto& variable : device.variables) variables_.push_back({.model = &variable, .device = d});
    }
    adopt(judged.plan.lines[line]);
    set_bounds();
}

void LineJudge::adopt(const plan::LinePlan& given) {
    const plan::LinePlan& plan = plans_.emplace_back(given);
    requests_.clear();
    for (auto& device : devices_) device.has_reads = false;
    for (auto& variable : variables_) variable.change_group.reset();
    for (std::size_t r = 0; r < plan.requests.size(); ++r) {
        const plan::Request& request = plan.requests[r];
        auto& state = requests_.emplace_back(RequestState{.plan = &request});
        if (request.read && (request.period || request.read_trigger))
            devices_[request.device].has_reads = true;
        if (!request.write || !(request.write_on_change || request.write_trigger)) continue;
        const bool exchange = request.write == wire::Function::read_write_multiple_registers;
        for (const std::size_t v : request.variables) {
            const auto number = number_of(request.device, v);
            const model::Variable& variable = *variables_[number].model;
            const unsigned start = variable.start();
            if (exchange &&
                (!variable.write || variable.write_trigger != request.write_trigger ||
                 start < request.write_start ||
                 start + variable.items() > unsigned{request.write_start} + request.write_quantity))
                continue;
            state.members.push_back(number);
            if (request.write_on_change) variables_[number].change_group = r;
        }
    }
}

// Requested reads and writes stay requested. Each value may be read at once.
void LineJudge::on_plan(Instant t, const plan::LinePlan& plan) {
    for (auto& earlier : transactions_)  // to the master all are over
        if (!earlier.over) settle(earlier, earlier.received.answer == Answer::none ? t : earlier.heard_at);
    const auto old = std::exchange(requests_, {});
    adopt(plan);
    for (auto& now : requests_) {
        now.at_once = true;
        now.served_until = last_start_;
        for (const auto& before : old)
            if (before.plan->device == now.plan->device) carry(before, now);
    }
    plans_.pop_front();
    for (auto& transaction : transactions_) transaction.request.reset();
    ages_.assign(variables_.size(), std::nullopt);
    fresh_.assign(variables_.size(), std::nullopt);
    most_wait_ = Duration::zero();
    reckoned_.clear();
    ++recoveries_["plan_replaced"];
}

void LineJudge::carry(const RequestState& old, RequestState& now) const {
    if (old.edge && old.plan->read_trigger == now.plan->read_trigger) now.edge = old.edge;
    now.exchanged = now.edge && (now.exchanged || old.exchanged);
    if (same_read(*old.plan, *now.plan)) {
        now.retry = old.retry;
        now.failed_at = old.failed_at;
        now.failures = old.failures;
        now.busy = old.busy;
        now.held = old.held;
    }
    const bool same = !now.members.empty() && old.plan->write_on_change == now.plan->write_on_change &&
                      old.plan->write_trigger == now.plan->write_trigger &&
                      std::ranges::find(old.members, now.members.front()) != old.members.end();
    if (!same) return;
    now.set_since = old.set_since;
    now.triggered_since = old.triggered_since;
    now.set_bits = old.set_bits;
    now.changed = old.changed;
    now.repeat = old.repeat;
    now.open = old.open;
    now.last_admitted = old.last_admitted;
}

void LineJudge::complain(std::string_view invariant, Instant t, std::string expected,
                         std::string seen) const {
    complaints_.add(invariant, t, index_, std::move(expected), std::move(seen));
}

std::string LineJudge::describe(const Transaction& transaction) const {
    const Asked& asked = transaction.asked;
    std::string made = "request of " + milliseconds(transaction.start.time_since_epoch()) + " to " +
                       devices_[transaction.device].model->name + ", function " +
                       std::to_string(asked.function);
    if (asked.reads)
        made += ", reads " + std::to_string(asked.read_count) + " from " + std::to_string(asked.read_start);
    if (asked.writes || asked.masks)
        made += ", writes " + std::to_string(std::max<std::size_t>(asked.values.size(), 1)) + " from " +
                std::to_string(asked.write_start);
    return made;
}

std::optional<std::size_t> LineJudge::device_of(std::uint8_t unit) const {
    for (std::size_t d = 0; d < devices_.size(); ++d)
        if (devices_[d].model->address.value == unit) return d;
    return std::nullopt;
}

void LineJudge::begin_connection(Instant t) {
    keep_false_histories(t);  // a response that was held may be published with the close
    if (!serial()) ledger_.on_connection(t);
    received_.clear();
    busy_until_ = t;
    useless_ = !answers_;
    answers_ = heard_on_ = false;
}

void LineJudge::on_close(Instant t) {
    if (link_ != Link::up) return on_link(t, false);
    settle_answered();
    link_ = Link::closed;
    closed_at_ = t;
    settle_closed(t);
    // The peer does not speak Modbus, or all devices have met a close.
    may_be_lost_ = (heard_on_ && !answers_) || all_met_closes();
    if (may_be_lost_)
        for (auto& device : devices_) note_trouble(device, t);
    begin_connection(t);
}

void LineJudge::on_link(Instant t, bool up) {
    const Link before = std::exchange(link_, up ? Link::up : Link::lost);
    if (before == link_) return;
    settle_answered();
    if (before == Link::closed && up) {
        ++recoveries_["connection_reopened"];
        if (may_be_lost_ || useless_) note_excess({.t = t, .length = t - closed_at_, .device = {}});
        if (std::exchange(may_be_lost_, false)) perhaps_lost();
        return;
    }
    begin_connection(t);
    may_be_lost_ = false;
    closes_.clear();
    for (Transaction& transaction : transactions_) {
        if (transaction.over) continue;
        transaction.cut = true;
        transaction.close = Close::of_several;
        settle(transaction, t);
    }
    forget_between();
    for (auto& request : requests_) request.read_back_since.reset();
    for (auto& [id, command] : commands_) command.read_back_since.reset();
    if (!up) {
        for (auto& device : devices_) note_trouble(device, t);
        return;
    }
    const bool first = epoch_ == Instant::min();
    if (first) epoch_ = t;
    for (std::size_t d = 0; d < devices_.size(); ++d) {
        devices_[d].answers();
        devices_[d].probe_not_before = devices_[d].last_read = Instant::min();
        note_trouble(devices_[d], t);
    }
    for (auto& request : requests_) {
        // The schedule survives the link.
        if (first) request.served_until = t - Duration(1);
        request.held = false;
        request.failures = 0;
    }
    ++recoveries_["link_came_up"];
}

void LineJudge::on_sent(Instant t, std::span<const std::uint8_t> bytes, const std::optional<Claim>& claim) {
    settle_passed(t + Duration(1));
    if (one_at_a_time()) check_free(t);
    check_silence(t);
    auto asked = parse_request(line_.framing, bytes);
    const auto device = asked ? device_of(asked->unit) : std::nullopt;
    keep_false_histories(t);
    last_start_ = t;
    busy_until_ = t + arithmetic_.characters(bytes.size());
    heard_since_ = false;
    if (adapter_.echoes) echo_.assign(bytes.begin(), bytes.end());
    if (one_at_a_time()) received_.clear();
    if (!device || !claim) {
        complain("request_was_due", t, "a request to a device of the line", "something else was sent");
        return;
    }
    if (one_at_a_time())
        for (auto& earlier : transactions_)
            if (!earlier.over)
                settle(earlier, earlier.received.answer == Answer::none ? t : earlier.heard_at);
    ledger_.on_sent(t, *asked);
    Transaction transaction{.asked = std::move(*asked), .device = *device, .start = t, .end = busy_until_};
    transaction.deadline = t + arithmetic_.longest(*devices_[*device].model, transaction.asked);
    transaction.broadcast = arithmetic_.is_broadcast(transaction.asked);
    if (transaction.broadcast) ++recoveries_["broadcast"];
    for (auto& other : transactions_) {
        if (!may_wait(other, t)) continue;
        other.may_be_joined = transaction.may_be_joined = true;
        if (waits(other, t)) other.joined = transaction.joined = true;
    }
    transaction.may_be_joined = transaction.may_be_joined || relayed_open_;
    transaction.failure = arithmetic_.failure(*devices_[*device].model, transaction.asked);
    ++devices_[*device].sent;
    settle_claimed(t, *claim);
    check_probe(t, transaction, *claim);
    const bool starts_command = is_client(*claim);
    take_claim(transaction, *claim);
    transaction.client = starts_command;
    if (starts_command) check_polling_first(transaction);
    if (transaction.writes()) note_admitted(transaction);
    if (transaction.polls() || transaction.purpose == Purpose::probe || transaction.purpose == Purpose::trial)
        check_commands_first(transaction);
    if (transaction.polls()) check_priority(transaction);
    transactions_.push_back(std::move(transaction));
    while (transactions_.size() > kKept && transactions_.front().over) transactions_.pop_front();
}

// Until the end of the own request no device answers: received bytes are its echo or a disturbance.
std::span<const std::uint8_t> LineJudge::without_echo(Instant t, std::span<const std::uint8_t> bytes) {
    if (echo_.empty() || t > busy_until_) return bytes;
    const auto differ = std::ranges::mismatch(bytes, echo_);
    if (differ.in1 != bytes.end()) {
        echo_.clear();
        return bytes;
    }
    echo_.erase(echo_.begin(), differ.in2);
    return {};
}

// The devices of the line may answer it, late too. It goes before due polling only if the last one ended long
// enough ago.
void LineJudge::on_relayed(Instant t, std::span<const std::uint8_t> bytes) {
    settle_passed(t + Duration(1));
    if (one_at_a_time()) check_free(t);
    check_silence(t);
    const auto asked = parse_request(line_.framing, bytes);
    if (one_at_a_time())
        for (auto& earlier : transactions_)
            if (!earlier.over)
                settle(earlier, earlier.received.answer == Answer::none ? t : earlier.heard_at);
    const Duration apart = arithmetic_.silence() + line_.request_gap;
    if (relayed_end_ != Instant::min() && t < relayed_end_ + line_.relay_interval)
        if (const auto* poll = waiting_poll(std::max(last_start_, t - 2 * apart)))
            complain("order_kept", t,
                     "the read from " + std::to_string(poll->plan->start) + " before a relayed request, " +
                         std::to_string((t - relayed_end_).count()) + " ns after the last one",
                     "a relayed request");
    keep_false_histories(t);
    last_start_ = t;
    busy_until_ = t + arithmetic_.characters(bytes.size());
    heard_since_ = false;
    if (adapter_.echoes) echo_.assign(bytes.begin(), bytes.end());
    if (one_at_a_time()) received_.clear();
    if (asked) ledger_.on_sent(t, *asked);
    relayed_to_ = asked ? std::optional(asked->unit) : std::nullopt;
    if (const auto device = asked ? device_of(asked->unit) : std::nullopt) {
        // An exception that may belong to an earlier request of the device, too, holds the device back.
        const auto& model = *devices_[*device].model;
        note_trouble(devices_[*device],
                     t + arithmetic_.longest(model, *asked) + 2 * hold_of(devices_[*device]));
    }
    for (auto& other : transactions_) other.may_be_joined = other.may_be_joined || may_wait(other, t);
    relayed_open_ = true;
    ++recoveries_["relayed"];
}

// After one that failed, polling of its device is held back: once for its late response, and once more for an
// exception that may be that response.
void LineJudge::on_relayed_end(const bus::Outcome& outcome) {
    relayed_end_ = outcome.ended_at;
    relayed_open_ = false;
    const auto device = device_of(outcome.unit.value);
    const bool answered = outcome.status == bus::Status::ok || outcome.status == bus::Status::exception;
    if (answered) {
        closes_.clear();
        answers_ = true;
    }
    if (!device || answered) return;
    note_excess(
        {.t = outcome.ended_at, .length = {}, .device = device, .hold = 2 * hold_of(devices_[*device])});
}

void LineJudge::on_heard(Instant t, std::span<const std::uint8_t> bytes) {
    settle_passed(t);
    bytes = without_echo(t, bytes);
    if (bytes.empty()) return;
    // A frame in pieces with pauses may not be a frame for the master.
    paused_ = one_at_a_time() && !received_.empty() && (paused_ || t > heard_at_ + kFrameBreak);
    heard_at_ = t;
    busy_until_ = std::max(busy_until_, t);
    heard_since_ = heard_on_ = true;
    constexpr std::size_t kMost = 4096;
    if (received_.size() + bytes.size() > kMost) received_.clear();
    received_.insert(received_.end(), bytes.begin(), bytes.end());
    ledger_.on_heard(t, bytes);
    for (Transaction& transaction : transactions_) {
        if (transaction.over || transaction.broadcast) continue;
        transaction.heard_something = true;
        Received received = find_answer(line_.framing, transaction.asked, received_);
        received.among_others = received.among_others || paused_ || t > transaction.deadline ||
                                ledger_.doubtful(transaction.asked);
        if (received.answer != Answer::none &&
            (adapter_.in_parts || transaction.received.answer != Answer::good)) {
            transaction.received = std::move(received);
            transaction.heard_at = t;
            if (transaction.received.answer == Answer::good) note_served(transaction);
        }
        if (adapter_.in_parts) continue;  // more may follow
        // A wrong answer with the right transaction id ends the transaction too.
        const bool wrong = !one_at_a_time() && transaction.received.answer == Answer::odd;
        if (wrong || transaction.received.answer == Answer::good ||
            transaction.received.answer == Answer::exception)
            settle(transaction, t);
    }
    if (one_at_a_time()) note_further_answers();
    if (!one_at_a_time()) {
        note_late_answers(t);
        const auto done = static_cast<std::ptrdiff_t>(complete_frames(received_));
        received_.erase(received_.begin(), received_.begin() + done);
    }
}

// The master may take the last frame that could be the answer instead of the first.
void LineJudge::note_further_answers() {
    if (transactions_.empty() || !transactions_.back().asked.reads) return;
    Transaction& last = transactions_.back();
    const auto came = ledger_.candidates(last.asked);
    if (came.size() < 2 || came.size() - 1 == last.further.size()) return;
    last.further.clear();
    for (auto frame = came.begin() + 1; frame != came.end(); ++frame)
        last.further.push_back(values_in(last.asked, *frame));
    last.received.among_others = true;
}

// A server that answers sequentially gets more requests at a time than its time-outs allow.
void LineJudge::note_late_answers(Instant t) {
    for (const Transaction& transaction : transactions_)
        if (transaction.over && transaction.received.answer == Answer::none &&
            find_answer(line_.framing, transaction.asked, received_).answer != Answer::none)
            devices_[transaction.device].answered_late = t;
}

bool LineJudge::answers_too_late(Instant t, const DeviceState& device) const {
    const auto& backoff = device.model->backoff.value_or(case_.project.backoff);
    return device.answered_late && t - *device.answered_late <= 2 * backoff.limit;
}

}  // namespace takt::judge
