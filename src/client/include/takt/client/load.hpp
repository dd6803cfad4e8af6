// Requests sent to one device to measure its response times: at a fixed rate, or as fast as it answers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "takt/base/result.hpp"
#include "takt/base/time.hpp"
#include "takt/capture/latency.hpp"
#include "takt/client/connection.hpp"
#include "takt/client/options.hpp"
#include "takt/line/loop.hpp"
#include "takt/wire/prepared_request.hpp"

namespace takt::client {

inline constexpr std::size_t kMostLoadConnections = 256;

/// So many requests in that time, evenly.
struct Rate {
    std::uint64_t requests = 1;              ///< 1..1,000,000
    Duration per = std::chrono::seconds(1);  ///< 1 s or 1 min
    /// From the start to the intended instant of request `number`, which counts from 0.
    [[nodiscard]] Duration offset(std::uint64_t number) const;
    /// How many requests have an offset below `time`.
    [[nodiscard]] std::uint64_t before(Duration time) const;
    friend bool operator==(const Rate&, const Rate&) = default;
};

struct LoadOptions {
    Options target;  ///< its unit, and the time-out of each response
    wire::PreparedRequest request;
    std::size_t connections = 1;  ///< 1..kMostLoadConnections; a serial port allows 1
    /// On each of them, 1..bus::kMaxInFlight; only Framing::tcp allows more than 1.
    std::size_t in_flight = 1;
    /// Nothing: each response causes the next request.
    std::optional<Rate> rate;
    std::optional<Duration> time;        ///< nothing: no limit
    std::optional<std::uint64_t> count;  ///< of requests; nothing: no limit
    /// Normal responses whose bytes differ from those of the first one are counted.
    bool same_content = false;
};

/// Counts and times that capture::LatencyReport does not have.
struct LoadCounts {
    std::uint64_t sent = 0;
    /// Were due before the end of the measurement, and found no connection with room.
    std::uint64_t unsent = 0;
    std::uint64_t timed_out = 0;  ///< no response within the time-out; some may have come late
    std::uint64_t wrong = 0;      ///< a bad checksum, or a response that does not answer the request
    /// Framing::tcp: frames with a transaction id, unit or function that no request has, or second responses.
    std::uint64_t unexpected = 0;
    std::uint64_t lost = 0;       ///< the connection ended before the response
    std::uint64_t different = 0;  ///< see LoadOptions::same_content
    std::uint64_t disconnections = 0;
    std::int64_t begin_ns = 0;  ///< of the measurement, since 1970
    Duration elapsed{};
    /// From the end of the request as it was sent to the end of its response. Equal to the times of the
    /// report without a rate.
    capture::MeasuredTimes from_sending;
};

/// The state of a running measurement, each second.
struct LoadProgress {
    Duration elapsed{};
    std::uint64_t sent = 0;
    std::uint64_t responses = 0;  ///< in the last second
    Duration longest{};           ///< of these
};

/// Sends a request again and again on one or many connections, and records each exchange in a report.
///
/// With a rate, request n is due at start + n / rate, also after late ones. Its response time
/// counts from this instant. A server that stops for a while therefore delays all requests that were due
/// meanwhile, and all of them are recorded: there is no coordinated omission. Requests wait for the first
/// connection with room; those that wait are a number, not a queue. Without a rate the response time counts
/// from the request as it was sent.
///
/// The engine checks each response: transaction id, unit, function, length and byte count. Memory is bounded
/// by LoadOptions. One owner; the loop's thread.
class Load {
public:
    /// @param loop, report, options  outlive it
    Load(line::Loop& loop, const LoadOptions& options, capture::LatencyReport& report);
    ~Load();
    Load(const Load&) = delete;
    Load& operator=(const Load&) = delete;

    /// Opens all connections, within the time-out. Call once.
    /// @returns what client::connect() returns; unsupported ("connections", "in_flight") on a line that
    ///          allows one
    [[nodiscard]] Result<void> connect(const OpenLine& open = line::open_line);

    /// Measures until the time or the count is reached, or the loop is stopped. Requests in flight are waited
    /// for, unless it is stopped. Ends the report. Call once.
    /// @returns connection_lost if no connection was up for 10 s and there is no limit of time; the errors of
    ///          TransactionCore::submit()
    [[nodiscard]] Result<void> run(const std::function<void(const LoadProgress&)>& progress = {});

    [[nodiscard]] const LoadCounts& counts() const { return counts_; }

private:
    friend class LoadConnection;
    struct Due {
        std::uint64_t number = 0;
        Instant intended;
    };

    [[nodiscard]] std::optional<Due> due(Instant t) const;
    void take();
    void arm();
    void offer(Instant t);
    void report_progress(Instant t);
    [[nodiscard]] bool done(Instant t) const;
    [[nodiscard]] bool any_up() const;
    void finish(Instant t);
    [[nodiscard]] std::int64_t wall_ns(Instant t) const { return counts_.begin_ns + (t - start_).count(); }
    [[nodiscard]] capture::ObservedRequest observed(std::uint64_t number, Instant t) const;

    line::Loop& loop_;
    const LoadOptions& options_;
    capture::LatencyReport& report_;
    LoadCounts counts_;
    std::vector<std::unique_ptr<class LoadConnection>> connections_;
    std::size_t next_connection_ = 0;
    std::size_t in_flight_ = 0;
    std::uint64_t next_ = 0;  // number of the next request
    bool running_ = false;
    std::optional<Error> failure_;
    std::vector<std::uint8_t> first_content_;
    Instant start_;
    Instant end_ = kNever;
    Instant up_at_;  // a connection was up then, or just before
    LoadProgress second_;
    std::function<void(const LoadProgress&)> progress_;
    line::Timer timer_;
    line::Timer clock_;
};

}  // namespace takt::client
