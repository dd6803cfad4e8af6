#include "takt/capture/master_finder.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

namespace takt::capture {
namespace {

constexpr Duration kMostPeriod = std::chrono::hours(24);  // a longer one is unknown
constexpr double kInStep = 0.75;                          // share of the samples in two neighbouring bins
constexpr double kOverlapping = 0.05;  // share of the cycles in which polls of two masters overlap

}  // namespace

MasterFinder::MasterFinder() : pairs_(kMost * kMost) {
    polls_.reserve(kMost);
}

std::size_t MasterFinder::add() {
    polls_.emplace_back();
    return polls_.size() - 1;
}

void MasterFinder::on_request(Instant t, std::size_t poll, Duration period) {
    for (std::size_t other = 0; other < polls_.size(); ++other) {
        const auto& before = polls_[other];
        if (other == poll || before.requests == 0 || before.period <= Duration::zero()) continue;
        const auto passed = t - before.last;
        if (passed < Duration::zero() || passed > before.period + before.period / 4) continue;
        const auto bin = static_cast<std::size_t>(passed * static_cast<Duration::rep>(kBins) / before.period);
        auto& count = pair(other, poll).bins[std::min(bin, kBins - 1)];
        if (count < std::numeric_limits<std::uint32_t>::max()) ++count;
    }
    auto& own = polls_[poll];
    ++own.requests;
    own.last = t;
    own.period = period <= kMostPeriod ? period : Duration::zero();
}

void MasterFinder::on_overlap(std::size_t earlier, std::size_t later) {
    for (auto* const each : {&pair(earlier, later), &pair(later, earlier)})
        if (each->overlaps < std::numeric_limits<std::uint16_t>::max()) ++each->overlaps;
}

std::uint64_t MasterFinder::samples(const Pair& pair) {
    return std::accumulate(pair.bins.begin(), pair.bins.end(), std::uint64_t{0});
}

// The greatest share of two neighbouring bins; the last one is beside the first. 0: too few samples.
double MasterFinder::coherence(const Pair& pair) {
    const auto all = samples(pair);
    if (all < kEnough) return 0;
    std::uint64_t most = 0;
    for (std::size_t bin = 0; bin < kBins; ++bin)
        most = std::max(most, std::uint64_t{pair.bins[bin]} + pair.bins[(bin + 1) % kBins]);
    return static_cast<double>(most) / static_cast<double>(all);
}

// A master that never waits for a response overlaps with itself in nearly every cycle, one whose response
// came late rarely.
bool MasterFinder::contradict(std::size_t first, std::size_t second) const {
    const auto& there = pair(first, second);
    const auto& back = pair(second, first);
    const auto all = static_cast<double>(std::min(samples(there), samples(back)));
    return there.overlaps >= kConflicts && there.overlaps >= kOverlapping * all &&
           there.overlaps < kInStep * all;
}

bool MasterFinder::conflict(const std::vector<std::size_t>& a, const std::vector<std::size_t>& b) const {
    return std::ranges::any_of(a, [&](auto first) {
        return std::ranges::any_of(b, [&](auto second) { return contradict(first, second); });
    });
}

// The pairs in the order of their coherence join their groups, unless the groups contradict each other.
std::vector<std::vector<std::size_t>> MasterFinder::groups() const {
    struct Link {
        double coherence;
        std::size_t first;
        std::size_t second;
    };
    std::vector<Link> links;
    std::vector<std::vector<std::size_t>> groups;
    std::vector<std::size_t> group_of(polls_.size());
    for (std::size_t first = 0; first < polls_.size(); ++first) {
        group_of[first] = first;
        groups.push_back({});
        if (polls_[first].requests > kEnough) groups.back().push_back(first);
        for (std::size_t second = 0; second < first; ++second) {
            const auto both = std::max(coherence(pair(first, second)), coherence(pair(second, first)));
            if (both >= kInStep) links.push_back({both, second, first});
        }
    }
    std::ranges::stable_sort(links, std::greater(), &Link::coherence);
    for (const auto& link : links) {
        auto& to = groups[group_of[link.first]];
        auto& from = groups[group_of[link.second]];
        if (&to == &from || to.empty() || from.empty() || conflict(to, from)) continue;
        const auto target = group_of[link.first];
        for (const auto poll : from) group_of[poll] = target;
        to.insert(to.end(), from.begin(), from.end());
        from.clear();
    }
    std::erase_if(groups, [](const auto& group) { return group.empty(); });
    for (auto& group : groups) std::ranges::sort(group);
    return groups;
}

}  // namespace takt::capture
