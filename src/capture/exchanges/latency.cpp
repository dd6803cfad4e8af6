// Every count is kept twice: in the series of the exchange and in the total. Memory is bounded by
// kMostSeries, kMostPolls and kSlowest; beyond them exchanges are counted in others_, or have no period.
#include "takt/capture/latency.hpp"

#include <algorithm>

#include "network/hash.hpp"

namespace takt::capture {
namespace {

std::uint64_t hash_of(const SeriesKey& key) {
    std::uint64_t hash = mixed(kFirstHash, key.client);
    hash = mixed(hash, key.server.address);
    hash = mixed(hash, std::uint64_t{key.server.port} << 48U | std::uint64_t{key.interface} << 16U |
                           std::uint64_t{key.unit} << 8U | key.function);
    return mixed(hash, key.serial ? 1 : 0);
}

bool is_faster(const SlowExchange& a, const SlowExchange& b) {
    return a.time() < b.time();
}

// A heap with the fastest of the slow exchanges in front: the next one to give way.
bool heap_order(const SlowExchange& a, const SlowExchange& b) {
    return is_faster(b, a);
}

SeriesKey full_key(const ObservedRequest& request) {
    return {request.route.serial, request.route.interface, request.route.client.address, request.route.server,
            request.unit,         request.function};
}

}  // namespace

Duration Series::mean_interval() const {
    return intervals == 0 ? Duration::zero()
                          : Duration(static_cast<std::int64_t>(interval_sum_ns / intervals));
}

std::size_t LatencyReport::KeyHash::operator()(const SeriesKey& key) const {
    return hash_of(key);
}

LatencyReport::LatencyReport(const LatencyConfig& config)
    : config_(config), microseconds_(config.microsecond_buckets) {}

SeriesKey LatencyReport::key_of(const ObservedRequest& request) const {
    SeriesKey key = full_key(request);
    const auto& grouping = config_.grouping;
    if (!grouping.client) key.client = {};
    if (!grouping.server) {
        key.server = {};
        key.interface = 0;
        key.serial = false;
    }
    if (!grouping.unit) key.unit = 0;
    if (!grouping.function) key.function = 0;
    return key;
}

Series& LatencyReport::series_of(const ObservedRequest& request) {
    const auto key = key_of(request);
    if (const auto found = index_.find(key); found != index_.end()) return *found->second;
    if (series_.size() >= kMostSeries) return others_;
    series_.emplace_back(key, std::make_unique<Series>());
    index_.emplace(key, series_.back().second.get());
    return *series_.back().second;
}

void LatencyReport::on_request(const ObservedRequest& request) {
    auto& series = series_of(request);
    ++series.requests;
    ++total_.requests;
    follow_period(request, series);
}

// A poll is a request for the same items from the same client. It is kept as a hash of 64 bits: of 100,000
// polls two collide with a probability below 1e-9, and would share one period.
void LatencyReport::follow_period(const ObservedRequest& request, Series& series) {
    const auto hash = mixed(hash_of(full_key(request)), request.items);
    if (polls_.size() >= kMostPolls && !polls_.contains(hash)) return;
    auto [found, is_new] = polls_.try_emplace(hash);
    auto& poll = found->second;
    const auto interval = request.packet.time_ns - poll.last_ns;
    poll.last_ns = request.packet.time_ns;
    if (is_new || interval < 0) return;
    for (auto* const each : {&series, &total_}) {
        ++each->intervals;
        each->interval_sum_ns += static_cast<std::uint64_t>(interval);
        if (poll.interval_ns >= 0)
            each->jitter.record(std::chrono::abs(Duration(interval - poll.interval_ns)));
    }
    poll.interval_ns = interval;
}

void LatencyReport::on_response(const ObservedRequest& request, const ObservedResponse& response) {
    const SlowExchange exchange{request, response};
    const auto time = exchange.time();
    for (auto* const each : {&series_of(request), &total_}) {
        ++each->answered;
        each->times.record(time);
        each->retransmissions += response.retransmissions;
        if (response.exception != 0) ++each->exceptions[response.exception];
        if (time > config_.timeout) ++each->late;
        if (config_.limit && time > *config_.limit) ++each->exceeded;
    }
    time_line_.record(request.packet.time_ns, time);
    keep_slow(exchange);
    if (microseconds_.empty()) return;
    const auto index = static_cast<std::uint64_t>(std::max<std::int64_t>(time.count(), 0)) / 1000;
    ++(index < microseconds_.size() ? microseconds_[index] : overflows_);
}

void LatencyReport::on_no_response(const ObservedRequest& request, NoResponse why) {
    switch (why) {
        case NoResponse::unanswered: count_unanswered(request); break;
        case NoResponse::end: undecided_.push_back(request); break;
        case NoResponse::broadcast:
            ++series_of(request).broadcasts;
            ++total_.broadcasts;
            break;
    }
}

void LatencyReport::on_unsent(const ObservedRequest& request, std::uint64_t count) {
    if (count == 0) return;
    for (auto* const each : {&series_of(request), &total_}) {
        each->requests += count;
        each->unanswered += count;
        if (config_.limit) each->exceeded += count;
    }
}

void LatencyReport::count_unanswered(const ObservedRequest& request) {
    for (auto* const each : {&series_of(request), &total_}) {
        ++each->unanswered;
        if (config_.limit) ++each->exceeded;
    }
}

// A request without a response at the end is unanswered only if its time-out has passed within the capture.
void LatencyReport::end(std::int64_t time_ns) {
    for (const auto& request : undecided_) {
        if (time_ns - request.packet.time_ns > config_.timeout.count()) {
            count_unanswered(request);
        } else {
            ++series_of(request).open;
            ++total_.open;
        }
    }
    undecided_.clear();
}

void LatencyReport::keep_slow(const SlowExchange& exchange) {
    if (slowest_.size() == kSlowest) {
        if (!is_faster(slowest_.front(), exchange)) return;
        std::ranges::pop_heap(slowest_, heap_order);
        slowest_.pop_back();
    }
    slowest_.push_back(exchange);
    std::ranges::push_heap(slowest_, heap_order);
}

std::vector<SlowExchange> LatencyReport::slowest() const {
    auto sorted = slowest_;
    std::ranges::sort(sorted, [](const auto& a, const auto& b) {
        return a.time() != b.time() ? a.time() > b.time() : a.request.packet.number < b.request.packet.number;
    });
    return sorted;
}

}  // namespace takt::capture
