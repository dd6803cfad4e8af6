#include "ledger.hpp"

#include <algorithm>
#include <utility>

namespace takt::judge {
namespace {

constexpr std::size_t kMostOwed = 4096;
constexpr std::size_t kMostBytes = 600;  // longer than any frame
constexpr std::size_t kLeastRtu = 4;
constexpr std::size_t kDelays = 8;
constexpr std::size_t kLateOnes = 3;
constexpr Duration kSilence = std::chrono::milliseconds(50);  // that ends bytes without a frame for a master
constexpr Duration kLedgerPause = std::chrono::milliseconds(5);  // between two frames, or pieces of one
constexpr std::size_t kMostRefused = 64;
constexpr unsigned kMostOthers = 3;                  // requests between two exempt answers of one shift
constexpr Duration kHeld = std::chrono::minutes(1);  // the longest that a request may wait and be held

Duration median(const std::deque<Duration>& values) {
    auto sorted = values;
    std::ranges::sort(sorted);
    return sorted[sorted.size() / 2];
}

// FNV-1a, 64 bits.
std::uint64_t hash_of(std::uint8_t unit, const ByteVector& pdu) {
    std::uint64_t hash = 0xCBF29CE484222325 ^ unit;
    for (const auto byte : pdu) hash = (hash ^ byte) * 0x100000001B3;
    return hash;
}

}  // namespace

AnswerLedger::Owed AnswerLedger::owed(Instant t, const Asked& asked) {
    Owed made{.t = t, .unit = asked.unit, .function = asked.function, .length = asked.normal_answer};
    if (!asked.reads)
        made.echo.assign(asked.pdu.begin(), asked.pdu.begin() + static_cast<std::ptrdiff_t>(made.length));
    return made;
}

bool AnswerLedger::matches(const Owed& owed, const FoundFrame& frame) {
    return owed.unit == frame.unit && owed.function == frame.pdu[0] && owed.length == frame.pdu.size() &&
           (owed.echo.empty() || owed.echo == frame.pdu);
}

bool AnswerLedger::same_shape(const Owed& a, const Owed& b) {
    return a.unit == b.unit && a.function == b.function && a.length == b.length && a.echo == b.echo;
}

AnswerLedger::AnswerLedger(wire::Framing framing) : framing_(framing), crc_since_(crc({})) {}

const AnswerLedger::Unit& AnswerLedger::unit(std::uint8_t number) const {
    static const Unit kUnknown;
    const auto found = units_.find(number);
    return found == units_.end() ? kUnknown : found->second;
}

void AnswerLedger::on_connection(Instant t) {
    if (framing_ == wire::Framing::tcp) return;
    settle_last(t);
    for (auto& [number, unit] : units_) {
        for (Owed& each : unit.owed)
            if (!each.answered) settle(unit, each, true);
        unit.shifted.reset();
        unit.refused.clear();
    }
    bytes_.clear();
    forget_since();
    heard_.clear();
    strays_.clear();
}

void AnswerLedger::on_sent(Instant t, const Asked& asked) {
    if (framing_ == wire::Framing::tcp || asked.unit == 0) return;  // the transaction id tells them apart
    const Owed next = owed(t, asked);
    settle_last(t);
    settle_suspected(t, next);
    heard_.clear();
    strays_.clear();
    forget_since();
    received_ = 0;
    damaged_ = paused_ = false;
    Unit& unit = units_[asked.unit];
    std::erase_if(unit.owed, [](const Owed& each) { return each.answered && !each.may_follow; });
    while (!unit.owed.empty() && t - unit.owed.front().t > 2 * kForgotten) unit.owed.pop_front();
    if (unit.shifted) {
        ++unit.shifted->others;
        if (!same_shape(unit.shifted->request, next)) unit.shifted.reset();
    }
    Run& run = unit.run;
    if (!same_shape(run.request, next))
        run = {.request = next, .since = t, .before = run.request.length == 0 ? t : run.since};
    unit.owed.push_back(next);
    unit.owed.back().number = ++last_number_;
    if (unit.owed.size() > kMostOwed) unit.owed.pop_front();
    last_ = &unit;
}

void AnswerLedger::forget_since() {
    since_.clear();
    crc_since_ = crc({});
}

void AnswerLedger::on_heard(Instant t, std::span<const std::uint8_t> bytes) {
    if (framing_ == wire::Framing::tcp) return;
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    received_ += bytes.size();
    if (t > heard_at_ + kLedgerPause) {
        paused_ = paused_ || received_ > bytes.size();
        forget_since();
    }
    heard_at_ = t;
    if (since_.size() < 2 * kMostBytes) {
        since_.insert(since_.end(), bytes.begin(), bytes.end());
        crc_since_ = crc(bytes, crc_since_);
        damaged_ = damaged_ || (last_ && begins_like_last(bytes.size()));
    }
    std::size_t parsed = 0;
    std::size_t end = 0;
    for (const FoundFrame& frame : find_frames(framing_, bytes_, parsed)) {
        const std::size_t begin = frame.end - frame_characters(framing_, frame.pdu.size());
        const bool behind_others = begin > std::exchange(end, frame.end) && t < after(left_at_, kSilence);
        take(t, frame, behind_others);
    }
    // An RTU frame whose function fixes no length ends with the pause. A CRC over a frame with its CRC is 0.
    if (end == 0 && framing_ == wire::Framing::rtu && since_.size() >= kLeastRtu && crc_since_ == 0)
        units_[since_[0]].surplus_at = t;
    parsed = std::max(parsed, bytes_.size() - std::min(bytes_.size(), kMostBytes));
    bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(parsed));
    if (!bytes_.empty()) left_at_ = t;
}

