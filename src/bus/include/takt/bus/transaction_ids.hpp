// The transaction ids of Modbus TCP.
#pragma once

#include <cstdint>

namespace takt::bus {

/// Whether a faulty server may answer a request of the one id with the other: the same id, one more or one
/// less, or its bytes in reverse order.
[[nodiscard]] constexpr bool easily_confused(std::uint16_t a, std::uint16_t b) {
    const auto distance = static_cast<std::uint16_t>(a - b);
    const auto swapped = static_cast<std::uint16_t>(b << 8U | b >> 8U);
    return distance == 0 || distance == 1 || distance == UINT16_MAX || a == swapped;
}

/// The ids of the requests of one connection, from a start value on. Id 0 is never used: servers that do not
/// know the id answer with 0.
///
/// The distance of two ids in a row is 65536 divided by the golden ratio, rounded to an odd number: all ids
/// occur before one occurs again, and more than 30,000 requests are between an id and its neighbours.
class TransactionIds {
public:
    static constexpr std::uint16_t kStep = 0x9E37;

    /// @param first  0 stands for kStep
    explicit constexpr TransactionIds(std::uint16_t first)
        : last_(static_cast<std::uint16_t>(first - kStep)) {}

    /// @param taken  id → whether a response may come that is easily confused with one of that id; false for
    ///               some
    template <class Taken>
    constexpr std::uint16_t next(const Taken& taken) {
        const std::uint16_t before = last_;
        do last_ = static_cast<std::uint16_t>(last_ + kStep);
        while (last_ == 0 || (used_ && easily_confused(last_, before)) || taken(last_));
        used_ = true;
        return last_;
    }

    /// One of the last kRecent ids. Of those that were skipped some count, too.
    [[nodiscard]] constexpr bool is_recent(std::uint16_t id) const {
        const auto ago = static_cast<std::uint16_t>(static_cast<std::uint16_t>(last_ - id) * kInverse);
        return used_ && id != 0 && ago < kRecent;
    }
    static constexpr std::uint16_t kRecent = 1000;

private:
    static constexpr std::uint16_t kInverse = 0x7787;
    static_assert(static_cast<std::uint16_t>(kStep * kInverse) == 1);

    std::uint16_t last_;
    bool used_ = false;  // last_ is the id of a request, not the one before the first
};

}  // namespace takt::bus
