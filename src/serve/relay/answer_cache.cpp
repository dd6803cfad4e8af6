#include "takt/serve/answer_cache.hpp"

#include <algorithm>

namespace takt::serve {

void AnswerCache::store(Instant t, UnitId unit, Bytes request, Bytes answer) {
    if (most_ == 0) return;
    auto entry = std::ranges::find_if(entries_, [&](const Entry& cached) {
        return cached.unit == unit && std::ranges::equal(cached.request, request);
    });
    if (entry == entries_.end() && entries_.size() < most_) entry = entries_.insert(entries_.end(), Entry{});
    if (entry == entries_.end()) entry = std::ranges::min_element(entries_, {}, &Entry::t);
    entry->t = t;
    entry->unit = unit;
    entry->request.assign(request);
    entry->answer.assign(answer);
}

const wire::Pdu* AnswerCache::find(Instant t, UnitId unit, Bytes request, Duration age) const {
    const auto found = std::ranges::find_if(entries_, [&](const Entry& cached) {
        return cached.unit == unit && t - cached.t <= age && std::ranges::equal(cached.request, request);
    });
    return found == entries_.end() ? nullptr : &found->answer;
}

void AnswerCache::drop(UnitId unit) {
    std::erase_if(entries_, [unit](const Entry& cached) { return cached.unit == unit; });
}

}  // namespace takt::serve