// A frame that can be the answer to the last request waits for settle_last().
// @param behind_others  other bytes came directly before it: the master may have missed it
void AnswerLedger::take(Instant t, const FoundFrame& frame, bool behind_others) {
    heard_.push_back({t, frame.unit, frame.pdu});
    past_.add(hash_of(frame.unit, frame.pdu));
    if (!last_) return;
    const Owed& request = last();
    if (!matches(request, frame) || frames_for(request) > 1) units_[frame.unit].surplus_at = t;
    if (matches(request, frame)) return take_strays(true);
    if ((frame.pdu[0] & 0x80U) != 0) return take_exception(t, frame);
    const bool may_be_own = request.unit == frame.unit && request.function == frame.pdu[0];
    if (may_be_own && !frames_for(request))
        strays_.push_back({t, frame.unit, frame.pdu});
    else
        take_late(t, frame, !behind_others, request.unit == frame.unit && last_is_answered(t));
}

// If the own answer has come too, each of them was a late one, else perhaps the own one with a wrong length.
void AnswerLedger::take_strays(bool own_came) {
    for (const Heard& each : std::exchange(strays_, {}))
        take_late(each.t, {0, each.unit, each.pdu}, own_came, false);
}

// @param overtaken  its unit had answered the last request before
void AnswerLedger::take_late(Instant t, const FoundFrame& frame, bool certain, bool overtaken) {
    Unit& unit = units_[frame.unit];
    Owed* found = nullptr;
    for (Owed& each : unit.owed)
        if (!each.answered && matches(each, frame) &&
            (!found || unit.has_passed(*found, t)))  // the first that has not passed, else the last
            found = &each;
    if (!found) return;
    overtaken = overtaken || found->overtaken;
    const bool lost = found->unfollowed >= kLost;
    const bool doubtful = !certain || seen_before(frame.unit, frame.pdu);
    settle(unit, *found, doubtful);
    settle_refused(unit);
    unit.note_late(*found, t);
    if (overtaken && !lost && !doubtful) unit.reordered = true;
}

void AnswerLedger::take_exception(Instant t, const FoundFrame& frame) {
    Unit& unit = units_[frame.unit];
    std::vector<std::uint64_t> may_be;
    bool refuses_another = false;  // perhaps
    Owed* found = nullptr;
    for (Owed& each : unit.owed) {
        if (each.answered || (each.function | 0x80U) != frame.pdu[0]) continue;
        if (unit.has_passed(each, t) && each.number != last_number_) {
            refuses_another = true;
            continue;
        }
        may_be.push_back(each.number);
        found = &each;
    }
    if (may_be.size() > 1) {
        if (unit.refused.size() == kMostRefused) unit.refused.pop_front();
        unit.refused.push_back(std::move(may_be));
        return;
    }
    if (!found) return;
    const bool is_last = found->number == last_number_;
    settle(unit, *found, is_last && (refuses_another || seen_before(frame.unit, frame.pdu)));
    if (is_last) pass_others(unit, *found);
    unit.note_late(*found, t);
}

