// The response times of the exchanges of a capture: statistics for each client, server, unit and function.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <unordered_map>
#include <vector>

#include "takt/capture/exchange.hpp"
#include "takt/capture/measured_times.hpp"
#include "takt/capture/time_line.hpp"

namespace takt::capture {

/// Which differences make exchanges separate series.
struct Grouping {
    bool client = true;
    bool server = true;
    bool unit = true;
    bool function = true;
};

struct LatencyConfig {
    Grouping grouping;
    Duration timeout = std::chrono::seconds(1);  ///< a response after it is late
    std::optional<Duration> limit = {};          ///< exchanges that take longer are counted
    /// Buckets of 1 us for LatencyReport::microseconds(), from 0 on; 0: none.
    std::size_t microsecond_buckets = 0;
};

/// What the exchanges of a series have in common. Parts that Grouping ignores are zero.
struct SeriesKey {
    bool serial = false;
    std::uint32_t interface = 0;
    IpAddress client;  ///< without its port: a client that connects again is the same one
    Endpoint server;
    std::uint8_t unit = 0;
    std::uint8_t function = 0;
    friend constexpr bool operator==(const SeriesKey&, const SeriesKey&) = default;
};

/// Counts and times of a series, or of all exchanges.
struct Series {
    std::uint64_t requests = 0;
    std::uint64_t answered = 0;                        ///< with exceptions and late responses
    std::map<std::uint8_t, std::uint64_t> exceptions;  ///< by code
    std::uint64_t unanswered = 0;
    std::uint64_t open = 0;        ///< still within the time-out when the capture ended
    std::uint64_t broadcasts = 0;  ///< need no response
    std::uint64_t late = 0;        ///< answered after the time-out
    /// Answered after the limit, or unanswered.
    std::uint64_t exceeded = 0;
    std::uint64_t retransmissions = 0;  ///< of segments, between a request and its response
    MeasuredTimes times;                ///< from the request's to the response's last byte
    /// From a request to the next one for the same items.
    std::uint64_t intervals = 0;
    std::uint64_t interval_sum_ns = 0;
    /// Jitter: how much such an interval differs from the one before it.
    MeasuredTimes jitter;

    /// Exchanges that show whether the limit is kept: answered and unanswered ones.
    [[nodiscard]] std::uint64_t decided() const { return answered + unanswered; }
    [[nodiscard]] Duration mean_interval() const;
};

/// One exchange, for the list of the slowest.
struct SlowExchange {
    ObservedRequest request;
    ObservedResponse response;
    [[nodiscard]] Duration time() const { return Duration(response.packet.time_ns - request.packet.time_ns); }
};

/// Memory does not depend on the number of exchanges. At most kMostSeries series; further exchanges count in
/// others(). Allocates for series and their histograms. One owner, one thread.
class LatencyReport final : public ExchangeSink {
public:
    static constexpr std::size_t kMostSeries = 2048;
    static constexpr std::size_t kMostPolls = 65536;  ///< requests whose period is followed
    static constexpr std::size_t kSlowest = 10;

    explicit LatencyReport(const LatencyConfig& config);

    void on_request(const ObservedRequest& request) override;
    void on_response(const ObservedRequest& request, const ObservedResponse& response) override;
    void on_no_response(const ObservedRequest& request, NoResponse why) override;
    /// So many requests like that one were due and not sent: they count as unanswered.
    void on_unsent(const ObservedRequest& request, std::uint64_t count);

    /// The capture ended then: decides which requests without a response are unanswered.
    void end(std::int64_t time_ns);

    using Entry = std::pair<SeriesKey, std::unique_ptr<Series>>;
    /// In the order of their first request.
    [[nodiscard]] const std::vector<Entry>& series() const { return series_; }
    /// The exchanges beyond kMostSeries.
    [[nodiscard]] const Series& others() const { return others_; }
    [[nodiscard]] const Series& total() const { return total_; }
    /// The slowest first.
    [[nodiscard]] std::vector<SlowExchange> slowest() const;
    [[nodiscard]] const TimeLine& time_line() const { return time_line_; }
    [[nodiscard]] const LatencyConfig& config() const { return config_; }

    /// Counts of whole microseconds, rounded down; those beyond are in overflows().
    [[nodiscard]] const std::vector<std::uint64_t>& microseconds() const { return microseconds_; }
    [[nodiscard]] std::uint64_t overflows() const { return overflows_; }

private:
    struct KeyHash {
        std::size_t operator()(const SeriesKey& key) const;
    };
    struct Poll {
        std::int64_t last_ns = 0;
        std::int64_t interval_ns = -1;
    };

    [[nodiscard]] Series& series_of(const ObservedRequest& request);
    [[nodiscard]] SeriesKey key_of(const ObservedRequest& request) const;
    void follow_period(const ObservedRequest& request, Series& series);
    void keep_slow(const SlowExchange& exchange);
    void count_unanswered(const ObservedRequest& request);

    LatencyConfig config_;
    std::vector<Entry> series_;
    std::unordered_map<SeriesKey, Series*, KeyHash> index_;
    Series others_;
    Series total_;
    std::unordered_map<std::uint64_t, Poll> polls_;
    std::vector<SlowExchange> slowest_;  // a heap with the fastest of them in front
    std::vector<ObservedRequest> undecided_;
    TimeLine time_line_;
    std::vector<std::uint64_t> microseconds_;
    std::uint64_t overflows_ = 0;
};

}  // namespace takt::capture
