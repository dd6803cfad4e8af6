#include "live/marks.hpp"

#include <algorithm>
#include <utility>

namespace takt::web {
namespace {

file::Json json_of(const Mark& mark, text::Language language) {
    auto object = file::Json::object();
    object.set("time", mark.time_ms);
    object.set("kind", mark.kind == Mark::Kind::command ? "command" : "message");
    object.set("severity", mark.severity);
    object.set("text", mark.texts[static_cast<std::size_t>(language)]);
    if (!mark.outcome.empty()) object.set("outcome", mark.outcome);
    if (!mark.origin.empty()) object.set("origin", mark.origin);
    return object;
}

}  // namespace

void Marks::put(Mark mark) {
    const std::lock_guard lock(mutex_);
    auto& list = list_of(mark.kind);
    list.push_back({next_++, std::move(mark)});
    trim(list);
}

void Marks::put_before(std::int64_t since_ms, std::vector<Mark> earlier) {
    const std::lock_guard lock(mutex_);
    since_ms_ = std::min(since_ms_, since_ms);
    std::int64_t number = 0;
    while (!earlier.empty()) {
        auto& list = list_of(earlier.back().kind);
        list.push_front({--number, std::move(earlier.back())});
        earlier.pop_back();
    }
    for (auto& list : lists_) trim(list);
}

void Marks::trim(List& list) {
    while (list.size() > kMost) {
        since_ms_ = std::max(since_ms_, list.front().mark.time_ms + 1);
        list.pop_front();
    }
}

Marks::Part Marks::after(std::int64_t number) const {
    Part part;
    std::vector<const Entry*> found;
    const std::lock_guard lock(mutex_);
    part.since_ms = since_ms_;
    for (const auto& list : lists_)
        for (auto entry = list.rbegin(); entry != list.rend() && entry->number > number; ++entry)
            found.push_back(&*entry);
    std::ranges::sort(found, {}, &Entry::number);
    for (const auto* const entry : found) part.marks.push_back(entry->mark);
    if (!found.empty()) part.last = found.back()->number;
    return part;
}

file::Json Marks::json(text::Language language, std::int64_t from_ms, std::int64_t to_ms) const {
    const std::lock_guard lock(mutex_);
    std::vector<const Entry*> found;
    for (const auto& list : lists_)
        for (const auto& entry : list)
            if (entry.mark.time_ms >= from_ms && entry.mark.time_ms < to_ms) found.push_back(&entry);
    std::ranges::sort(found, {}, [](const Entry* its) { return std::pair(its->mark.time_ms, its->number); });
    auto list = file::Json::array();
    for (const auto* const entry : found) list.push_back(json_of(entry->mark, language));
    auto object = file::Json::object();
    object.set("since", since_ms_);
    object.set("events", std::move(list));
    return object;
}

}  // namespace takt::web