// What came may be something else than the answer: a copy, another late one, damaged bytes. The last such
// request of a shape stands for all.
void AnswerLedger::settle(Unit& unit, Owed& request, bool doubtful) {
    request.answered = true;
    if (!doubtful) return;
    for (Owed& each : unit.owed)
        if (same_shape(each, request)) each.may_follow = false;
    request.may_follow = true;
}

void AnswerLedger::settle_refused(Unit& unit) {
    const auto find = [&](std::uint64_t number) {
        const auto each = std::ranges::lower_bound(unit.owed, number, {}, &Owed::number);
        return each != unit.owed.end() && each->number == number && !each->answered ? each : unit.owed.end();
    };
    bool again = true;
    while (std::exchange(again, false))
        for (auto& requests : unit.refused) {
            std::erase_if(requests, [&](std::uint64_t number) { return find(number) == unit.owed.end(); });
            if (requests.size() != 1) continue;
            find(requests.front())->answered = true;
            requests.clear();
            again = true;
        }
    std::erase_if(unit.refused, [](const auto& requests) { return requests.empty(); });
}

std::size_t AnswerLedger::frames_for(const Owed& request) const {
    return static_cast<std::size_t>(std::ranges::count_if(
        heard_, [&](const Heard& each) { return matches(request, {0, each.unit, each.pdu}); }));
}

// By one frame, and no other answer of its shape is owed.
bool AnswerLedger::last_is_answered(Instant t) const {
    const Owed& request = last();
    const auto& owed = last_->owed;
    return frames_for(request) == 1 && std::none_of(owed.begin(), owed.end() - 1, [&](const Owed& each) {
               return !each.answered && same_shape(each, request) && !last_->has_passed(each, t);
           });
}

// The last frame of the shape of the last request counts as its answer, the others as those owed before.
void AnswerLedger::settle_last(Instant t) {
    if (!last_) return;
    Unit& unit = *last_;
    Owed& request = last();
    std::size_t came = 0;
    Instant last_came;
    for (const Heard& each : heard_) {
        if (!matches(request, {0, each.unit, each.pdu})) continue;
        ++came;
        last_came = each.t;
    }
    remember(t, request, came);
    if (came == 0) {
        const bool other =
            std::ranges::any_of(heard_, [&](const Heard& e) { return e.unit == request.unit; });
        if (!request.answered && damaged_ && !other) {
            settle(unit, request, true);  // a copy of it may come
            request.damaged = true;
        }
        take_strays(false);
        return settle_refused(unit);
    }
    const bool undoubted = last_is_answered(t);
    const bool several = came > 1;
    const bool copies = seen_before(request);
    settle(unit, request, copies && !several);
    for (const bool gone : {false, true})
        for (Owed& each : unit.owed)
            if (came > 1 && !each.answered && same_shape(each, request) && unit.has_passed(each, t) == gone) {
                settle(unit, each, copies);
                unit.note_late(each, last_came);
                --came;
            }
    settle_refused(unit);
    for (Owed& each : unit.owed)
        if (!each.answered && same_shape(each, request)) {
            each.suspected_at = last_came;
            unit.suspects = true;
        }
    if (several) return unit.shifted.reset();
    unit.note_delay(last_came - request.t);
    if (undoubted) pass_others(unit, request);
}

// Its unit has answered it: answers to earlier requests of other shapes come no more, if it answers in order.
void AnswerLedger::pass_others(Unit& unit, const Owed& answered) {
    for (Owed& each : unit.owed)
        if (!each.answered && !same_shape(each, answered)) each.overtaken = true;
}

// Bytes that begin like the answer to the last request, or like an exception, and are as many, with a wrong
// checksum.
// @param added  the last bytes, which were not looked through yet
bool AnswerLedger::begins_like_last(std::size_t added) const {
    constexpr std::size_t kExceptionBytes = 2;
    const Owed& request = last();
    const auto exception = static_cast<std::uint8_t>(request.function | 0x80U);
    return begins_like({request.unit, request.function}, frame_characters(framing_, request.length), added) ||
           begins_like({request.unit, exception}, frame_characters(framing_, kExceptionBytes), added);
}

