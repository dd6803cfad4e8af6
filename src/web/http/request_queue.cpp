#include "http/request_queue.hpp"

#include <algorithm>
#include <utility>

namespace takt::web {
namespace {

std::size_t index_of(Work work) {
    return static_cast<std::size_t>(work);
}

}  // namespace

const RequestQueue::Counts& RequestQueue::of(std::string_view visitor) const {
    static constexpr Counts kNone;
    const auto found = visitors_.find(visitor);
    return found == visitors_.end() ? kNone : found->second;
}

bool RequestQueue::may_start(const Entry& entry) const {
    const auto work = index_of(entry.work);
    const auto& share = limits_.executing[work];
    return counts_.of_work[work] < share.all && of(entry.visitor).of_work[work] < share.visitor;
}

void RequestQueue::count(const Entry& entry, int change) {
    auto& own = visitors_[entry.visitor];
    for (auto* const counts : {&counts_, &own}) {
        counts->all += static_cast<std::size_t>(change);
        counts->of_work[index_of(entry.work)] += static_cast<std::size_t>(change);
    }
    if (own.all == 0) visitors_.erase(entry.visitor);
}

RequestQueue::Pushed RequestQueue::push(Entry entry) {
    if (!may_start(entry)) {
        const auto own = std::ranges::count(waiting_, entry.visitor, &Entry::visitor);
        if (static_cast<std::size_t>(own) >= limits_.waiting_of_visitor) return Pushed::visitor_full;
        if (waiting_.size() >= limits_.waiting) return Pushed::full;
    }
    last_ = entry;
    waiting_.push_back(std::move(entry));
    return Pushed::accepted;
}

std::vector<RequestQueue::Id> RequestQueue::superseded() const {
    std::vector<Id> found;
    if (last_.superseded_by.empty()) return found;
    for (const auto* const entries : {&waiting_, &executing_})
        for (const auto& entry : *entries)
            if (entry.superseded_by == last_.superseded_by && entry.id != last_.id) found.push_back(entry.id);
    return found;
}

void RequestQueue::cut_short(Id id) {
    const auto found = std::ranges::find(waiting_, id, &Entry::id);
    if (found != waiting_.end() && !found->superseded_by.empty()) found->work = Work::quick;
}

std::optional<RequestQueue::Id> RequestQueue::next() {
    auto best = waiting_.end();
    for (auto entry = waiting_.begin(); entry != waiting_.end(); ++entry)
        if (may_start(*entry) && (best == waiting_.end() || of(entry->visitor).all < of(best->visitor).all))
            best = entry;
    if (best == waiting_.end()) return std::nullopt;
    const Id id = best->id;
    count(*best, 1);
    executing_.push_back(std::move(*best));
    waiting_.erase(best);
    return id;
}

void RequestQueue::remove(Id id) {
    std::erase_if(waiting_, [id](const Entry& entry) { return entry.id == id; });
    const auto found = std::ranges::find(executing_, id, &Entry::id);
    if (found == executing_.end()) return;
    count(*found, -1);
    executing_.erase(found);
}

}  // namespace takt::web
