#include "ledger.hpp"

#include <algorithm>

namespace takt::judge {
namespace {

constexpr std::size_t kMostOwed = 4096;
constexpr std::size_t kMostBytes = 600;  // longer than any frame
constexpr std::size_t kDelays = 8;
constexpr std::size_t kPast = 16384;  // frames of minutes

std::uint64_t hash_of(std::uint8_t unit, const ByteVector& pdu) {
    std::uint64_t hash = 0xCBF29CE484222325 ^ unit;
    for (const auto byte : pdu) hash = (hash ^ byte) * 0x100000001B3;
    return hash;
}
constexpr Duration kUnknownDelay = std::chrono::milliseconds(100);

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

void AnswerLedger::on_connection() {
    owed_.clear();
    shifted_.clear();
    bytes_.clear();
    heard_.clear();
}

void AnswerLedger::on_sent(Instant t, const Asked& asked) {
    if (framing_ == wire::Framing::tcp || asked.unit == 0) return;  // the transaction id tells them apart
    settle_last();
    settle_suspected(t, owed(t, asked));
    heard_.clear();
    std::erase_if(owed_, [](const Owed& each) { return each.answered; });
    while (!owed_.empty() && t - owed_.front().t > 2 * kForgotten) owed_.pop_front();
    const auto shifted = shifted_.find(asked.unit);
    if (shifted != shifted_.end() && !same_shape(shifted->second, owed(t, asked))) shifted_.erase(shifted);
    owed_.push_back(owed(t, asked));
    if (owed_.size() > kMostOwed) owed_.pop_front();
}

void AnswerLedger::on_heard(Instant t, std::span<const std::uint8_t> bytes) {
    if (framing_ == wire::Framing::tcp) return;
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    std::size_t parsed = 0;
    for (const FoundFrame& frame : find_frames(framing_, bytes_, parsed)) take(t, frame);
    parsed = std::max(parsed, bytes_.size() - std::min(bytes_.size(), kMostBytes));
    bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(parsed));
}

// A frame that can be the answer to the last request waits for settle_last(). An exception belongs to the
// only open request with its function; of several it settles none, because each of them may still be owed.
void AnswerLedger::take(Instant t, const FoundFrame& frame) {
    heard_.push_back({t, frame.unit, frame.pdu});
    if (past_.size() < kPast)
        past_.push_back(hash_of(frame.unit, frame.pdu));
    else
        past_[next_past_++ % kPast] = hash_of(frame.unit, frame.pdu);
    if (owed_.empty() || matches(owed_.back(), frame)) return;
    const auto gone = [](const Owed& each) { return each.passed(true); };
    Owed* found = nullptr;
    unsigned refused = 0;
    for (Owed& each : owed_) {
        if (each.answered) continue;
        const bool refuses = each.unit == frame.unit && (each.function | 0x80U) == frame.pdu[0];
        refused += refuses;
        if (!refuses && !matches(each, frame)) continue;
        if (!found || (gone(*found) && !gone(each))) found = &each;
    }
    if (!found || refused > 1) return;
    found->answered = true;
    if (refused == 1 && found == &owed_.back()) pass_others(*found);
    lateness_[frame.unit] = std::max(lateness_[frame.unit], t - found->t);
    if (refused == 0 && found->unfollowed < 2 && (found->overtaken || last_is_answered()))
        reordered_[frame.unit / 64] |= std::uint64_t{1} << (frame.unit % 64);
}

// By one frame, and no other answer of its shape is owed.
bool AnswerLedger::last_is_answered() const {
    const Owed& last = owed_.back();
    const auto came = std::ranges::count_if(
        heard_, [&](const Heard& each) { return matches(last, {0, each.unit, each.pdu}); });
    return came == 1 && std::none_of(owed_.begin(), owed_.end() - 1, [&](const Owed& each) {
               return !each.answered && same_shape(each, last) && !each.passed(!reordered(last.unit));
           });
}

// The last frame of the shape of the last request counts as its answer, the others as those owed before.
void AnswerLedger::settle_last() {
    if (owed_.empty()) return;
    Owed& last = owed_.back();
    std::size_t came = 0;
    Instant last_came;
    for (const Heard& each : heard_) {
        if (!matches(last, {0, each.unit, each.pdu})) continue;
        ++came;
        last_came = each.t;
    }
    if (came == 0) return;
    const bool undoubted = last_is_answered();
    const bool several = came > 1;
    last.answered = true;
    for (const bool gone : {false, true})
        for (Owed& each : owed_)
            if (came > 1 && !each.answered && each.passed(true) == gone && same_shape(each, last)) {
                each.answered = true;
                lateness_[last.unit] = std::max(lateness_[last.unit], last_came - each.t);
                --came;
            }
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

void AnswerLedger::note_exempt(const Asked& asked) {
    shifted_[asked.unit] = owed({}, asked);
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

bool AnswerLedger::doubtful(const Asked& asked) const {
    if (owed_.empty()) return false;
    const Owed own = owed({}, asked);
    return candidates(asked).size() > 1 || std::any_of(owed_.begin(), owed_.end() - 1, [&](const Owed& each) {
               return !each.answered && each.unit == own.unit && each.function == own.function &&
                      (each.length == own.length || !own.echo.empty());
           });
}

std::vector<ByteVector> AnswerLedger::candidates(const Asked& asked) const {
    const Owed own = owed({}, asked);
    std::vector<ByteVector> found;
    for (const Heard& each : heard_)
        if (matches(own, {0, each.unit, each.pdu})) found.push_back(each.pdu);
    return found;
}

std::optional<std::string_view> AnswerLedger::exemption(Instant t, Instant sent, const Asked& asked,
                                                        const ByteVector& published) const {
    const auto came = candidates(asked);
    if (std::ranges::find(came, published) == came.end()) return std::nullopt;
    const Owed own = owed(sent, asked);
    Instant last_came;
    for (const Heard& each : heard_)
        if (matches(own, {0, each.unit, each.pdu})) last_came = each.t;
    const bool unfollowed = t - last_came >= usual_delay(own.unit);
    std::size_t open = 0;
    bool passed = false;
    bool expired = false;
    for (const Owed& each : owed_) {
        if (each.answered || !same_shape(each, own) || each.t >= sent) continue;
        if (t - each.t > kForgotten)
            expired = true;
        else if (each.passed(!reordered(own.unit)) || (each.unfollowed == 1 && unfollowed))
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
    const auto shifted = shifted_.find(own.unit);
    const bool one_behind = shifted != shifted_.end() && same_shape(shifted->second, own) && came.size() == 1;
    return one_behind ? std::optional<std::string_view>("exempt_shifted") : std::nullopt;
}

std::string AnswerLedger::describe(Instant t, Instant sent, const Asked& asked) const {
    const Owed own = owed(sent, asked);
    std::string text;
    for (const Owed& each : owed_) {
        if (each.answered || !same_shape(each, own) || each.t >= sent) continue;
        text += text.empty() ? "; an answer of its shape is owed since " : ", ";
        text += std::to_string((t - each.t) / std::chrono::milliseconds(1)) + " ms";
        if (each.passed(!reordered(own.unit))) text += " (passed)";
    }
    if (reordered(own.unit)) text += "; the unit has answered out of order";
    return text;
}

}  // namespace takt::judge
