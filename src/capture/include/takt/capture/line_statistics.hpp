// Statistics of a line: devices, their response times, the requests they are polled with, the masters.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "takt/capture/heard_exchange.hpp"
#include "takt/capture/master_finder.hpp"
#include "takt/capture/measured_times.hpp"

namespace takt::capture {

/// A request that is repeated: equal function, start and quantity. Requests without items have zeros.
struct PollKey {
    std::uint8_t function = 0;
    std::uint16_t start = 0;
    std::uint16_t quantity = 0;
    friend constexpr auto operator<=>(const PollKey&, const PollKey&) = default;
};

struct Poll {
    PollKey key;
    std::uint64_t requests = 0;
    std::uint64_t normal = 0;  ///< responses that are no exceptions
    std::uint64_t exceptions = 0;
    std::uint64_t unanswered = 0;
    std::uint16_t written_start = 0;  ///< 0x17: the registers that the last request wrote
    std::uint16_t written_quantity = 0;
    std::uint64_t repeats = 0;         ///< of requests: sent again because no response came
    Instant last;                      ///< the last request that was no repetition
    std::optional<std::size_t> track;  ///< its number in the MasterFinder

    /// The last intervals between requests that are no repetitions.
    static constexpr std::size_t kKept = 16;
    std::array<Duration, kKept> intervals{};
    std::size_t interval_count = 0;

    void add_interval(Duration interval);
    /// Median, least and greatest of the last intervals; zero without any.
    struct Period {
        Duration median{};
        Duration least{};
        Duration greatest{};
    };
    [[nodiscard]] Period period() const;
};

struct HeardDevice {
    std::uint64_t requests = 0;
    std::uint64_t answered = 0;  ///< with exceptions
    std::uint64_t unanswered = 0;
    std::uint64_t unanswered_in_row = 0;               ///< up to now
    std::uint64_t strays = 0;                          ///< responses without a request
    std::map<std::uint8_t, std::uint64_t> exceptions;  ///< by code
    capture::MeasuredTimes times;   ///< from the end of a request to the begin of its response
    std::vector<Poll> polls;        ///< in the order of their first request
    std::uint64_t other_polls = 0;  ///< requests beyond kMostPolls

    /// It was asked and does not respond, or no longer.
    [[nodiscard]] bool silent() const { return unanswered_in_row >= kSilent; }
    static constexpr std::uint64_t kSilent = 3;
    static constexpr std::size_t kMostPolls = 64;
};

/// A group of polls that keep step: those of one master.
struct HeardMaster {
    struct Member {
        std::uint8_t unit = 0;
        std::size_t poll = 0;  ///< index in HeardDevice::polls
    };
    std::vector<Member> polls;
    std::uint64_t requests = 0;
    Poll::Period cycle;  ///< of its most frequent poll
};

struct LineCounts {
    std::uint64_t frames = 0;
    std::uint64_t requests = 0;
    std::uint64_t responses = 0;
    std::uint64_t unanswered = 0;
    std::uint64_t broadcasts = 0;
    std::uint64_t open = 0;  ///< requests without a response at the end
    std::uint64_t strays = 0;
    std::uint64_t overlaps = 0;  ///< requests sent while a response was due
    std::uint64_t damaged = 0;   ///< pieces of bytes that are no frame
    std::uint64_t damaged_bytes = 0;
    Duration busy{};  ///< time in which characters were sent, as far as their time is known
    Instant first;
    Instant last;
};

/// Memory is bounded: 256 units, kMostPolls polls for each. Allocates. One owner, one
/// thread.
class LineStatistics {
public:
    void on_frame(const LineFrame& frame);
    void on_damaged(const DamagedBytes& damaged);
    void on_stray(const LineFrame& frame);
    /// @param waiting  requests whose responses are due
    void on_request(const SeenRequest& request, std::span<const SeenRequest* const> waiting);
    void on_exchange(const Exchange& exchange);

    [[nodiscard]] const LineCounts& counts() const { return counts_; }
    /// By unit.
    [[nodiscard]] const std::map<std::uint8_t, HeardDevice>& devices() const { return devices_; }
    /// Polls of which too little was heard belong to no master. The master with the most requests first.
    [[nodiscard]] std::vector<HeardMaster> masters() const;

private:
    [[nodiscard]] Poll* find_poll(std::uint8_t unit, Bytes request);
    [[nodiscard]] Poll* poll_of(std::uint8_t unit, Bytes request);
    void note_time(Instant begin, Instant end);
    void follow(Poll& poll, const SeenRequest& request, std::span<const SeenRequest* const> waiting);

    LineCounts counts_;
    std::map<std::uint8_t, HeardDevice> devices_;
    MasterFinder finder_;
    std::vector<HeardMaster::Member> tracks_;
};

/// Function and items of a request PDU.
[[nodiscard]] PollKey poll_key(Bytes request);

}  // namespace takt::capture
