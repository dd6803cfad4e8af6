// The values of service variables (model/service.hpp), computed from facts.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "takt/base/time.hpp"
#include "takt/model/service.hpp"
#include "takt/value/project_slots.hpp"
#include "takt/value/store.hpp"
#include "takt/value/value.hpp"

namespace takt::value {

struct LineFacts {
    bool up = false;
    double load = 0;  ///< recent, 0..1
    Duration cycle{};
    std::uint64_t requests = 0;
    std::uint64_t errors = 0;  ///< requests without a valid response
};

struct DeviceFacts {
    std::uint16_t state = 0;  ///< as in docs/service-variables.md
    bool answering = false;
    Duration response_time{};  ///< recent
    std::uint64_t requests = 0;
    std::uint64_t errors = 0;  ///< requests without a valid response
    std::uint64_t timeouts = 0;
    std::uint64_t checksum_errors = 0;
    std::uint64_t exceptions = 0;
    std::uint64_t outages = 0;
};

/// What a running project knows. Only what a value needs is asked for.
class ServiceFacts {
public:
    [[nodiscard]] virtual std::uint64_t utc_seconds() const = 0;  ///< since 1970
    [[nodiscard]] virtual Duration uptime() const = 0;            ///< since the start of the run
    /// Whether each polled request was sent once.
    [[nodiscard]] virtual bool first_cycle_is_over() const = 0;
    [[nodiscard]] virtual LineFacts line(std::size_t line) const = 0;
    [[nodiscard]] virtual DeviceFacts device(std::size_t line, std::size_t device) const = 0;

protected:
    ~ServiceFacts() = default;
};

/// The first cycle ends then, also if a request was not sent: its line may not be connected.
inline constexpr Duration kLongestFirstCycle = std::chrono::seconds(10);

/// The value at this moment. Counters are given modulo 2^32.
[[nodiscard]] Value service_value(const model::ServiceVariable& variable, const ServiceFacts& facts);

/// Computes the service variables that a project uses.
///
/// Values of ServiceRate::fast are computed at each update, others once a second, in turn. A pulse
/// is a function of the uptime: true in the first half of each period, but not of the first one.
class ServiceValues {
public:
    /// Between two updates, counted from the start of the run.
    static constexpr Duration kEvery = std::chrono::milliseconds(100);

    explicit ServiceValues(const model::Project& project, const ProjectSlots& slots);

    /// The project uses none.
    [[nodiscard]] bool empty() const { return used_.empty(); }
    /// The moment of the next update after `uptime`.
    [[nodiscard]] static Duration next_update(Duration uptime) { return (uptime / kEvery + 1) * kEvery; }

    struct Computed {
        SlotId slot;
        Value value;
    };
    /// The values that are due, in the order of their slots. Valid until the next call. Does not allocate.
    [[nodiscard]] std::span<const Computed> update(const ServiceFacts& facts);

private:
    struct Used {
        SlotId slot;
        model::ServiceVariable variable;
    };
    [[nodiscard]] bool is_due(std::size_t index, std::int64_t step) const;

    std::vector<Used> used_;
    std::vector<Computed> computed_;
    std::optional<std::int64_t> step_;  // the uptime of the last update, in kEvery
};

}  // namespace takt::value
