// Invariant after settle(): a read that has an entry is in `asleep` while it is not due, else in `ready`; it
// is also in `ageing` while it can still become overdue. Cost of a change: O(log n) in the reads of its
// device.
#include "reads/read_queue.hpp"

#include <utility>

namespace takt::poll {

ReadQueue::ReadQueue(std::span<const std::size_t> devices, std::size_t device_count)
    : addresses_(devices.size()), is_dirty_(devices.size()) {
    std::vector<std::vector<std::size_t>> requests(device_count);
    for (std::size_t request = 0; request < devices.size(); ++request) {
        auto& of_device = requests[devices[request]];
        addresses_[request] = {static_cast<std::uint32_t>(devices[request]),
                               static_cast<std::uint32_t>(of_device.size())};
        of_device.push_back(request);
    }
    devices_.reserve(device_count);
    for (auto& of_device : requests) devices_.emplace_back(std::move(of_device));
    dirty_.reserve(devices.size());
    for (std::size_t request = 0; request < addresses_.size(); ++request) touch(request);
}

void ReadQueue::touch(std::size_t request) {
    if (is_dirty_[request]) return;
    is_dirty_[request] = true;
    dirty_.push_back(request);
}

void ReadQueue::put(std::size_t request, const std::optional<QueueEntry>& entry) {
    const auto [index, local] = addresses_[request];
    auto& device = devices_[index];
    if (entry && !entry->priority)
        device.asleep.put(local, entry->due);
    else
        device.asleep.remove(local);
    if (entry && entry->priority)
        device.ready.put(local, *entry->priority);
    else
        device.ready.remove(local);
    if (entry && entry->priority && entry->changes != kNever)
        device.ageing.put(local, entry->changes);
    else
        device.ageing.remove(local);
}

std::optional<std::size_t> ReadQueue::first(std::size_t index) const {
    const auto& device = devices_[index];
    if (device.ready.empty()) return std::nullopt;
    return device.requests[device.ready.top()];
}

Instant ReadQueue::next_due(std::size_t index) const {
    const auto& device = devices_[index];
    return device.asleep.empty() ? kNever : device.asleep.top_key();
}

}  // namespace takt::poll