// @param length  of the whole frame on the line
bool AnswerLedger::begins_like(ByteVector begin, std::size_t length, std::size_t added) const {
    if (since_.size() < length) return false;
    if (framing_ == wire::Framing::ascii) {
        constexpr std::string_view kDigits = "0123456789ABCDEF";
        ByteVector characters{':'};
        for (const unsigned byte : begin) {
            characters.push_back(static_cast<std::uint8_t>(kDigits[byte >> 4U]));
            characters.push_back(static_cast<std::uint8_t>(kDigits[byte & 15U]));
        }
        begin = characters;
    }
    const std::size_t ends = since_.size() - length + 1;  // of possible beginnings
    const auto first = since_.begin() + static_cast<std::ptrdiff_t>(ends - std::min(ends, added));
    const auto last = since_.begin() + static_cast<std::ptrdiff_t>(ends - 1 + begin.size());
    return std::search(first, last, begin.begin(), begin.end()) != last;
}

bool AnswerLedger::seen_before(std::uint8_t unit, const ByteVector& pdu) const {
    return past_.count(hash_of(unit, pdu)) > 1;
}

// A copy of an earlier frame instead of its answer, which may follow.
bool AnswerLedger::seen_before(const Owed& request) const {
    return std::ranges::any_of(heard_, [&](const Heard& each) {
        return matches(request, {0, each.unit, each.pdu}) && seen_before(each.unit, each.pdu);
    });
}

void AnswerLedger::note_exempt(Instant t, const Asked& asked) {
    auto& shifted = units_[asked.unit].shifted;
    if (!shifted) shifted = Shift{owed(t, asked), t};
    if (shifted->others >= kMostOthers) shifted->since = t;
    shifted->others = 0;
}

// ---- what is known of a unit

bool AnswerLedger::Unit::has_passed(const Owed& each, Instant t) const {
    if (each.passed(!reordered)) return true;
    return (each.overtaken || each.unfollowed > 0) && t - each.t > expected;
}

void AnswerLedger::Unit::note_delay(Duration delay) {
    delays.push_back(delay);
    if (delays.size() > kDelays) delays.pop_front();
    usual_delay = median(delays);
    compute_expected();
}

// From its request, or from the late answer of the unit before it.
void AnswerLedger::Unit::note_late(const Owed& answered, Instant t) {
    const Duration delay = t - std::max(answered.t, std::exchange(late_at, t));
    lateness = std::max(lateness, delay);
    late_delays.push_back(delay);
    if (late_delays.size() > kLateOnes) late_delays.pop_front();
    compute_expected();
}

void AnswerLedger::Unit::compute_expected() {
    constexpr int kFactor = 2;
    expected = kConfirmed * usual_delay;
    if (late_delays.size() == kLateOnes) expected = std::max(expected, kFactor * median(late_delays));
}

Duration AnswerLedger::lateness(std::uint8_t number) const {
    return unit(number).lateness;
}

void AnswerLedger::settle_suspected(Instant t, const Owed& next) {
    for (auto& [number, unit] : units_) {
        if (!std::exchange(unit.suspects, false)) continue;
        for (Owed& each : unit.owed) {
            if (!each.suspected_at) continue;
            const bool unfollowed = t - *each.suspected_at >= unit.usual_delay;
            each.unfollowed += unfollowed;
            if (unfollowed || same_shape(each, next)) each.suspected_at.reset();
            unit.suspects = unit.suspects || each.suspected_at.has_value();
        }
    }
}

// The master may have missed an answer in pieces or among other bytes.
void AnswerLedger::remember(Instant t, const Owed& request, std::size_t came) {
    const bool clear = came == 1 && !paused_ && received_ == frame_characters(framing_, request.length);
    const Shape shape{request.unit, request.function, request.length};
    const auto known = doubts_.find(shape);
    if (clear && known == doubts_.end()) return;
    Doubt& doubt = known == doubts_.end() ? doubts_[shape] : known->second;
    doubt.several = came > 1;
    if (!clear) doubt.until = t + kForgotten + kHeld;
}

