// Spreads streams over a round of slots as long as the shortest period. A stream of that period is due in
// every slot, with any phase; slower ones are shifted to the slots with the least bus time. Slot numbers
// wrap around at the end of the round. If the hyperperiod is longer than the round, the result is a
// heuristic.
#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <tuple>
#include <utility>

#include "timing/calendar.hpp"
#include "timing/streams.hpp"

namespace takt::plan {
namespace {

constexpr std::size_t kMostSlots = 256;

bool polled(const Request& request) {
    return request.read && request.period.has_value();
}

struct SpreadStream {
    std::vector<std::size_t> requests;
    Duration longest{};  // bus time of its longest request
};

std::vector<SpreadStream> spread_streams(std::span<const Request> requests) {
    std::vector<SpreadStream> streams;
    for (std::size_t i = 0; i < requests.size(); ++i) {
        if (!is_periodic(requests[i])) continue;
        if (requests[i].stream >= streams.size()) streams.resize(requests[i].stream + 1);
        SpreadStream& stream = streams[requests[i].stream];
        stream.requests.push_back(i);
        stream.longest = std::max(stream.longest, requests[i].bus_time);
    }
    std::erase_if(streams, [](const SpreadStream& stream) { return stream.requests.empty(); });
    return streams;
}

class Spread {
public:
    Spread(Duration slot, std::vector<Request>& requests) : slot_(slot), requests_(requests) {}

    void run(const std::vector<bool>& movable);

private:
    using Load = std::pair<std::size_t, Duration>;  // slot, bus time due in it

    [[nodiscard]] std::size_t slot_count() const;
    [[nodiscard]] std::vector<Load> loads(const SpreadStream& stream) const;
    [[nodiscard]] std::size_t best_shift(const SpreadStream& stream, const std::vector<Load>& loads) const;
    void place(const SpreadStream& stream, bool movable);

