// A device with its variables as the user describes them, and its learnt gaps.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "takt/base/data_type.hpp"
#include "takt/base/numbers.hpp"
#include "takt/base/time.hpp"
#include "takt/model/document.hpp"
#include "takt/model/source.hpp"
#include "takt/wire/function.hpp"

namespace takt::model {

/// Index into Project::locals.
using LocalIndex = std::size_t;

enum class Strategy : std::uint8_t { single, classic, optimal };
enum class Gaps : std::uint8_t { never, learn, always };
/// The write functions that a device accepts: 0x05/0x06 (one item), 0x0F/0x10 (several).
enum class WriteSingle : std::uint8_t {
    as_declared,  ///< not set: each variable uses the function that it names
    allowed,      ///< both: the cheaper one
    only,         ///< 0x05 and 0x06
    never,        ///< 0x0F and 0x10
};

/// Items of one area, inclusive.
struct ItemRange {
    std::uint16_t first = 0;
    std::uint16_t last = 0;
    friend bool operator==(const ItemRange&, const ItemRange&) = default;
};

/// Ranges of each area, in the order of wire::Area; ascending, disjoint, not adjoining.
using AreaRanges = std::array<std::vector<ItemRange>, 4>;

/// Items that a device refused to read (gaps: learn).
struct RefusedItems {
    ItemRange items;
    std::uint8_t exception = 2;  ///< the code of its answer, 1..4
    Duration since{};            ///< age of the first refusal
    Duration checked{};          ///< age of the last one, at most `since`
    friend bool operator==(const RefusedItems&, const RefusedItems&) = default;
};

/// The results of trial reads (gaps: learn), in the order of wire::Area.
struct Learnt {
    /// Limit of stored ranges per area and kind.
    static constexpr std::size_t kMostRanges = 4096;

    AreaRanges confirmed;                              ///< read together successfully
    std::array<std::vector<RefusedItems>, 4> refused;  ///< ascending, not overlapping
    /// The longest read that it answers, if it refused a longer one whose parts it answers; 0: unknown.
    std::array<std::uint16_t, 4> most_items{};
    friend bool operator==(const Learnt&, const Learnt&) = default;
};

/// The response times of a device, measured over all runs (docs/planning.md, "Measured response times"). Zero
/// without exchanges.
struct MeasuredTimes {
    /// Fewer exchanges are too few: neither the plan nor a time-out follows from them.
    static constexpr std::uint64_t kEnough = 100;
    /// Fewer exchanges show no 99.9 %: it would be the longest of them.
    static constexpr std::uint64_t kEnoughForP999 = 1000;

    std::uint64_t exchanges = 0;  ///< responses within the time-out
    Duration longest{};           ///< of them: from the end of the request to the first byte of the response
    Duration p999{};              ///< 99.9 % of them are not longer, within 12.5 % of the true value
    std::uint64_t attempts = 0;   ///< requests sent, answered or not
    std::uint64_t late = 0;       ///< responses after the time-out
    Duration lateness{};          ///< the longest of them, counted as `longest`
    std::array<Duration, 2> next_latest{};  ///< the two that follow it, longest first; zero: there is none

    [[nodiscard]] bool has_p999() const { return exchanges >= kEnoughForP999; }
    /// Three responses were as late or later, so it is no single pause; zero: fewer were late.
    [[nodiscard]] Duration usual_lateness() const { return next_latest[1]; }
    /// Of the late responses: how many came later than `delay`, at most three.
    [[nodiscard]] unsigned later_than(Duration delay) const {
        return static_cast<unsigned>(lateness > delay) + static_cast<unsigned>(next_latest[0] > delay) +
               static_cast<unsigned>(next_latest[1] > delay);
    }
    /// The longest response time seen, in time or late.
    [[nodiscard]] Duration worst() const { return longest > lateness ? longest : lateness; }
    friend bool operator==(const MeasuredTimes&, const MeasuredTimes&) = default;
};

/// Round trips of a TCP device that were measured apart from the project (docs/commands/latency.md).
struct MeasuredRoundTrip {
    Duration longest{};
    Duration usual{};             ///< 99.9 % are not longer
    std::uint64_t exchanges = 0;  ///< MeasuredTimes::kEnough at least
    std::uint16_t in_flight = 1;  ///< requests in flight then
    /// With another number in flight: a device that answers one request after the other takes as many times
    /// as long for the last one.
    [[nodiscard]] Duration longest_with(std::size_t requests) const {
        const std::size_t share = (requests + in_flight - 1) / in_flight;
        return longest * static_cast<std::int64_t>(share > 1 ? share : 1);
    }
    friend bool operator==(const MeasuredRoundTrip&, const MeasuredRoundTrip&) = default;
};

/// Measured times with the counts that they follow from.
struct LearntTimes {
    /// Limit of stored counts.
    static constexpr std::size_t kMostCounts = 256;
    struct Count {
        Duration upper{};  ///< the longest of them, rounded up by at most 12.5 %
        std::uint64_t count = 0;
        friend bool operator==(const Count&, const Count&) = default;
    };

