#include "optimal.hpp"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <tuple>
#include <utility>

#include "grouping.hpp"
#include "write_pass.hpp"

namespace takt::plan {
namespace {

// The spans with the same key, by key; those without one are left out.
template <class Key>
std::vector<std::pair<Key, Selection>> by_key(const FunctionReads& reads,
                                              std::optional<Key> (*key)(const ReadItem&)) {
    std::vector<std::pair<Key, std::size_t>> keyed;
    keyed.reserve(reads.items.size());
    for (std::size_t i = 0; i < reads.items.size(); ++i)
        if (const auto k = key(reads.items[i])) keyed.emplace_back(*k, i);
    if (!std::is_sorted(keyed.begin(), keyed.end())) std::sort(keyed.begin(), keyed.end());
    std::vector<std::pair<Key, Selection>> groups;
    for (const auto& [k, i] : keyed) {
        if (groups.empty() || groups.back().first != k) groups.emplace_back(k, Selection());
        groups.back().second.spans.push_back(reads.spans[i]);
        groups.back().second.items.push_back(i);
    }
    return groups;
}

std::optional<Duration> period_of(const ReadItem& item) {
    return item.period;
}

std::optional<model::LocalIndex> trigger_of(const ReadItem& item) {
    return item.trigger;
}

auto place(const Request& request) {
    return std::tie(request.start, request.quantity);
}

bool before(const Request& a, const Request& b) {
    const bool polled_a = !a.period, polled_b = !b.period;  // polled ones first
    return std::tie(a.start, a.quantity, polled_a, a.period, a.phase, a.read_trigger) <
           std::tie(b.start, b.quantity, polled_b, b.period, b.phase, b.read_trigger);
}

// Selected spans from `window.first` on that lie in the window; those of the same start before it as well.
std::pair<std::size_t, std::size_t> reach_of(const Window& window, std::span<const Span> spans) {
    std::size_t first = window.first;
    while (first > 0 && spans[first - 1].start == window.items.start) --first;
    std::size_t last = window.last + 1;
    while (last < spans.size() && spans[last].start < window.items.end) ++last;
    return {first, last};
}

std::vector<std::size_t> members_of(const Window& window, const Selection& selection) {
    const auto [first, last] = reach_of(window, selection.spans);
    std::vector<std::size_t> members;
    members.reserve(last - first);
    for (std::size_t i = first; i < last; ++i)
        if (selection.spans[i].end <= window.items.end) members.push_back(selection.items[i]);
    return members;
}

// The polled request that reads the same, where all its variables are read by the trigger of `triggered`.
Request* same_read(std::vector<Request>& polled, const Request& triggered) {
    const auto at = std::lower_bound(polled.begin(), polled.end(), triggered,
                                     [](const Request& a, const Request& b) { return place(a) < place(b); });
    for (auto same = at; same != polled.end() && place(*same) == place(triggered); ++same)
        if (!same->read_trigger && same->variables == triggered.variables) return &*same;
    return nullptr;
}

std::vector<Request> triggered_requests(const FunctionReads& reads, const CoverReasons& reasons) {
    std::vector<Request> all;
    for (const auto& [trigger, selection] : by_key<model::LocalIndex>(reads, trigger_of)) {
        auto requests = covering_requests(reads, reasons, selection);
        for (Request& request : requests) {
            request.read_trigger = trigger;
            request.deadline.reset();
        }
        std::move(requests.begin(), requests.end(), std::back_inserter(all));
    }
    return all;
}

// Puts requests behind others, their streams apart from those.
void append(std::vector<Request>& requests, std::vector<Request> more) {
    std::size_t streams = 0;
    for (const Request& request : requests) streams = std::max(streams, request.stream + 1);
    for (Request& request : more) request.stream += streams;
    std::move(more.begin(), more.end(), std::back_inserter(requests));
}

std::vector<Request> function_requests(const FunctionReads& reads, const CoverReasons& reasons) {
    std::vector<Request> requests = polled_alone(reads, reasons);
    std::vector<Request> more;
    for (Request& triggered : triggered_requests(reads, reasons)) {
        if (Request* polled = same_read(requests, triggered)) {
            polled->read_trigger = triggered.read_trigger;
        } else {
            triggered.stream = more.size();
            more.push_back(std::move(triggered));
        }
    }
    if (more.empty()) return requests;
    append(requests, std::move(more));
    std::stable_sort(requests.begin(), requests.end(), before);
    return requests;
}

}  // namespace

Request read_request(const FunctionReads& reads, const CoverReasons& reasons, const Covered& covered) {
    Request request;
    request.read = reads.function;
    request.start = static_cast<std::uint16_t>(covered.items.start);
    request.quantity = static_cast<std::uint16_t>(std::min<std::uint32_t>(covered.items.size(), 65535));
    request.status = reads.items[covered.members.front()].status;
    request.variables.reserve(covered.members.size());
    for (const std::size_t member : covered.members) {
        const ReadItem& item = reads.items[member];
        request.variables.push_back(item.variable);
        if (item.status != request.status) request.status.reset();
        request.deadline = sooner(request.deadline, item.deadline);
    }
    request.bridged = reasons.bridged(covered);
    return request;
}

std::vector<Request> covering_requests(const FunctionReads& reads, const CoverReasons& reasons,
                                       const Selection& selection) {
    const auto windows = cover(selection.spans, reads.rules());
    std::vector<Request> requests;
    requests.reserve(windows.size());
    std::vector<std::size_t> members, next_members;
    if (!windows.empty()) members = members_of(windows.front(), selection);
    for (std::size_t i = 0; i < windows.size(); ++i) {
        const Covered here{windows[i].items, members};
        requests.push_back(read_request(reads, reasons, here));
        if (i + 1 < windows.size()) {
            next_members = members_of(windows[i + 1], selection);
            requests.back().why = reasons.apart(here, {windows[i + 1].items, next_members});
        } else {
            requests.back().why = reasons.last(here);
        }
        members.swap(next_members);
    }
    return requests;
}

std::vector<Request> polled_alone(const FunctionReads& reads, const CoverReasons& reasons) {
    std::vector<Request> all;
    const auto classes = by_key<Duration>(reads, period_of);
    for (const auto& [period, selection] : classes) {
        auto requests = covering_requests(reads, reasons, selection);
        for (Request& request : requests) request.period = period;
        std::move(requests.begin(), requests.end(), std::back_inserter(all));
    }
    if (classes.size() > 1) std::stable_sort(all.begin(), all.end(), before);
    for (std::size_t i = 0; i < all.size(); ++i) all[i].stream = i;
    return all;
}

std::vector<Request> optimal_requests(const model::Project& project, const model::Line& line,
                                      const model::Device& device) {
    std::vector<Request> requests;
    for (const FunctionReads& reads : reads_of(project, line, device))
        append(requests, function_requests(reads, CoverReasons(line, device, reads)));
    return joined(project, line, device, std::move(requests), write_requests(project, line, device));
}

}  // namespace takt::plan
