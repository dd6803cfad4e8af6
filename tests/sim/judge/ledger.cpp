#include "ledger.hpp"

#include <algorithm>
#include <utility>

namespace takt::judge {
namespace {

constexpr std::size_t kMostOwed = 4096;
constexpr std::size_t kMostBytes = 600;  // longer than any frame
constexpr std::size_t kDelays = 8;
constexpr std::size_t kLateOnes = 3;
constexpr Duration kSilence = std::chrono::milliseconds(50);  // that ends bytes without a frame for a master
constexpr Duration kLedgerPause = std::chrono::milliseconds(5);  // between two frames, or pieces of one
constexpr std::size_t kMostRefused = 64;
constexpr std::size_t kPast = 16384;  // frames of minutes
constexpr Duration kUnknownDelay = std::chrono::milliseconds(100);
constexpr unsigned kMostOthers = 3;                  // requests between two exempt answers of one shift
constexpr Duration kHeld = std::chrono::minutes(1);  // the longest that a request may wait and be held

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

AnswerLedger::AnswerLedger(wire::Framing framing) : framing_(framing) {
    if (framing != wire::Framing::tcp) past_.reserve(kPast);
}

void AnswerLedger::on_connection(Instant t) {
    if (framing_ == wire::Framing::tcp) return;
    settle_last(t);
    for (Owed& each : owed_)
        if (!each.answered) settle(each, true);
    shifted_.clear();
    bytes_.clear();
    since_.clear();
    refused_.clear();
    heard_.clear();
    strays_.clear();
}

void AnswerLedger::on_sent(Instant t, const Asked& asked) {
    if (framing_ == wire::Framing::tcp || asked.unit == 0) return;  // the transaction id tells them apart
    settle_last(t);
    settle_suspected(t, owed(t, asked));
    heard_.clear();
    strays_.clear();
    since_.clear();
    received_ = 0;
    damaged_ = paused_ = false;
    std::erase_if(owed_, [](const Owed& each) { return each.answered && !each.may_follow; });
    while (!owed_.empty() && t - owed_.front().t > 2 * kForgotten) owed_.pop_front();
    const auto shifted = shifted_.find(asked.unit);
    if (shifted != shifted_.end()) {
        ++shifted->second.others;
        if (!same_shape(shifted->second.request, owed(t, asked))) shifted_.erase(shifted);
    }
    Run& run = runs_[asked.unit];
    if (!same_shape(run.request, owed(t, asked)))
        run = {.request = owed(t, asked), .since = t, .before = run.request.length == 0 ? t : run.since};
    owed_.push_back(owed(t, asked));
    owed_.back().number = ++last_number_;
    if (owed_.size() > kMostOwed) owed_.pop_front();
}

void AnswerLedger::on_heard(Instant t, std::span<const std::uint8_t> bytes) {
    if (framing_ == wire::Framing::tcp) return;
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    received_ += bytes.size();
    if (t > heard_at_ + kLedgerPause) {
        paused_ = paused_ || received_ > bytes.size();
        since_.clear();
    }
    heard_at_ = t;
    if (since_.size() < 2 * kMostBytes) since_.insert(since_.end(), bytes.begin(), bytes.end());
    damaged_ = damaged_ || (!owed_.empty() && begins_like_last());
    std::size_t parsed = 0;
    std::size_t end = 0;
    for (const FoundFrame& frame : find_frames(framing_, bytes_, parsed)) {
        const std::size_t begin = frame.end - frame_characters(framing_, frame.pdu.size());
        const bool behind_others = begin > std::exchange(end, frame.end) && t < after(left_at_, kSilence);
        take(t, frame, behind_others);
    }
    if (end == 0 && is_of_unknown_length()) surplus_at_[since_[0]] = t;
    parsed = std::max(parsed, bytes_.size() - std::min(bytes_.size(), kMostBytes));
    bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(parsed));
    if (!bytes_.empty()) left_at_ = t;
}

// An RTU frame whose function fixes no length ends with the pause.
bool AnswerLedger::is_of_unknown_length() const {
    constexpr std::size_t kLeast = 4;
    if (framing_ != wire::Framing::rtu || since_.size() < kLeast) return false;
    const auto end = since_.end() - 2;
    return crc(ByteVector(since_.begin(), end)) == (end[0] | end[1] << 8);
}

// A frame that can be the answer to the last request waits for settle_last().
// @param behind_others  other bytes came directly before it: the master may have missed it
void AnswerLedger::take(Instant t, const FoundFrame& frame, bool behind_others) {
    heard_.push_back({t, frame.unit, frame.pdu});
    if (past_.size() < kPast)
        past_.push_back(hash_of(frame.unit, frame.pdu));
    else
        past_[next_past_++ % kPast] = hash_of(frame.unit, frame.pdu);
    if (owed_.empty()) return;
    const Owed& last = owed_.back();
    if (!matches(last, frame) || frames_for(last) > 1) surplus_at_[frame.unit] = t;
    if (matches(last, frame)) return take_strays(true);
    if ((frame.pdu[0] & 0x80U) != 0) return take_exception(t, frame);
    const bool may_be_own = last.unit == frame.unit && last.function == frame.pdu[0];
    if (may_be_own && !frames_for(last))
        strays_.push_back({t, frame.unit, frame.pdu});
    else
        take_late(t, frame, !behind_others, last.unit == frame.unit && last_is_answered(t));
}

// If the own answer has come too, each of them was a late one, else perhaps the own one with a wrong length.
void AnswerLedger::take_strays(bool own_came) {
    for (const Heard& each : std::exchange(strays_, {}))
        take_late(each.t, {0, each.unit, each.pdu}, own_came, false);
}

// @param overtaken  its unit had answered the last request before
void AnswerLedger::take_late(Instant t, const FoundFrame& frame, bool certain, bool overtaken) {
    Owed* found = nullptr;
    for (Owed& each : owed_)
        if (!each.answered && matches(each, frame) &&
            (!found || has_passed(*found, t)))  // the first that has not passed, else the last
            found = &each;
    if (!found) return;
    overtaken = overtaken || found->overtaken;
    const bool lost = found->unfollowed >= kLost;
    const bool doubtful = !certain || seen_before(frame.unit, frame.pdu);
    settle(*found, doubtful);
    settle_refused();
    note_late(*found, t);
    if (overtaken && !lost && !doubtful) reordered_[frame.unit / 64] |= std::uint64_t{1} << (frame.unit % 64);
}

// From its request, or from the late answer of the unit before it.
void AnswerLedger::note_late(const Owed& answered, Instant t) {
    const Instant before = std::exchange(late_at_[answered.unit], t);
    const Duration delay = t - std::max(answered.t, before);
    lateness_[answered.unit] = std::max(lateness_[answered.unit], delay);
    auto& last = last_late_[answered.unit];
    last.push_back(delay);
    if (last.size() > kLateOnes) last.pop_front();
}

void AnswerLedger::take_exception(Instant t, const FoundFrame& frame) {
    std::vector<std::uint64_t> may_be;
    bool refuses_another = false;  // perhaps
    Owed* found = nullptr;
    for (Owed& each : owed_) {
        if (each.answered || each.unit != frame.unit || (each.function | 0x80U) != frame.pdu[0]) continue;
        if (has_passed(each, t) && each.number != last_number_) {
            refuses_another = true;
            continue;
        }
        may_be.push_back(each.number);
        found = &each;
    }
    if (may_be.size() > 1) {
        if (refused_.size() == kMostRefused) refused_.pop_front();
        refused_.push_back(std::move(may_be));
    }
    if (!found || found->answered || may_be.size() != 1) return;
    const bool last = found == &owed_.back();
    settle(*found, last && (refuses_another || seen_before(frame.unit, frame.pdu)));
    if (last) pass_others(*found);
    note_late(*found, t);
}

// What came may be something else than the answer: a copy, another late one, damaged bytes. The last such
// request of a shape stands for all.
void AnswerLedger::settle(Owed& request, bool doubtful) {
    request.answered = true;
    if (!doubtful) return;
    for (Owed& each : owed_)
        if (same_shape(each, request)) each.may_follow = false;
    request.may_follow = true;
}

void AnswerLedger::settle_refused() {
    const auto find = [&](std::uint64_t number) {
        const auto each = std::ranges::lower_bound(owed_, number, {}, &Owed::number);
        return each != owed_.end() && each->number == number && !each->answered ? each : owed_.end();
    };
    bool again = true;
    while (std::exchange(again, false))
        for (auto& requests : refused_) {
            std::erase_if(requests, [&](std::uint64_t number) { return find(number) == owed_.end(); });
            if (requests.size() != 1) continue;
            find(requests.front())->answered = true;
            requests.clear();
            again = true;
        }
    std::erase_if(refused_, [](const auto& requests) { return requests.empty(); });
}

std::size_t AnswerLedger::frames_for(const Owed& request) const {
    return static_cast<std::size_t>(std::ranges::count_if(
        heard_, [&](const Heard& each) { return matches(request, {0, each.unit, each.pdu}); }));
}

// By one frame, and no other answer of its shape is owed.
bool AnswerLedger::last_is_answered(Instant t) const {
    const Owed& last = owed_.back();
    return frames_for(last) == 1 && std::none_of(owed_.begin(), owed_.end() - 1, [&](const Owed& each) {
               return !each.answered && same_shape(each, last) && !has_passed(each, t);
           });
}

// The last frame of the shape of the last request counts as its answer, the others as those owed before.
void AnswerLedger::settle_last(Instant t) {
    if (owed_.empty()) return;
    Owed& last = owed_.back();
    std::size_t came = 0;
    Instant last_came;
    for (const Heard& each : heard_) {
        if (!matches(last, {0, each.unit, each.pdu})) continue;
        ++came;
        last_came = each.t;
    }
    remember(t, last, came);
    if (came == 0) {
        const bool other = std::ranges::any_of(heard_, [&](const Heard& e) { return e.unit == last.unit; });
        if (!last.answered && damaged_ && !other) {
            settle(last, true);  // a copy of it may come
            last.damaged = true;
        }
        take_strays(false);
        return settle_refused();
    }
    const bool undoubted = last_is_answered(t);
    const bool several = came > 1;
    const bool copies = seen_before(last);
    settle(last, copies && !several);
    for (const bool gone : {false, true})
        for (Owed& each : owed_)
            if (came > 1 && !each.answered && has_passed(each, t) == gone && same_shape(each, last)) {
                settle(each, copies);
                note_late(each, last_came);
                --came;
            }
    settle_refused();
    for (Owed& each : owed_)
        if (!each.answered && same_shape(each, last)) each.suspected_at = last_came;
    if (several) {
        shifted_.erase(last.unit);
        return;
    }
    auto& delays = delays_[last.unit];
    delays.push_back(last_came - last.t);
    if (delays.size() > kDelays) delays.pop_front();
    if (undoubted) pass_others(last);
}

// Its unit has answered it: answers to earlier requests of other shapes come no more, if it answers in order.
void AnswerLedger::pass_others(const Owed& answered) {
    for (Owed& each : owed_)
        if (!each.answered && each.unit == answered.unit && !same_shape(each, answered))
            each.overtaken = true;
}

// Bytes that begin like the answer to the last request, or like an exception, and are as many, with a wrong
// checksum.
bool AnswerLedger::begins_like_last() const {
    constexpr std::size_t kExceptionBytes = 2;
    const Owed& last = owed_.back();
    const auto exception = static_cast<std::uint8_t>(last.function | 0x80U);
    return begins_like({last.unit, last.function}, frame_characters(framing_, last.length)) ||
           begins_like({last.unit, exception}, frame_characters(framing_, kExceptionBytes));
}

// @param length  of the whole frame on the line
bool AnswerLedger::begins_like(ByteVector begin, std::size_t length) const {
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
    const auto last_begin = since_.end() - static_cast<std::ptrdiff_t>(length - begin.size());
    return std::search(since_.begin(), last_begin, begin.begin(), begin.end()) != last_begin;
}

bool AnswerLedger::seen_before(std::uint8_t unit, const ByteVector& pdu) const {
    return std::ranges::count(past_, hash_of(unit, pdu)) > 1;
}

// A copy of an earlier frame instead of its answer, which may follow.
bool AnswerLedger::seen_before(const Owed& request) const {
    return std::ranges::any_of(heard_, [&](const Heard& each) {
        return matches(request, {0, each.unit, each.pdu}) && seen_before(each.unit, each.pdu);
    });
}

void AnswerLedger::note_exempt(Instant t, const Asked& asked) {
    Shift& shift = shifted_.try_emplace(asked.unit, Shift{owed(t, asked), t}).first->second;
    if (shift.others >= kMostOthers) shift.since = t;
    shift.others = 0;
}

bool AnswerLedger::has_passed(const Owed& each, Instant t) const {
    if (each.passed(!reordered(each.unit))) return true;
    return (each.overtaken || each.unfollowed > 0) && t - each.t > expected(each.unit);
}

// Twice the median of the last three late delays, and at least as long as responses are confirmed.
Duration AnswerLedger::expected(std::uint8_t unit) const {
    constexpr int kFactor = 2;
    constexpr int kConfirmed = 8;
    const Duration least = kConfirmed * usual_delay(unit);
    const auto found = last_late_.find(unit);
    if (found == last_late_.end() || found->second.size() < kLateOnes) return least;
    auto sorted = found->second;
    std::ranges::sort(sorted);
    return std::max(least, kFactor * sorted[kLateOnes / 2]);
}

Duration AnswerLedger::lateness(std::uint8_t unit) const {
    const auto found = lateness_.find(unit);
    return found == lateness_.end() ? Duration::zero() : found->second;
}

Duration AnswerLedger::usual_delay(std::uint8_t unit) const {
    const auto found = delays_.find(unit);
    if (found == delays_.end()) return kUnknownDelay;
    auto sorted = found->second;
    std::ranges::sort(sorted);
    return sorted[sorted.size() / 2];
}

void AnswerLedger::settle_suspected(Instant t, const Owed& next) {
    for (Owed& each : owed_) {
        if (!each.suspected_at) continue;
        const bool unfollowed = t - *each.suspected_at >= usual_delay(each.unit);
        each.unfollowed += unfollowed;
        if (unfollowed || same_shape(each, next)) each.suspected_at.reset();
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

bool AnswerLedger::may_check(Instant t, std::uint8_t unit) const {
    const auto run = runs_.find(unit);
    const auto surplus = surplus_at_.find(unit);
    if (surplus != surplus_at_.end() && t - surplus->second < kForgotten) return true;
    return run != runs_.end() && run->second.since == t && t - run->second.before >= kCheck;
}

bool AnswerLedger::doubtful(const Asked& asked) const {
    if (owed_.empty()) return false;
    const Owed own = owed({}, asked);
    return candidates(asked).size() > 1 || std::any_of(owed_.begin(), owed_.end() - 1, [&](const Owed& each) {
               return (!each.answered || each.damaged) && each.unit == own.unit &&
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
    const auto shifted = shifted_.find(own.unit);
    const bool one_behind =
        shifted != shifted_.end() && same_shape(shifted->second.request, own) && came.size() == 1;
    if (one_behind && shifted->second.others < kMostOthers && t - shifted->second.since > kShifted)
        return std::nullopt;
    const bool unfollowed = t - last_candidate(asked).value_or(t) >= usual_delay(own.unit);
    std::size_t open = 0;
    bool passed = false;
    bool expired = false;
    for (const Owed& each : owed_) {
        if (!same_shape(each, own) || each.t >= sent) continue;
        if (each.answered)
            passed = passed || each.may_follow;
        else if (t - each.t > kForgotten)
            expired = true;
        else if (has_passed(each, t) || (each.unfollowed == 1 && unfollowed))
            passed = true;
        else
            ++open;
    }
    if ((open > 0 || passed) && came.back() != published) return std::nullopt;
    if (open > 0) {
        const bool all_and_last = came.size() > open && !reordered(own.unit);
        return all_and_last ? std::optional<std::string_view>("exempt_reordered") : std::nullopt;
    }
    if (passed) return "exempt_passed";
    if (expired) return "exempt_expired";
    const auto heard_before = std::ranges::count(past_, hash_of(own.unit, published));
    const auto heard_now = std::ranges::count(came, published);
    if (heard_before > heard_now) return "exempt_copy";
    return one_behind ? std::optional<std::string_view>("exempt_shifted") : std::nullopt;
}

std::string AnswerLedger::describe(Instant t, Instant sent, const Asked& asked) const {
    const Owed own = owed(sent, asked);
    std::string text;
    for (const Owed& each : owed_) {
        if ((each.answered && !each.may_follow) || !same_shape(each, own) || each.t >= sent) continue;
        text += text.empty() ? "; an answer of its shape is owed since " : ", ";
        text += std::to_string((t - each.t) / std::chrono::milliseconds(1)) + " ms";
        if (each.answered || has_passed(each, t)) text += " (passed)";
    }
    if (reordered(own.unit)) text += "; the unit has answered out of order";
    return text;
}

}  // namespace takt::judge