    Duration slot_;
    std::vector<Request>& requests_;
    std::vector<Duration> due_;  // in each slot so far
    std::size_t trials_ = 0;     // of loads in slots, for each stream
};

std::size_t Spread::slot_count() const {
    std::int64_t all = slot_.count();
    const std::int64_t most = slot_.count() * static_cast<std::int64_t>(kMostSlots);
    for (const Request& request : requests_) {
        if (!is_periodic(request)) continue;
        const auto more = common_multiple(all, request.period->count(), most);
        if (!more) return kMostSlots;
        all = *more;
    }
    return static_cast<std::size_t>(all / slot_.count());
}

std::vector<Spread::Load> Spread::loads(const SpreadStream& stream) const {
    std::vector<Load> loads;
    const Duration end = slot_ * static_cast<std::int64_t>(due_.size());
    for (const std::size_t i : stream.requests)
        for (Duration t = requests_[i].phase; t < end; t += *requests_[i].period)
            loads.emplace_back(static_cast<std::size_t>(t / slot_), requests_[i].bus_time);
    std::sort(loads.begin(), loads.end());
    std::vector<Load> sums;
    for (const Load& load : loads) {
        if (sums.empty() || sums.back().first != load.first)
            sums.push_back(load);
        else
            sums.back().second += load.second;
    }
    return sums;
}

std::size_t Spread::best_shift(const SpreadStream& stream, const std::vector<Load>& loads) const {
    Duration longest{};
    for (const std::size_t i : stream.requests) longest = std::max(longest, *requests_[i].period);
    const auto slots = static_cast<std::size_t>(std::min<std::int64_t>(longest / slot_, kMostSlots));
    const std::size_t shifts = std::clamp<std::size_t>(trials_ / std::max<std::size_t>(loads.size(), 1), 1,
                                                       std::max<std::size_t>(slots, 1));
    std::tuple best(Duration::max(), Duration::max(), std::size_t{0});
    for (std::size_t shift = 0; shift < shifts; ++shift) {
        Duration most{};
        Duration sum{};
        for (const auto& [slot, load] : loads) {
            const Duration before = due_[(slot + shift) % due_.size()];
            most = std::max(most, before + load);
            sum += before;
        }
        best = std::min(best, std::tuple(most, sum, shift));
    }
    return std::get<std::size_t>(best);
}

void Spread::place(const SpreadStream& stream, bool movable) {
    const auto due = loads(stream);
    const std::size_t shift = movable ? best_shift(stream, due) : 0;
    for (const auto& [slot, load] : due) due_[(slot + shift) % due_.size()] += load;
    const Duration later = slot_ * static_cast<std::int64_t>(shift);
    for (const std::size_t i : stream.requests)
        requests_[i].phase = (requests_[i].phase + later) % *requests_[i].period;
}

void Spread::run(const std::vector<bool>& movable) {
    const std::vector<SpreadStream> streams = spread_streams(requests_);
    due_.assign(slot_count(), Duration::zero());
    trials_ = std::max<std::size_t>(16 * kMostInstants / streams.size(), kMostSlots);
    const auto moves = [&](const SpreadStream& stream) {
        return movable[requests_[stream.requests.front()].device];
    };
    std::vector<const SpreadStream*> order;
    order.reserve(streams.size());
    for (const SpreadStream& stream : streams) order.push_back(&stream);
    std::stable_sort(order.begin(), order.end(), [&](const SpreadStream* a, const SpreadStream* b) {
        return std::pair(moves(*a), b->longest) < std::pair(moves(*b), a->longest);
    });
    for (const SpreadStream* const stream : order) place(*stream, moves(*stream));
}

Duration bus_time_of(std::span<const Request> requests, const std::vector<std::size_t>& round) {
    Duration sum{};
    for (const std::size_t i : round) sum += requests[i].bus_time;
    return sum;
}

struct DueRequest {
    Duration at{};
    std::size_t request = 0;
    friend auto operator<=>(const DueRequest&, const DueRequest&) = default;
};

// The hyperperiod of all streams in instants; nothing beyond kMostInstants.
std::optional<std::vector<DueRequest>> all_due(std::span<const Request> requests,
                                               const std::vector<std::size_t>& members) {
    std::int64_t repeats = 1;
    for (const std::size_t i : members) {
        const auto more = common_multiple(repeats, requests[i].period->count(), Duration::max().count());
        if (!more) return std::nullopt;
        repeats = *more;
    }
    std::vector<DueRequest> due;
    for (const std::size_t i : members) {
        if (repeats / requests[i].period->count() > static_cast<std::int64_t>(kMostInstants - due.size()))
            return std::nullopt;
        for (Duration t = requests[i].phase; t < Duration(repeats); t += *requests[i].period)
            due.push_back({t, i});
    }
    std::sort(due.begin(), due.end());
    return due;
}

std::vector<std::size_t> fullest(std::span<const Request> requests, const std::vector<DueRequest>& due) {
    std::vector<std::size_t> best, round;
    Duration longest{};
    for (std::size_t i = 0; i < due.size(); ++i) {
        round.push_back(due[i].request);
        if (i + 1 < due.size() && due[i + 1].at == due[i].at) continue;
        const Duration length = bus_time_of(requests, round);
        if (best.empty() || length > longest) {
            longest = length;
            best.swap(round);
        }
        round.clear();
    }
    return best;
}

}  // namespace

void spread(const model::Line& line, const std::vector<bool>& movable, std::vector<Request>& requests) {
    std::optional<Duration> slot;
    for (const Request& request : requests) {
        if (!movable[request.device] || !polled(request)) continue;
        for (const std::size_t v : request.variables) {
            const Duration period = line.devices[request.device].variables[v].period;
            if (period > Duration::zero()) slot = std::min(slot.value_or(period), period);
        }
    }
    if (slot) Spread(*slot, requests).run(movable);
}

std::vector<std::size_t> longest_round(std::span<const Request> requests) {
    std::vector<std::size_t> without_period, members, together;
    for (std::size_t i = 0; i < requests.size(); ++i) {
        if (!polled(requests[i])) continue;
        (*requests[i].period == Duration::zero() ? without_period : members).push_back(i);
        if (requests[i].phase == Duration::zero()) together.push_back(i);
    }
    std::vector<std::size_t> round;
    if (together.size() == members.size() + without_period.size()) {
        round = together;  // all phases start at the same instant
    } else if (const auto due = all_due(requests, members)) {
        round = fullest(requests, *due);
        round.insert(round.end(), without_period.begin(), without_period.end());
    } else {
        for (const SpreadStream& stream : spread_streams(requests)) {
            const auto own = all_due(requests, stream.requests);
            const auto longest = own ? fullest(requests, *own) : stream.requests;
            round.insert(round.end(), longest.begin(), longest.end());
        }
        round.insert(round.end(), without_period.begin(), without_period.end());
    }
    std::sort(round.begin(), round.end());
    return round;
}

}  // namespace takt::plan
