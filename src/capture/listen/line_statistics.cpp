#include "takt/capture/line_statistics.hpp"

#include <algorithm>

#include "takt/wire/prepared_request.hpp"
#include "takt/wire/request_view.hpp"

namespace takt::capture {
namespace {

constexpr std::uint64_t kFollowedFrom = 3;  // requests: commands that come once need no track

void note_written(Poll& poll, Bytes request) {
    const wire::RequestView view(request);
    if (view.function() != wire::Function::read_write_multiple_registers || !view.well_formed()) return;
    const auto written = view.accesses()[1];
    poll.written_start = written.start;
    poll.written_quantity = written.count;
}

}  // namespace

void Poll::add_interval(Duration interval) {
    intervals[interval_count++ % kKept] = interval;
}

Poll::Period Poll::period() const {
    const auto count = std::min(interval_count, kKept);
    if (count == 0) return {};
    auto sorted = intervals;
    const auto end = sorted.begin() + static_cast<std::ptrdiff_t>(count);
    std::sort(sorted.begin(), end);
    return {.median = sorted[count / 2], .least = sorted[0], .greatest = sorted[count - 1]};
}

PollKey poll_key(Bytes request) {
    const wire::RequestView view(request);
    const auto shape = wire::shape_of(view);
    return {.function = shape.function, .start = shape.start.value, .quantity = shape.quantity};
}

Poll* LineStatistics::find_poll(std::uint8_t unit, Bytes request) {
    auto& polls = devices_[unit].polls;
    const auto found = std::ranges::find(polls, poll_key(request), &Poll::key);
    return found != polls.end() ? &*found : nullptr;
}

// A device takes further polls until kMostPolls; later ones are only counted.
Poll* LineStatistics::poll_of(std::uint8_t unit, Bytes request) {
    if (auto* const known = find_poll(unit, request)) return known;
    auto& device = devices_[unit];
    if (device.polls.size() < HeardDevice::kMostPolls)
        return &device.polls.emplace_back(Poll{.key = poll_key(request)});
    ++device.other_polls;
    return nullptr;
}

void LineStatistics::note_time(Instant begin, Instant end) {
    if (counts_.frames + counts_.damaged == 0) counts_.first = begin;
    counts_.last = std::max(counts_.last, end);
    counts_.busy += end - begin;
}

void LineStatistics::on_frame(const LineFrame& frame) {
    note_time(frame.begin, frame.end);
    ++counts_.frames;
}

void LineStatistics::on_damaged(const DamagedBytes& damaged) {
    note_time(damaged.begin, damaged.end);
    ++counts_.damaged;
    counts_.damaged_bytes += damaged.bytes.size();
}

void LineStatistics::on_stray(const LineFrame& frame) {
    ++counts_.strays;
    ++devices_[frame.unit].strays;
}

void LineStatistics::on_request(const SeenRequest& request, std::span<const SeenRequest* const> waiting) {
    ++counts_.requests;
    if (request.overlaps) ++counts_.overlaps;
    ++devices_[request.unit].requests;
    auto* const poll = poll_of(request.unit, request.pdu.span());
    if (poll == nullptr) return;
    note_written(*poll, request.pdu.span());
    ++poll->requests;
    if (request.repeats)
        ++poll->repeats;
    else
        follow(*poll, request, waiting);
}

void LineStatistics::follow(Poll& poll, const SeenRequest& request,
                            std::span<const SeenRequest* const> waiting) {
    if (poll.requests - poll.repeats > 1) poll.add_interval(request.begin - poll.last);
    poll.last = request.begin;
    if (!poll.track && poll.requests >= kFollowedFrom && !finder_.full()) {
        poll.track = finder_.add();
        const auto& polls = devices_[request.unit].polls;
        tracks_.push_back({request.unit, static_cast<std::size_t>(&poll - polls.data())});
    }
    if (!poll.track) return;
    finder_.on_request(request.begin, *poll.track, poll.period().median);
    if (!request.overlaps) return;
    for (const auto* const other : waiting) {
        const auto* const due = find_poll(other->unit, other->pdu.span());
        if (due != nullptr && due->track && due != &poll) finder_.on_overlap(*due->track, *poll.track);
    }
}

void LineStatistics::on_exchange(const Exchange& exchange) {
    auto& device = devices_[exchange.request.unit];
    auto* const poll = find_poll(exchange.request.unit, exchange.request.pdu.span());
    switch (exchange.outcome) {
        case Outcome::broadcast: ++counts_.broadcasts; return;
        case Outcome::open: ++counts_.open; return;
        case Outcome::unanswered:
            ++counts_.unanswered;
            ++device.unanswered;
            ++device.unanswered_in_row;
            if (poll != nullptr) ++poll->unanswered;
            return;
        case Outcome::answered:
        case Outcome::exception: break;
    }
    ++counts_.responses;
    ++device.answered;
    device.unanswered_in_row = 0;
    device.times.record(exchange.response_time);
    const bool refused = exchange.outcome == Outcome::exception;
    if (refused) ++device.exceptions[exchange.response[1]];
    if (poll != nullptr) ++(refused ? poll->exceptions : poll->normal);
}

std::vector<HeardMaster> LineStatistics::masters() const {
    std::vector<HeardMaster> masters;
    for (const auto& group : finder_.groups()) {
        auto& master = masters.emplace_back();
        std::uint64_t most = 0;
        for (const auto track : group) {
            const auto& member = tracks_[track];
            const auto& poll = devices_.at(member.unit).polls[member.poll];
            master.polls.push_back(member);
            master.requests += poll.requests;
            if (poll.requests <= most) continue;
            most = poll.requests;
            master.cycle = poll.period();
        }
    }
    std::ranges::stable_sort(masters, std::greater(), &HeardMaster::requests);
    return masters;
}

}  // namespace takt::capture
