#include "reference.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>
#include <set>

namespace corpus {
namespace {

using takt::wire::Framing;

Seconds seconds(Duration time) {
    return static_cast<Seconds>(time.count()) / 1e9L;
}

void sort(std::vector<Value>& values) {
    std::ranges::sort(values, [](const Value& a, const Value& b) {
        return std::pair(a.start, b.end()) < std::pair(b.start, a.end());
    });
}

bool together(std::vector<Value> values, const Rules& rules) {
    sort(values);
    std::uint32_t reached = values[0].end();
    for (const auto& value : values) {
        if (!rules.gaps && value.start > reached) return false;
        reached = std::max(reached, value.end());
    }
    return reached - values[0].start <= rules.limit;
}

/// Without those inside another one: a read of that one includes them.
std::vector<Value> outermost(std::vector<Value> values) {
    sort(values);
    std::vector<Value> kept;
    for (const auto& value : values)
        if (kept.empty() || value.end() > kept.back().end()) kept.push_back(value);
    return kept;
}

}  // namespace

Seconds Rules::cost(std::uint32_t items) const {
    const Seconds data = function <= 2 ? (items + 7) / 8 : 2 * items;
    if (bus.framing == Framing::tcp) return seconds(bus.turnaround) + 10e-9L * (12 + 9 + data);
    if (bus.framing == Framing::ascii) return 10 * (17 + 11 + 2 * data) / bus.baud + seconds(bus.turnaround);
    const Seconds character = 11.0L / bus.baud;
    const Seconds silence = bus.baud > 19200 ? 1.75e-3L : 3.5L * character;
    return silence + 8 * character + std::max(seconds(bus.turnaround), silence) + (5 + data) * character;
}

Rules rules_of(const Map& map, int function, const Bus& bus, bool gaps) {
    const std::uint32_t protocol = function <= 2 ? 2000 : 125;
    return {bus, function, std::min(protocol, map.most_registers.value_or(protocol)), gaps};
}

Seconds total(const std::vector<Read>& reads, const Rules& rules) {
    Seconds sum = 0;
    for (const auto& read : reads) sum += rules.cost(read.end - read.start);
    return sum;
}

std::vector<Read> least_reads(std::vector<Value> values, const Rules& rules) {
    const auto kept = outermost(std::move(values));
    std::vector<Seconds> best(kept.size() + 1, std::numeric_limits<Seconds>::infinity());
    std::vector<std::size_t> first(kept.size() + 1);
    best[0] = 0;
    for (std::size_t last = 0; last < kept.size(); ++last) {
        for (std::size_t i = last + 1; i-- > 0;) {
            if (i < last && !rules.gaps && kept[i + 1].start > kept[i].end()) break;
            if (kept[last].end() - kept[i].start > rules.limit) break;
            const Seconds cost = best[i] + rules.cost(kept[last].end() - kept[i].start);
            if (cost >= best[last + 1]) continue;
            best[last + 1] = cost;
            first[last + 1] = i;
        }
    }
    std::vector<Read> reads;
    for (std::size_t n = kept.size(); n > 0; n = first[n])
        reads.push_back({kept[first[n]].start, kept[n - 1].end()});
    return reads;
}

std::vector<Read> fixed_gap_reads(std::vector<Value> values, const Rules& rules, std::uint32_t gap) {
    sort(values);
    std::vector<Read> reads;
    for (const auto& value : values) {
        if (!reads.empty() && value.start <= reads.back().end + gap &&
            std::max(value.end(), reads.back().end) - reads.back().start <= rules.limit)
            reads.back().end = std::max(reads.back().end, value.end());
        else
            reads.push_back({value.start, value.end()});
    }
    return reads;
}

Seconds least_cost_by_trying(std::span<const Value> values, const Rules& rules) {
    Seconds best = std::numeric_limits<Seconds>::infinity();
    std::vector<std::vector<Value>> groups;
    const auto place = [&](const auto& self, std::size_t next) -> void {
        if (next == values.size()) {
            Seconds sum = 0;
            for (const auto& group : groups) {
                if (!together(group, rules)) return;
                const auto start = std::ranges::min(group, {}, &Value::start).start;
                const auto end = std::ranges::max(group, {}, &Value::end).end();
                sum += rules.cost(end - start);
            }
            best = std::min(best, sum);
            return;
        }
        for (std::size_t g = 0; g < groups.size(); ++g) {
            groups[g].push_back(values[next]);
            self(self, next + 1);
            groups[g].pop_back();
        }
        groups.push_back({values[next]});
        self(self, next + 1);
        groups.pop_back();
    };
    place(place, 0);
    return best;
}

Rates least_rates(const std::vector<Value>& values, const Rules& rules) {
    std::set<std::int64_t> periods;
    for (const auto& value : values) periods.insert(value.period.count());
    Rates rates;
    const auto due_cost = [&](const auto& due) {
        std::vector<Value> now;
        std::ranges::copy_if(values, std::back_inserter(now),
                             [&](const Value& v) { return due(v.period.count()); });
        return total(least_reads(std::move(now), rules), rules);
    };
    std::int64_t tick = 0;
    std::int64_t all = 1;
    for (const auto period : periods) {
        rates.per_class += due_cost([period](std::int64_t p) { return p == period; }) /
                           (static_cast<Seconds>(period) / 1e9L);
        tick = std::gcd(tick, period);
        all = std::lcm(all, period);
    }
    std::map<std::vector<bool>, std::int64_t> how_often;
    for (std::int64_t t = 0; t < all; t += tick) {
        std::vector<bool> due;
        for (const auto period : periods) due.push_back(t % period == 0);
        ++how_often[due];
    }
    for (const auto& [due, times] : how_often) {
        std::set<std::int64_t> now;
        std::size_t i = 0;
        for (const auto period : periods)
            if (due[i++]) now.insert(period);
        rates.aligned += due_cost([&now](std::int64_t p) { return now.contains(p); }) *
                         static_cast<Seconds>(times) / (static_cast<Seconds>(all) / 1e9L);
    }
    return rates;
}

}  // namespace corpus
