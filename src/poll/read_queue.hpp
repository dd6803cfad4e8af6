// The polled reads of a line in the order of their turn, so that a choice need not look at all of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "indexed_heap.hpp"
#include "takt/base/time.hpp"

namespace takt::poll {

/// The part of a candidate that polled reads are ordered by: as Candidate::before().
struct Turn {
    std::uint8_t urgency = 0;
    std::int64_t key = 0;
    std::uint64_t place = 0;
    friend constexpr auto operator<=>(const Turn&, const Turn&) = default;
};

/// Where a polled read stands at a moment, as long as nothing happens to it.
struct Standing {
    Instant due;               ///< not before
    std::optional<Turn> turn;  ///< once it is due
    Instant changes = kNever;  ///< then the turn is another one: it has waited too long
};

/// Of each device: what is not due yet, by the moment it will be, and what is due, by its turn. Whoever
/// changes a read says so with touch(); only then its standing is asked for anew.
///
/// Allocates when it is made only. Its order is the poller's: it knows nothing of requests.
class ReadQueue {
public:
    /// @param devices  of each request, which device it belongs to
    ReadQueue(std::span<const std::size_t> devices, std::size_t device_count);

    void touch(std::size_t request);
    void touch_all();

    /// Brings everything up to date. standing(request) → std::optional<Standing>: nothing where the request
    /// takes no part (it is not polled, or under way).
    template <class Ask>
    void settle(Instant t, const Ask& standing) {
        for (const auto request : dirty_) {
            is_dirty_[request] = false;
            place(request, standing(request));
        }
        dirty_.clear();
        for (auto& device : devices_) {
            while (!device.asleep.empty() && device.asleep.top_key() <= t)
                replace(device, device.asleep.top(), standing);
            while (!device.ageing.empty() && device.ageing.top_key() <= t)
                replace(device, device.ageing.top(), standing);
        }
    }

    /// The read of the device whose turn it is.
    [[nodiscard]] std::optional<std::size_t> first(std::size_t device) const;
    /// When the next of the device's becomes due that is not.
    [[nodiscard]] Instant next_due(std::size_t device) const;
    /// Calls visit(request) for all that are due.
    template <class Visit>
    void for_each_due(std::size_t device, const Visit& visit) const {
        const auto& of_device = devices_[device];
        for (const auto local : of_device.ready.all()) visit(of_device.requests[local]);
    }

private:
    struct OfDevice {
        explicit OfDevice(std::vector<std::size_t> its_requests)
            : requests(std::move(its_requests)),
              asleep(requests.size()),
              ageing(requests.size()),
              ready(requests.size()) {}
        std::vector<std::size_t> requests;  // by their local numbers
        IndexedHeap<Instant> asleep;
        IndexedHeap<Instant> ageing;
        IndexedHeap<Turn> ready;
    };
    struct Address {
        std::uint32_t device = 0;
        std::uint32_t local = 0;
    };

    template <class Ask>
    void replace(const OfDevice& device, std::uint32_t local, const Ask& standing) {
        const std::size_t request = device.requests[local];
        place(request, standing(request));
    }
    void place(std::size_t request, const std::optional<Standing>& standing);

    std::vector<OfDevice> devices_;
    std::vector<Address> addresses_;  // by request
    std::vector<std::size_t> dirty_;
    std::vector<bool> is_dirty_;
};

}  // namespace takt::poll
