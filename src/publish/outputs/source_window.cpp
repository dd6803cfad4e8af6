#include "outputs/source_window.hpp"

#include <algorithm>

namespace takt::publish {

bool is_final(MqttReason reason) {
    return reason == MqttReason::packet_too_large || reason == MqttReason::topic_name_invalid ||
           reason == MqttReason::payload_format_invalid;
}

void SourceWindow::sent(Instant now, MqttToken token, std::uint64_t of_source, bool proved) {
    entries_.push_back({.token = token, .sent = now, .of_source = of_source, .proved = proved});
    ++waiting_;
}

void SourceWindow::unsendable(Instant now, MqttToken token, std::uint64_t of_source, MqttReason reason) {
    entries_.push_back(
        {.token = token, .of_source = of_source, .answer = Answer::rejected, .reason = reason});
    move_cursor(now);
}

SourceWindow::Settled SourceWindow::settle(Instant now, MqttToken token, MqttReason reason) {
    const auto entry = std::ranges::lower_bound(entries_, token, {}, &Entry::token);
    if (entry == entries_.end() || entry->token != token || entry->answer != Answer::none)
        return Settled::not_found;
    --waiting_;
    entry->reason = reason;
    if (!is_failure(reason)) {
        entry->answer = Answer::accepted;
    } else if (is_final(reason)) {
        entry->answer = Answer::rejected;
    } else {
        entry->answer = Answer::refused;
        blocked_ = true;
        return Settled::refused;
    }
    const auto settled = entry->answer == Answer::rejected ? Settled::rejected
                         : entry->proved                   ? Settled::accepted
                                                           : Settled::handed_over;
    if (settled == Settled::accepted) {
        constexpr int kSmoothing = 8;  // as RFC 6298
        const Duration measured = now - entry->sent;
        round_trip_ = round_trip_ ? *round_trip_ + (measured - *round_trip_) / kSmoothing : measured;
    }
    move_cursor(now);
    return settled;
}

MqttToken SourceWindow::oldest_waiting() const {
    const auto found = std::ranges::find(entries_, Answer::none, &Entry::answer);
    return found == entries_.end() ? 0 : found->token;
}

void SourceWindow::rewind() {
    blocked_ = false;
    waiting_ = 0;
    round_trip_.reset();
    if (entries_.empty()) return;
    entries_.clear();
    source_.rewind();
}

void SourceWindow::move_cursor(Instant now) {
    for (; !entries_.empty(); entries_.pop_front()) {
        const Entry& first = entries_.front();
        if (first.answer == Answer::accepted)
            source_.acknowledge(now, first.of_source);
        else if (first.answer == Answer::rejected)
            source_.reject(now, first.of_source, first.reason);
        else
            return;
    }
}

}  // namespace takt::publish
