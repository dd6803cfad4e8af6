#include "outputs/live_queue.hpp"

#include <algorithm>
#include <utility>

namespace takt::publish {

bool LiveQueue::push(LiveMessage&& live) {
    if (entries_.size() >= capacity_) return false;
    entries_.push_back({.live = std::move(live)});
    return true;
}

std::size_t LiveQueue::drop_expired(Instant now) {
    return std::erase_if(entries_,
                         [now](const Entry& entry) { return entry.token == 0 && entry.live.expires <= now; });
}

const MqttMessage* LiveQueue::next() const {
    const auto entry = std::ranges::find(entries_, MqttToken{0}, &Entry::token);
    return entry == entries_.end() ? nullptr : &entry->live.message;
}

void LiveQueue::sent(MqttToken token) {
    next_entry()->token = token;
    ++in_flight_;
}

bool LiveQueue::shorten_next() {
    LiveMessage& live = next_entry()->live;
    if (live.short_payload.empty()) return false;
    live.message.payload = std::exchange(live.short_payload, {});
    return true;
}

void LiveQueue::drop_next() {
    entries_.erase(next_entry());
}

LiveQueue::Settled LiveQueue::settle(MqttToken token, MqttReason reason) {
    const auto entry = std::ranges::find(entries_, token, &Entry::token);
    if (token == 0 || entry == entries_.end()) return Settled::not_found;
    --in_flight_;
    if (reason == MqttReason::quota_exceeded) {
        entry->token = 0;
        return Settled::refused;
    }
    entries_.erase(entry);
    return is_failure(reason) ? Settled::dropped : Settled::accepted;
}

MqttToken LiveQueue::oldest_in_flight() const {
    MqttToken oldest = 0;
    for (const Entry& entry : entries_)
        if (entry.token != 0 && (oldest == 0 || entry.token < oldest)) oldest = entry.token;
    return oldest;
}

std::size_t LiveQueue::on_lost() {
    in_flight_ = 0;
    const std::size_t dropped =
        std::erase_if(entries_, [](const Entry& entry) { return entry.live.this_connection_only; });
    for (auto& entry : entries_) entry.token = 0;
    return dropped;
}

}  // namespace takt::publish
