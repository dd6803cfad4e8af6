#include "takt/relay/answer_cache.hpp"

#include <algorithm>

namespace takt::relay {

void AnswerCache::keep(Instant t, UnitId unit, Bytes request, Bytes answer) {
    if (most_ == 0) return;
    auto place = std::ranges::find_if(kept_, [&](const Kept& kept) {
        return kept.unit == unit && std::ranges::equal(kept.request, request);
    });
    if (place == kept_.end() && kept_.size() < most_) place = kept_.insert(kept_.end(), Kept{});
    if (place == kept_.end()) place = std::ranges::min_element(kept_, {}, &Kept::t);
    place->t = t;
    place->unit = unit;
    place->request.assign(request);
    place->answer.assign(answer);
}

const wire::Pdu* AnswerCache::find(Instant t, UnitId unit, Bytes request, Duration age) const {
    const auto found = std::ranges::find_if(kept_, [&](const Kept& kept) {
        return kept.unit == unit && t - kept.t <= age && std::ranges::equal(kept.request, request);
    });
    return found == kept_.end() ? nullptr : &found->answer;
}

void AnswerCache::drop(UnitId unit) {
    std::erase_if(kept_, [unit](const Kept& kept) { return kept.unit == unit; });
}

}  // namespace takt::relay