bool AnswerLedger::in_doubt(Instant t, const Shape& shape) const {
    for (auto each = doubts_.lower_bound({shape.unit, shape.function, 0});
         each != doubts_.end() && each->first.unit == shape.unit; ++each) {
        if (shape.function != 0 && each->first.function != shape.function) break;
        if (shape.length != 0 && each->first.length != shape.length) continue;
        if (each->second.several || t < each->second.until) return true;
    }
    return false;
}

bool AnswerLedger::may_check(Instant t, std::uint8_t number) const {
    const Unit& its = unit(number);
    if (its.surplus_at && t - *its.surplus_at < kForgotten) return true;
    return its.run.request.length != 0 && its.run.since == t && t - its.run.before >= kCheck;
}

bool AnswerLedger::doubtful(const Asked& asked) const {
    if (!last_) return false;
    if (candidates(asked).size() > 1) return true;
    const Owed own = owed({}, asked);
    return std::ranges::any_of(unit(own.unit).owed, [&](const Owed& each) {
        return each.number != last_number_ && (!each.answered || each.damaged) &&
               each.function == own.function && (each.length == own.length || !own.echo.empty());
    });
}

std::vector<ByteVector> AnswerLedger::candidates(const Asked& asked) const {
    const Owed own = owed({}, asked);
    std::vector<ByteVector> found;
    for (const Heard& each : heard_)
        if (matches(own, {0, each.unit, each.pdu})) found.push_back(each.pdu);
    return found;
}

std::optional<Instant> AnswerLedger::last_candidate(const Asked& asked) const {
    const Owed own = owed({}, asked);
    std::optional<Instant> last;
    for (const Heard& each : heard_)
        if (matches(own, {0, each.unit, each.pdu})) last = each.t;
    return last;
}

std::optional<std::string_view> AnswerLedger::exemption(Instant t, Instant sent, const Asked& asked,
                                                        const ByteVector& published) const {
    const auto came = candidates(asked);
    if (std::ranges::find(came, published) == came.end()) return std::nullopt;
    const Owed own = owed(sent, asked);
    const Unit& its = unit(own.unit);
    const bool one_behind = its.shifted && same_shape(its.shifted->request, own) && came.size() == 1;
    if (one_behind && its.shifted->others < kMostOthers && t - its.shifted->since > kShifted)
        return std::nullopt;
    const bool unfollowed = t - last_candidate(asked).value_or(t) >= its.usual_delay;
    std::size_t open = 0;
    bool passed = false;
    bool expired = false;
    for (const Owed& each : its.owed) {
        if (!same_shape(each, own) || each.t >= sent) continue;
        if (each.answered)
            passed = passed || each.may_follow;
        else if (t - each.t > kForgotten)
            expired = true;
        else if (its.has_passed(each, t) || (each.unfollowed == 1 && unfollowed))
            passed = true;
        else
            ++open;
    }
    if ((open > 0 || passed) && came.back() != published) return std::nullopt;
    if (open > 0) {
        const bool all_and_last = came.size() > open && !its.reordered;
        return all_and_last ? std::optional<std::string_view>("exempt_reordered") : std::nullopt;
    }
    if (passed) return "exempt_passed";
    if (expired) return "exempt_expired";
    const auto heard_before = past_.count(hash_of(own.unit, published));
    const auto heard_now = static_cast<std::size_t>(std::ranges::count(came, published));
    if (heard_before > heard_now) return "exempt_copy";
    return one_behind ? std::optional<std::string_view>("exempt_shifted") : std::nullopt;
}

std::string AnswerLedger::describe(Instant t, Instant sent, const Asked& asked) const {
    const Owed own = owed(sent, asked);
    std::string text;
    const Unit& its = unit(own.unit);
    for (const Owed& each : its.owed) {
        if ((each.answered && !each.may_follow) || !same_shape(each, own) || each.t >= sent) continue;
        text += text.empty() ? "; an answer of its shape is owed since " : ", ";
        text += std::to_string((t - each.t) / std::chrono::milliseconds(1)) + " ms";
        if (each.answered || its.has_passed(each, t)) text += " (passed)";
    }
    if (its.reordered) text += "; the unit has answered out of order";
    return text;
}

}  // namespace takt::judge
