// Invariant: for each failed request whose response may still come there is one entry, in the order of the
// requests, or all_wait_until_ is not before its limit. An entry matches a frame by unit, function and one of
// two lengths; length 0 matches all.
#include "takt/bus/outstanding_responses.hpp"

#include <algorithm>
#include <ranges>
#include <utility>

#include "takt/bus/transaction_ids.hpp"
#include "takt/wire/function.hpp"

namespace takt::bus {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kLongestTimeout{65535};
constexpr std::chrono::seconds kCheckInterval{1};

// One that is still owed, and then one of the frame's own length only. An entry that looks like several
// responses is left for those whose own entries are gone.
bool precedes(const OutstandingResponse& a, const OutstandingResponse& b) {
    const bool passed = a.phase == OutstandingResponse::Phase::passed;
    if (passed != (b.phase == OutstandingResponse::Phase::passed)) return !passed;
    return a.other_length == a.shape.pdu_length && b.other_length != b.shape.pdu_length;
}

bool same_length(unsigned a, unsigned b) {
    return a == 0 || b == 0 || a == b;
}

}  // namespace

AnswerShape frame_shape(Bytes pdu) {
    const std::size_t length = wire::is_exception(pdu[0]) ? 0 : pdu.size();
    return {wire::requested_function(pdu[0]), static_cast<std::uint16_t>(length)};
}

Duration advised_timeout(Duration delay) {
    constexpr std::int64_t kTenths[] = {10, 15, 20, 30, 40, 50, 60, 80, 100};
    const auto least = std::max<std::int64_t>(std::chrono::ceil<milliseconds>(delay + delay / 5).count(), 1);
    for (std::int64_t decade = 1; decade <= kLongestTimeout.count(); decade *= 10)
        for (const auto tenths : kTenths)
            if (tenths * decade >= 10 * least && (tenths * decade) % 10 == 0)
                return std::min(kLongestTimeout, milliseconds(tenths * decade / 10));
    return kLongestTimeout;
}

bool OutstandingResponse::may_be(UnitId of, const AnswerShape& frame) const {
    return outstanding() && unit == of && shape.function == frame.function &&
           (same_length(shape.pdu_length, frame.pdu_length) || same_length(other_length, frame.pdu_length));
}

Ambiguity OutstandingResponse::ambiguity(Instant t) const {
    switch (phase) {
        case Phase::owed:
            if (t < hold_until) return Ambiguity::held;
            return begun && t >= expected_until ? Ambiguity::begun : Ambiguity::doubted;
        case Phase::suspected: return t < hold_until ? Ambiguity::held : Ambiguity::suspected;
        case Phase::passed: return t < confirm_until || t >= check_at ? Ambiguity::passed : Ambiguity::none;
        case Phase::came: break;
    }
    return Ambiguity::none;
}

bool OutstandingResponses::have_memory() {
    if (memory_.empty() && on_demand_) memory_ = on_demand_->lend();
    return !memory_.empty();
}

void OutstandingResponses::erase(std::size_t index) {
    std::copy(memory_.begin() + static_cast<std::ptrdiff_t>(index) + 1,
              memory_.begin() + static_cast<std::ptrdiff_t>(size_),
              memory_.begin() + static_cast<std::ptrdiff_t>(index));
    --size_;
}

std::optional<std::size_t> OutstandingResponses::oldest(Phase phase, Instant held_until) const {
    for (std::size_t i = 0; i < size_; ++i)
        if (memory_[i].phase == phase && memory_[i].hold_until <= held_until) return i;
    return std::nullopt;
}

void OutstandingResponses::make_room(Instant now) {
    for (const auto phase : {Phase::came, Phase::passed})
        if (const auto index = oldest(phase, kNever)) return erase(*index);
    if (merge()) return;
    for (const auto phase : {Phase::suspected, Phase::owed})
        if (const auto index = oldest(phase, now)) return erase(*index);
    all_wait_until_ = std::max(all_wait_until_, memory_[0].hold_until);
    erase(0);
}

// Two responses of one unit and function become one entry that matches all lengths.
bool OutstandingResponses::merge() {
    for (std::size_t i = 0; i < size_; ++i) {
        auto& first = memory_[i];
        for (std::size_t k = i + 1; k < size_; ++k) {
            const auto& second = memory_[k];
            if (second.unit != first.unit || second.shape.function != first.shape.function) continue;
            if (first.wire_id != 0) continue;
            first.other_length = 0;
            first.begun = first.begun && second.begun;
            first.count =
                static_cast<std::uint16_t>(std::min<unsigned>(first.count + second.count, UINT16_MAX));
            first.hold_until = std::max(first.hold_until, second.hold_until);
            first.hold = std::max(first.hold, second.hold);
            first.expected_until = std::max(first.expected_until, second.expected_until);
            first.confirm_until = std::max(first.confirm_until, second.confirm_until);
            first.forget_at = std::max(first.forget_at, second.forget_at);
            erase(k);
            return true;
        }
    }
    return false;
}

