// What happened on the line: transactions, their ends, the state of the devices.
#include <algorithm>

#include "line_judge.hpp"

namespace takt::judge {
namespace {

constexpr std::size_t kKept = 48;
constexpr Duration kAfterStandstill = std::chrono::milliseconds(1);
constexpr Duration kRemembered = std::chrono::minutes(2);

std::string milliseconds(Instant t) {
    const auto microseconds = t.time_since_epoch().count() / 1000;
    return std::to_string(microseconds / 1000) + "." + std::to_string(1000 + microseconds % 1000).substr(1) +
           " ms";
}

}  // namespace

LineJudge::LineJudge(const Case& judged, std::size_t line, Complaints& complaints)
    : case_(judged),
      line_(judged.project.lines[line]),
      plan_(judged.plan.lines[line]),
      guarantee_(judged.guarantees[line]),
      index_(line),
      complaints_(complaints),
      arithmetic_(judged.project, line_) {
    for (std::size_t d = 0; d < line_.devices.size(); ++d) {
        const model::Device& device = line_.devices[d];
        devices_.push_back({.model = &device, .first_variable = variables_.size()});
        if (device.poll_enable) {
            const auto& initial = judged.project.locals[*device.poll_enable].default_value;
            devices_.back().enabled = initial && initial->integer != 0;
        }
        for (const auto& variable : device.variables) variables_.push_back({.model = &variable, .device = d});
    }
    for (std::size_t r = 0; r < plan_.requests.size(); ++r) {
        const plan::Request& request = plan_.requests[r];
        auto& state = requests_.emplace_back(RequestState{.plan = &request});
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
    set_bounds();
}

void LineJudge::complain(std::string_view invariant, Instant t, std::string expected,
                         std::string seen) const {
    complaints_.add(invariant, t, index_, std::move(expected), std::move(seen));
}

std::string LineJudge::describe(const Transaction& transaction) const {
    const Asked& asked = transaction.asked;
    std::string made = "request of " + milliseconds(transaction.start) + " to " +
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

void LineJudge::on_link(Instant t, bool up) {
    if (up == up_) return;
    up_ = up;
    heard_.clear();
    busy_until_ = t;
    for (Transaction& transaction : transactions_) {
        if (transaction.over) continue;
        transaction.cut = true;
        settle(transaction, t);
    }
    if (!up) return;
    epoch_ = t;
    for (std::size_t d = 0; d < devices_.size(); ++d) {
        devices_[d].failures = devices_[d].probes = 0;
        devices_[d].probe_not_before = Instant::min();
        note_trouble(devices_[d], t);
    }
    for (auto& request : requests_) {
        request.served_until = t - Duration(1);
        request.held = request.retry = request.at_once = false;
        request.failures = 0;
    }
    ++recoveries_["link_came_up"];
}

void LineJudge::on_sent(Instant t, std::span<const std::uint8_t> bytes) {
    settle_passed(t + Duration(1));
    if (one_at_a_time()) check_free(t);
    check_silence(t);
    auto asked = parse_request(line_.framing, bytes);
    const auto device = asked ? device_of(asked->unit) : std::nullopt;
    last_start_ = t;
    busy_until_ = t + arithmetic_.characters(bytes.size());
    heard_since_ = false;
    if (one_at_a_time()) heard_.clear();
    if (!device) {
        complain("request_was_due", t, "a request to a device of the line", "something else was sent");
        return;
    }
    if (one_at_a_time())
        for (auto& earlier : transactions_)
            if (!earlier.over) settle(earlier, t);
    Transaction transaction{.asked = std::move(*asked), .device = *device, .start = t, .end = busy_until_};
    transaction.deadline = t + arithmetic_.longest(*devices_[*device].model, transaction.asked);
    transaction.failure = arithmetic_.failure(*devices_[*device].model, transaction.asked);
    ++devices_[*device].sent;
    free_mistaken();
    check_probe(t, transaction);
    if (transaction.asked.writes || transaction.asked.masks) {
        classify_write(transaction);
        note_admitted(transaction);
    } else {
        classify_read(transaction);
    }
    if (transaction.purpose == Purpose::polled || transaction.purpose == Purpose::probe)
        check_commands_first(transaction);
    if (transaction.purpose == Purpose::polled) check_priority(transaction);
    transactions_.push_back(std::move(transaction));
    while (transactions_.size() > kKept && transactions_.front().over) transactions_.pop_front();
}

void LineJudge::on_heard(Instant t, std::span<const std::uint8_t> bytes) {
    settle_passed(t);
    busy_until_ = std::max(busy_until_, t);
    heard_since_ = true;
    constexpr std::size_t kMost = 4096;
    if (heard_.size() + bytes.size() > kMost) heard_.clear();
    heard_.insert(heard_.end(), bytes.begin(), bytes.end());
    for (Transaction& transaction : transactions_) {
        if (transaction.over) continue;
        transaction.heard_something = true;
        Heard heard = find_answer(line_.framing, transaction.asked, heard_);
        if (heard.answer != Answer::none && transaction.heard.answer != Answer::good) {
            transaction.heard = std::move(heard);
            transaction.heard_at = t;
        }
        // A wrong answer with the right transaction id ends it too.
        const bool wrong = !one_at_a_time() && transaction.heard.answer == Answer::odd;
        if (wrong || transaction.heard.answer == Answer::good ||
            transaction.heard.answer == Answer::exception)
            settle(transaction, t);
    }
    if (!one_at_a_time()) {
        const auto done = static_cast<std::ptrdiff_t>(complete_frames(heard_));
        heard_.erase(heard_.begin(), heard_.begin() + done);
    }
}

// Whoever is past its deadline has failed, unless the host stood still.
void LineJudge::settle_passed(Instant t) {
    if (t <= stood_still_until_ + kAfterStandstill) return;
    for (Transaction& transaction : transactions_)
        if (!transaction.over && t > transaction.deadline) settle(transaction, t);
}

void LineJudge::settle(Transaction& transaction, Instant t) {
    transaction.over = true;
    DeviceState& device = devices_[transaction.device];
    const Duration occupied = std::max(
        std::min(t, transaction.deadline) - transaction.start + arithmetic_.silence(), line_.request_gap);
    // A read whose answer stands among other bytes: what the master shows tells whether it was found.
    const bool unsure = transaction.heard.among_others && transaction.answered() &&
                        !transaction.asked.writes && !transaction.asked.masks;
    transaction.was_dead = device.dead();
    const bool failed = !transaction.answered() || unsure;
    for (const std::size_t r : transaction.requests) {
        RequestState& request = requests_[r];
        const bool meant = r == transaction.requests.front();
        if (failed && meant && transaction.purpose == Purpose::triggered)
            request.edge = request.edge.value_or(transaction.start);
        else if (meant)
            request.retry = failed;
        request.failed_at = std::min(t, transaction.deadline);
        const bool refused = transaction.heard.answer == Answer::exception;
        if (request.busy && !failed && !refused) ++recoveries_["busy_ended"];
        request.busy = refused && (transaction.heard.exception == 5 || transaction.heard.exception == 6);
        if (meant) request.failures = failed ? request.failures + 1 : 0;
        if (meant || failed || refused) request.held = failed || refused;
    }
    settle_writes(transaction);
    const bool odd = transaction.heard.answer == Answer::exception || failed;
    if (failed)
        note_excess(excess_of_failure(transaction, t, occupied));
    else if (transaction.purpose != Purpose::polled && !transaction.expected)
        note_excess({t, occupied, {}});
    if (odd) note_trouble(device, std::max(t, transaction.deadline) + device.model->response_timeout);
    if (transaction.cut) return;
    if (!failed) {
        if (transaction.repeated) ++recoveries_["retried_and_got"];
        if (device.dead()) came_back(transaction.device);
        device.failures = device.probes = 0;
        return;
    }
    const bool others = std::ranges::any_of(transactions_, [&](const Transaction& other) {
        return &other != &transaction && !other.over && other.device == transaction.device;
    });
    if (device.dead() && others) return;
    device.failures = std::min(device.failures + 1, unsigned{device.model->attempts});
    if (!device.dead() || unsure) return;
    const auto& backoff = device.model->backoff.value_or(case_.project.backoff);
    const auto wait =
        std::min(backoff.limit, backoff.first * (std::int64_t{1} << std::min(device.probes, 20U)));
    device.probe_not_before = transaction.end + wait;
    ++device.probes;
}

void LineJudge::came_back(std::size_t index) {
    ++recoveries_["device_came_back"];
    Duration all{};
    for (auto& request : requests_) {
        if (request.plan->device != index) continue;
        request.at_once = true;
        request.retry = request.held = false;
        request.failures = 0;
        all += request.plan->bus_time;
    }
    note_excess({busy_until_, all, {}});
    note_trouble(devices_[index], busy_until_);
}

void LineJudge::note_trouble(DeviceState& device, Instant until) {
    device.clean_from = std::max(device.clean_from, until);
}

LineJudge::Excess LineJudge::excess_of_failure(const Transaction& transaction, Instant t,
                                               Duration occupied) const {
    return {t, std::max(occupied, transaction.failure), transaction.device,
            transaction.failure + devices_[transaction.device].model->response_timeout};
}

void LineJudge::note_excess(const Excess& excess) {
    excess_.push_back(excess);
    while (excess_.front().t < excess.t - kRemembered) excess_.pop_front();
}

Transaction* LineJudge::outstanding(std::uint8_t unit) {
    for (Transaction& transaction : transactions_)
        if (!transaction.over && transaction.asked.unit == unit) return &transaction;
    return nullptr;
}

void LineJudge::on_fault(const sim::FaultEvent& event) {
    using sim::FaultKind;
    const Instant until = event.until.value_or(event.time);
    constexpr Duration kNoise = std::chrono::milliseconds(40);
    if (event.kind == FaultKind::clock_jump) stood_still_until_ = std::max(stood_still_until_, until);
    note_excess({event.time, (event.device ? Duration::zero() : until - event.time) + kNoise, {}});
    // Where nobody can send, nobody answers: back-offs begin.
    const bool babble = event.kind == FaultKind::device_babbles;
    const auto asleep_over = [&](const DeviceState& device) {
        return event.kind == FaultKind::clock_jump &&
               std::ranges::any_of(transactions_, [&](const Transaction& transaction) {
                   return !transaction.over && &devices_[transaction.device] == &device;
               });
    };
    for (auto& device : devices_) {
        if (event.device && !babble && &device != &devices_[*event.device]) continue;
        const auto& backoff = device.model->backoff.value_or(case_.project.backoff);
        note_trouble(device, until + device.model->response_timeout + kNoise +
                                 (babble || asleep_over(device) ? backoff.limit : Duration::zero()));
    }
}

}  // namespace takt::judge