    MeasuredTimes measured;
    std::vector<Count> counts;  ///< of `exchanges`, ascending
    friend bool operator==(const LearntTimes&, const LearntTimes&) = default;
};

/// Rate limit: at most `burst` at once, then one per `min_interval` (docs/guarantees.md, "Model").
struct RateLimit {
    Duration min_interval{};
    std::uint16_t burst = 1;
    friend bool operator==(const RateLimit&, const RateLimit&) = default;
};

/// The back-off of an unresponsive device: the first pause, doubled up to the limit.
struct Backoff {
    Duration first = std::chrono::seconds(1);
    Duration limit = std::chrono::seconds(60);
    friend bool operator==(const Backoff&, const Backoff&) = default;
};

/// A word for a number, or the name of a bit.
struct ValueWord {
    std::int64_t number = 0;
    std::string word;
    friend bool operator==(const ValueWord&, const ValueWord&) = default;
};

/// Values that are usual for a write, inclusive; infinite: no bound on that side.
struct WriteRange {
    double least = -std::numeric_limits<double>::infinity();
    double greatest = std::numeric_limits<double>::infinity();
    friend bool operator==(const WriteRange&, const WriteRange&) = default;
};

/// One value of a device. Addresses are zero-based, as on the wire.
struct Variable {
    std::string name;
    SourceLocation location;
    DataType type = DataType::int16;
    wire::Area area = wire::Area::holding_register;
    /// Register; for a bool in a coil area the `register` of the file (coil / 16).
    std::uint16_t register_number = 0;
    std::optional<std::uint8_t> bit;     ///< of a bool: 0..15
    std::uint16_t registers = 1;         ///< registers it takes; 1 for a bool
    std::optional<wire::Function> read;  ///< 0x01..0x04
    /// 0x05, 0x06, 0x0F, 0x10. Of a bool in a register: only where the device has 0x16 or allows
    /// read-modify-write.
    std::optional<wire::Function> write;
    bool write_on_change = false;
    std::optional<LocalIndex> read_trigger;   ///< a local bool
    std::optional<LocalIndex> write_trigger;  ///< a local bool
    std::optional<LocalIndex> status;         ///< a local int; the device's does not count here
    std::optional<RateLimit> admission;       ///< of its writes on change; by a trigger: the local's
    Duration period{};                        ///< zero: as fast as the line allows
    std::optional<Duration> deadline;
    std::optional<Duration> max_age;  ///< of a good value; counts where no age is proved
    std::optional<Constant> default_value;
    bool hold_last = false;  ///< while the device does not answer: keep the last value instead of the default
    bool retain = false;
    bool used = true;
    ByteOrder order;
    double scale = 1;  ///< value = raw * scale + offset
    double offset = 0;
    double dead_band = 0;
    std::optional<WriteRange> write_range;  ///< of a number, scaled: faces ask back before a write outside
    bool verify = false;
    bool safe_to_repeat = false;
    bool written_by_clients = false;     ///< a variable of a server `writes_to` it, or an output may write it
    std::vector<ValueWord> enumeration;  ///< words of its numbers, ascending
    std::vector<ValueWord> bits;         ///< names of its bits, ascending
    std::vector<std::string> tags;       ///< without duplicates
    std::string unit;
    std::string comment;

