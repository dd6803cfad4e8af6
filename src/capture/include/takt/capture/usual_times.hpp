// How long each unit of a line usually takes to respond.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>

namespace takt::capture {

/// The usual response time of a unit is the second longest of its last eight: a single slow response does not
/// count, and slow responses that come again do. Nanoseconds. Never allocates. One owner, one thread.
class UsualTimes {
public:
    static constexpr std::size_t kSamples = 8;

    void add(std::uint8_t unit, std::int64_t time_ns) {
        auto& own = units_[unit];
        own.times[own.count++ % kSamples] = time_ns;
    }

    /// The only one after one response; nothing before it.
    [[nodiscard]] std::optional<std::int64_t> of(std::uint8_t unit) const {
        const auto& own = units_[unit];
        if (own.count == 0) return std::nullopt;
        const auto count = std::min<std::size_t>(own.count, kSamples);
        auto times = own.times;
        const auto rank = std::min<std::size_t>(count - 1, 1);
        std::nth_element(times.begin(), times.begin() + rank, times.begin() + count, std::greater());
        return times[rank];
    }

private:
    struct Unit {
        std::array<std::int64_t, kSamples> times{};
        std::size_t count = 0;
    };
    std::array<Unit, 256> units_;
};

}  // namespace takt::capture
