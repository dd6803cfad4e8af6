// The polled reads of a line, ordered by priority: a choice need not compare all of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "reads/indexed_heap.hpp"
#include "takt/base/time.hpp"
#include "takt/bus/arbiter.hpp"

namespace takt::poll {

using bus::Priority;

/// The state of a polled read at one moment. It changes with time alone, unless touch() is called.
struct QueueEntry {
    Instant due;                       ///< it may not be sent before
    std::optional<Priority> priority;  ///< when it is due
    Instant changes = kNever;          ///< when it becomes overdue and its priority changes
};

/// Earliest deadline first with promotion of overdue reads. For each device there are three heaps: reads that
/// are not due, by the moment they become due; reads that are due, by priority; and those of them that can
/// become overdue, by that moment. settle() moves reads between the heaps. The caller must touch() a read
/// when it changes it; only then its entry is computed again.
///
/// Allocates in the constructor; visit_due() may, up to the number of reads. It does not know requests: the
/// caller computes their entries.
class ReadQueue {
public:
    /// @param devices  of each request, which device it belongs to
    ReadQueue(std::span<const std::size_t> devices, std::size_t device_count);

    void touch(std::size_t request);

    /// Updates the heaps to `t`. entry(request) → std::optional<QueueEntry>: nothing if the request is not
    /// polled or is in flight.
    template <class Ask>
    void settle(Instant t, const Ask& entry) {
        for (const auto request : dirty_) {
            is_dirty_[request] = false;
            put(request, entry(request));
        }
        dirty_.clear();
        for (auto& device : devices_) {
            while (!device.asleep.empty() && device.asleep.top_key() <= t)
                replace(device, device.asleep.top(), entry);
            while (!device.ageing.empty() && device.ageing.top_key() <= t)
                replace(device, device.ageing.top(), entry);
        }
    }

    /// The due read of the device with the highest priority.
    [[nodiscard]] std::optional<std::size_t> first(std::size_t device) const;
    /// When the next read of the device becomes due.
    [[nodiscard]] Instant next_due(std::size_t device) const;
    /// Calls visit(request) for the due reads of the device, by priority, until it returns false.
    template <class Visit>
    void visit_due(std::size_t device, const Visit& visit) {
        const auto& of_device = devices_[device];
        of_device.ready.visit_in_order(frontier_,
                                       [&](std::uint32_t local) { return visit(of_device.requests[local]); });
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
        IndexedHeap<Priority> ready;
    };
    struct Address {
        std::uint32_t device = 0;
        std::uint32_t local = 0;
    };

    template <class Ask>
    void replace(const OfDevice& device, std::uint32_t local, const Ask& entry) {
        const std::size_t request = device.requests[local];
        put(request, entry(request));
    }
    void put(std::size_t request, const std::optional<QueueEntry>& entry);

    std::vector<OfDevice> devices_;
    std::vector<Address> addresses_;  // by request
    std::vector<std::size_t> dirty_;
    std::vector<bool> is_dirty_;
    std::vector<std::uint32_t> frontier_;  // scratch of visit_due()
};

}  // namespace takt::poll