void OutstandingResponses::add(const OutstandingResponse& response) {
    if (!have_memory()) return;
    const auto alike = [&](const OutstandingResponse& other) {
        return other.outstanding() && other.unit == response.unit && other.shape == response.shape;
    };
    const bool full = static_cast<std::size_t>(std::ranges::count_if(all(), alike)) >= kAlike;
    if (full && response.wire_id != 0) {
        erase(static_cast<std::size_t>(std::ranges::find_if(all(), alike) - all().begin()));
    } else if (full) {
        const auto newest = std::ranges::find_if(all() | std::views::reverse, alike);
        const auto [other_length, count] = std::pair(newest->other_length, newest->count);
        const bool begun = newest->begun && response.begun;
        *newest = response;
        newest->begun = begun;
        newest->other_length = other_length;
        newest->count = static_cast<std::uint16_t>(std::min<unsigned>(count + 1U, UINT16_MAX));
        return;
    }
    if (size_ == memory_.size()) make_room(response.expired_at);
    memory_[size_] = response;
    if (response.other_length == 0) memory_[size_].other_length = response.shape.pdu_length;
    ++size_;
}

// The exception was one of the expected responses or that of the current request. Either way as many are
// outstanding as before: the number of entries stays. Of two such exceptions in a row the length is unknown.
void OutstandingResponses::expect_either(UnitId unit, const AnswerShape& current, Instant until) {
    for (auto& entry : all()) {
        if (entry.phase != Phase::owed || entry.unit != unit || entry.shape.function != current.function)
            continue;
        const bool first = entry.other_length == entry.shape.pdu_length;
        entry.other_length = first || entry.other_length == current.pdu_length ? current.pdu_length : 0;
        entry.hold_until = std::max(entry.hold_until, until);
        entry.forget_at = std::max(entry.forget_at, until);
    }
}

void OutstandingResponses::expire(Instant t) {
    const auto kept =
        std::ranges::remove_if(all(), [t](const auto& e) { return e.outstanding() && e.forget_at <= t; });
    size_ -= kept.size();
}

bool OutstandingResponses::expects(std::uint16_t wire_id) const {
    return std::ranges::any_of(
        all(), [&](const auto& e) { return e.outstanding() && easily_confused(e.wire_id, wire_id); });
}

// A unit that does not keep the order may have answered one that has passed instead of `found`. Then `found`,
// for which requests wait, stays.
OutstandingResponse& OutstandingResponses::in_order_or_passed(OutstandingResponse& found,
                                                              const AnswerShape& frame) {
    if (found.in_order || found.wire_id != 0) return found;
    const auto passed = std::ranges::find_if(all(), [&](const auto& entry) {
        return entry.phase == Phase::passed && entry.may_be(found.unit, frame);
    });
    return passed == all().end() ? found : *passed;
}

Lateness OutstandingResponses::settle(UnitId unit, const AnswerShape& shape,
                                      std::optional<std::uint16_t> wire_id, Instant begin, Instant end) {
    OutstandingResponse* found = nullptr;
    Instant last_end = Instant::min();
    for (auto& entry : all()) {
        const bool matches = wire_id ? entry.outstanding() && entry.unit == unit &&
                                           entry.wire_id == *wire_id && entry.shape.function == shape.function
                                     : entry.may_be(unit, shape);
        if (!matches || end >= entry.forget_at) continue;
        last_end = std::max(last_end, entry.end);
        if (!found || precedes(entry, *found)) found = &entry;
    }
    if (!found) return Lateness::none;
    late_by_ = std::max(end - found->expired_at, Duration::zero());
    const bool out_of_order = found->phase == Phase::passed || found->overtaken;
    const Lateness lateness = out_of_order ? Lateness::out_of_order : Lateness::in_order;
    // It may answer any of them: none may be taken for settled.
    if (shape.pdu_length == 0 && !wire_id && !one_length(unit, shape.function)) return lateness;
    const Duration delay = std::max(begin - found->end, Duration::zero());
    const bool overtakes = !wire_id && shape.pdu_length != 0;
    for (auto& entry : all()) {
        if (!entry.outstanding() || entry.unit != unit) continue;
        entry.end = std::max(entry.end, end);
        const bool expected = end < std::max(entry.expected_until, entry.confirm_until);
        if (entry.phase == Phase::suspected || (out_of_order && expected)) entry.phase = Phase::owed;
        if (overtakes && &entry < found && !entry.may_be(unit, shape)) entry.overtaken = true;
    }
    OutstandingResponse came = *found;
    came.phase = Phase::came;
    came.delay = delay;
    came.least_delay = std::max(begin - last_end, Duration::zero());
    came.came_at = end;
    came.out_of_order = out_of_order;
    OutstandingResponse& settled = in_order_or_passed(*found, shape);
    if (--settled.count == 0) {
        settled = came;
        return lateness;
    }
    // Its unit is in doubt until take_late() has given it: one that hardly comes is forgotten before that.
    if (size_ == memory_.size())
        if (const auto passed = oldest(Phase::passed, kNever)) erase(*passed);
    if (size_ < memory_.size()) memory_[size_++] = came;
    return lateness;
}

