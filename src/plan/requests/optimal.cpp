// Strategy optimal for one device. Reads are planned per function: polled and periodic spans by rounds(), as
// fast as possible and triggered spans by cover(). Then write_pass() plans the writes, and join() merges
// reads and writes of the same items.
#include "requests/optimal.hpp"

#include <algorithm>
#include <iterator>
#include <tuple>
#include <utility>

#include "requests/cover_reason.hpp"
#include "requests/grouping.hpp"
#include "requests/reads.hpp"
#include "requests/rounds.hpp"
#include "requests/write_pass.hpp"

namespace takt::plan {
namespace {

// Groups spans by key. Spans without a key are omitted.
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

auto start_and_quantity(const Request& request) {
    return std::tie(request.start, request.quantity);
}

bool before(const Request& a, const Request& b) {
    const bool polled_a = !a.period, polled_b = !b.period;  // polled ones first
    return std::tie(a.start, a.quantity, polled_a, a.period, a.phase, a.read_trigger) <
           std::tie(b.start, b.quantity, polled_b, b.period, b.phase, b.read_trigger);
}

// The selected spans that lie inside the window, including earlier spans with the same start.
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

// A request for the variables of a window, with their common status, least deadline and bridged gaps. Period
// and trigger are set by the caller.
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

// Minimum-cost requests for the selected spans of one function, ascending by start.
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

// The polled request with the same items, if `triggered`'s trigger reads all of its variables.
Request* same_read(std::vector<Request>& polled, const Request& triggered) {
    const auto at = std::lower_bound(
        polled.begin(), polled.end(), triggered,
        [](const Request& a, const Request& b) { return start_and_quantity(a) < start_and_quantity(b); });
    for (auto same = at; same != polled.end() && start_and_quantity(*same) == start_and_quantity(triggered);
         ++same)
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

// Reasons in this order: a gap that is too wide, a next span that is not due at the same instants, or the
// cover itself.
Reason reason_of(const FunctionReads& reads, const CoverReasons& reasons, const TimedWindow& window) {
    const Covered here{window.items, window.spans};
    const auto& spans = reads.spans;
    auto beyond = std::partition_point(
        spans.begin(), spans.end(), [&window](const Span& span) { return span.start < window.items.start; });
    while (beyond != spans.end() && beyond->end <= window.items.end) ++beyond;
    if (beyond == spans.end()) return reasons.last(here);
    const auto next = static_cast<std::size_t>(beyond - spans.begin());
    const bool due = window.next && window.next->start <= beyond->start && beyond->end <= window.next->end;
    Reason apart = reasons.apart(here, {due ? *window.next : *beyond, {&next, 1}});
    const bool too_wide = apart.code == "plan.gap_forbidden" || apart.code == "plan.gap_costs";
    const bool same = reads.items[window.spans.back()].period == reads.items[next].period;
    return due || too_wide || same ? apart : reasons.other_period(here, next);
}

// The pieces of a value longer than a request must have equal periods.
std::vector<TimedSpan> timed_spans(const model::Device& device, const FunctionReads& reads,
                                   std::vector<std::size_t>& items) {
    std::vector<std::uint32_t> pieces(device.variables.size());
    for (const ReadItem& item : reads.items) ++pieces[item.variable];
    std::vector<TimedSpan> spans;
    for (std::size_t i = 0; i < reads.items.size(); ++i) {
        const ReadItem& item = reads.items[i];
        if (item.period == Duration::zero()) continue;
        spans.push_back({reads.spans[i], item.period, pieces[item.variable] > 1});
        items.push_back(i);
    }
    return spans;
}

std::vector<Request> polled_in_rounds(const model::Device& device, const FunctionReads& reads,
                                      const CoverReasons& reasons) {
    std::vector<std::size_t> items;
    const std::vector<TimedSpan> timed = timed_spans(device, reads, items);
    std::vector<Request> requests;
    for (TimedWindow& window : rounds(timed, reads.rules())) {
        for (std::size_t& span : window.spans) span = items[span];
        requests.push_back(read_request(reads, reasons, {window.items, window.spans}));
        requests.back().period = window.progression.period;
        requests.back().phase = window.progression.phase;
        requests.back().why = reason_of(reads, reasons, window);
    }
    return requests;
}

// Period 0 (as fast as the line allows): such spans share no request with periodic ones, which would
// otherwise be read without pause.
std::vector<Request> polled_requests(const model::Device& device, const FunctionReads& reads,
                                     const CoverReasons& reasons) {
    const auto classes = by_key<Duration>(reads, period_of);
    const auto timed = std::count_if(classes.begin(), classes.end(),
                                     [](const auto& c) { return c.first > Duration::zero(); });
    std::vector<Request> all;
    for (const auto& [period, selection] : classes) {
        if (period > Duration::zero() && timed > 1) continue;
        auto requests = covering_requests(reads, reasons, selection);
        for (Request& request : requests) request.period = period;
        std::move(requests.begin(), requests.end(), std::back_inserter(all));
    }
    if (timed > 1) {
        auto requests = polled_in_rounds(device, reads, reasons);
        std::move(requests.begin(), requests.end(), std::back_inserter(all));
    }
    if (classes.size() > 1) std::stable_sort(all.begin(), all.end(), before);
    return all;
}

std::vector<Request> function_requests(const model::Device& device, const FunctionReads& reads,
                                       const CoverReasons& reasons) {
    std::vector<Request> requests = polled_requests(device, reads, reasons);
    std::vector<Request> more;
    for (Request& triggered : triggered_requests(reads, reasons)) {
        if (Request* polled = same_read(requests, triggered))
            polled->read_trigger = triggered.read_trigger;
        else
            more.push_back(std::move(triggered));
    }
    if (more.empty()) return requests;
    std::move(more.begin(), more.end(), std::back_inserter(requests));
    std::stable_sort(requests.begin(), requests.end(), before);
    return requests;
}

}  // namespace

std::vector<Request> optimal_requests(const model::Project& project, const model::Line& line,
                                      const model::Device& device) {
    std::vector<Request> requests;
    for (const FunctionReads& reads : reads_of(project, line, device)) {
        auto read = function_requests(device, reads, CoverReasons(line, device, reads));
        std::move(read.begin(), read.end(), std::back_inserter(requests));
    }
    return joined(project, line, device, std::move(requests), write_requests(project, line, device));
}

}  // namespace takt::plan