    /// The first item on the wire: the register, or the coil `register * 16 + bit`.
    [[nodiscard]] std::uint16_t start() const;
    /// Number of items in a request: registers, or one coil.
    [[nodiscard]] std::uint16_t items() const { return is_bit_area(area) ? std::uint16_t{1} : registers; }
    /// Scaled: its value is a floating-point number, also where its type on the wire is an integer.
    [[nodiscard]] bool scaled() const { return scale != 1 || offset != 0; }
    friend bool operator==(const Variable&, const Variable&) = default;
};

/// The time-out that follows from the longest response time seen (turnaround: learn): at least twice as long,
/// and 20 ms..65535 ms.
[[nodiscard]] constexpr Duration learnt_timeout(Duration longest) {
    constexpr Duration kLeast = std::chrono::milliseconds(20);
    constexpr Duration kMost = std::chrono::milliseconds(65535);
    const Duration twice = longest < kMost / 2 ? 2 * longest : kMost;
    return twice < kLeast ? kLeast : twice;
}

struct Device {
    std::string name;
    SourceLocation location;
    UnitId address{1};
    Duration poll_period = std::chrono::seconds(1);
    Duration response_timeout = std::chrono::milliseconds(500);
    bool response_timeout_set = false;   ///< set in the project
    std::optional<Duration> turnaround;  ///< longest time to the first byte of the response, when known
    bool learn_turnaround = false;       ///< turnaround: learn
    /// TCP: for the estimate; of a measured one the usual.
    Duration round_trip = std::chrono::milliseconds(1);
    std::optional<MeasuredRoundTrip> measured_round_trip;
    std::uint16_t attempts = 3;
    bool group_requests = false;
    std::uint16_t registers_per_request = 16;
    bool registers_per_request_set = false;  ///< set in the project
    Strategy strategy = Strategy::single;    ///< single whenever group_requests is false
    Gaps gaps = Gaps::never;                 ///< where it is not written and `readable` is: always
    AreaRanges readable;  ///< of an area with ranges, nothing else is read for the sake of grouping
    AreaRanges no_read;   ///< never read for the sake of grouping
    Learnt learnt;        ///< counts with gaps: learn; not in the project file
    LearntTimes times;    ///< likewise, of every device; counts for the plan with turnaround: learn
    WriteSingle write_single = WriteSingle::as_declared;
    bool fc22 = false;               ///< it has 0x16, mask write register
    bool fc23 = false;               ///< it has 0x17, read/write multiple registers
    bool read_modify_write = false;  ///< a bit may be written by reading its register and writing it back
    std::uint16_t in_flight = 1;     ///< TCP: requests it takes before it has answered: 1..16
    std::optional<Backoff> backoff;  ///< else the project's
    ByteOrder order;
    std::optional<LocalIndex> poll_enable;  ///< a local bool
    std::optional<LocalIndex> status;       ///< a local int
    std::string comment;
    std::vector<Variable> variables;

    /// turnaround: learn, and enough was measured: the longest response time seen. It is no promise.
    [[nodiscard]] std::optional<Duration> measured_turnaround() const {
        if (!learn_turnaround || times.measured.exchanges < MeasuredTimes::kEnough) return std::nullopt;
        return times.measured.worst();
    }
    /// As written, else as measured; with so many requests in flight on its connection. A turnaround that is
    /// written or learnt counts for one request: a device that answers one after the other takes as many
    /// times as long.
    [[nodiscard]] std::optional<Duration> expected_turnaround(std::size_t requests = 1) const {
        if (measured_round_trip && !turnaround) return measured_round_trip->longest_with(requests);
        const auto of_one = turnaround ? turnaround : measured_turnaround();
        if (!of_one) return std::nullopt;
        return *of_one * static_cast<std::int64_t>(requests);
    }
    /// The exchanges that expected_turnaround() rests on; 0: it is written, or not known.
    [[nodiscard]] std::uint64_t measured_exchanges() const {
        if (turnaround || !expected_turnaround()) return 0;
        return measured_round_trip ? measured_round_trip->exchanges : times.measured.exchanges;
    }

    /// How long a request waits for the first byte of its response, where the response time-out is not set
    /// and the project derives time-outs: the turnaround where it is known, else twice the longest measured
    /// one. Otherwise the response time-out.
    [[nodiscard]] Duration wait(bool derive_timeouts) const {
        if (!derive_timeouts || response_timeout_set) return response_timeout;
        if (turnaround) return *turnaround;
        const auto measured = measured_turnaround();
        return measured ? learnt_timeout(*measured) : response_timeout;
    }
};

std::string_view name(Strategy strategy);

}  // namespace takt::model