void OutstandingResponses::answered(Instant t, UnitId unit, const std::optional<AnswerShape>& shape) {
    for (auto& entry : all()) {
        if (!entry.outstanding() || entry.unit != unit) continue;
        if (shape && entry.may_be(unit, *shape)) continue;
        entry.phase = Phase::passed;
        entry.check_at = t + kCheckInterval;
    }
}

void OutstandingResponses::confirmed(Instant t, UnitId unit, const AnswerShape& shape, Instant request_end,
                                     bool in_doubt) {
    for (auto& entry : all()) {
        if (!entry.may_be(unit, shape)) continue;
        entry.check_at = t + kCheckInterval;
        if (entry.phase == Phase::passed) {
            if (in_doubt)
                entry.confirm_until = std::max(entry.confirm_until, t + confirmation_time(entry.wait));
            continue;
        }
        entry.end = request_end;
        // One length does not show that the response of another one was lost.
        const bool one_length = entry.other_length == entry.shape.pdu_length;
        const Instant certain =
            one_length ? entry.expected_until : std::max(entry.expected_until, entry.confirm_until);
        if ((entry.phase == Phase::suspected || entry.begun) && t >= certain) {
            entry.phase = Phase::passed;
        } else {
            entry.phase = Phase::suspected;
            entry.hold_until = std::max(entry.hold_until, t + entry.hold);
        }
    }
}

bool OutstandingResponses::one_length(UnitId unit, std::uint8_t function) const {
    std::optional<std::size_t> length;
    for (const auto& entry : all()) {
        if (!entry.may_be(unit, {function, 0})) continue;
        if (length && *length != entry.shape.pdu_length) return false;
        length = entry.shape.pdu_length;
    }
    return true;
}

bool OutstandingResponses::ambiguous(UnitId unit, std::uint8_t function) const {
    return std::ranges::any_of(all(), [&](const auto& e) {
        return e.phase == Phase::owed && e.unit == unit && e.shape.function == function;
    });
}

Ambiguity OutstandingResponses::ambiguity(Instant t, UnitId unit, const AnswerShape& shape) const {
    auto worst = t < all_wait_until_ ? Ambiguity::held : Ambiguity::none;
    for (const auto& entry : all()) {
        if (!entry.may_be(unit, shape)) continue;
        worst = std::max(worst, entry.ambiguity(t));
    }
    return worst;
}

bool OutstandingResponses::remembers(UnitId unit, const AnswerShape& shape) const {
    return std::ranges::any_of(all(), [&](const auto& entry) { return entry.may_be(unit, shape); });
}

bool OutstandingResponses::doubtful(Instant t, UnitId unit, const AnswerShape& shape) const {
    const bool dead = silent(t, unit);
    return std::ranges::any_of(
        all(), [&](const auto& entry) { return (dead || entry.misdirected) && entry.may_be(unit, shape); });
}

// `end` is not before the last answer of the unit: of a unit that answers late it is the same in all entries
// but the newest.
bool OutstandingResponses::silent(Instant t, UnitId unit) const {
    const auto owed = [&](const auto& entry) { return entry.phase == Phase::owed && entry.unit == unit; };
    const auto first = std::ranges::find_if(all(), owed);
    if (first == all().end() || t < first->expected_until || t < first->confirm_until) return false;
    std::size_t later = 0;
    for (const auto& entry : all())
        if (owed(entry) && entry.end > first->end) ++later;
    return later + 1 >= kAlike;
}

bool OutstandingResponses::remembers(UnitId unit) const {
    return std::ranges::any_of(all(),
                               [&](const auto& entry) { return entry.outstanding() && entry.unit == unit; });
}

Instant OutstandingResponses::earliest(UnitId unit, const AnswerShape& shape) const {
    Instant earliest = all_wait_until_;
    for (const auto& entry : all())
        if (entry.phase != Phase::passed && entry.may_be(unit, shape))
            earliest = std::max(earliest, entry.hold_until);
        else if (entry.phase == Phase::owed && entry.unit == unit)
            earliest = std::max(earliest, entry.patient_until);
    return earliest;
}

std::optional<LateResponse> OutstandingResponses::take_late() {
    const auto found =
        std::ranges::find_if(all(), [](const auto& entry) { return entry.phase == Phase::came; });
    if (found == all().end()) return std::nullopt;
    const LateResponse late{
        .unit = found->unit,
        .shape = found->shape,
        .at = found->came_at,
        .delay = found->delay,
        .wait = found->wait,
        .least_delay = found->least_delay,
        .out_of_order_since = found->out_of_order ? std::optional(found->expired_at) : std::nullopt};
    erase(static_cast<std::size_t>(found - all().begin()));
    return late;
}

void OutstandingResponses::clear() {
    size_ = 0;
    all_wait_until_ = Instant::min();
}

void OutstandingResponses::take_over(const OutstandingResponses& other) {
    const std::size_t capacity = other.size_ > 0 && have_memory() ? memory_.size() : 0;
    const auto newest = other.all().last(std::min(other.size_, capacity));
    size_ = newest.size();
    std::ranges::copy(newest, memory_.begin());
    all_wait_until_ = other.all_wait_until_;
}

}  // namespace takt::bus
