// The requests of a line that a trigger, a value or a command concerns: a choice need not look at all
// requests.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace takt::poll {

/// A set of requests in the order in which they were added. Allocates in the constructor only.
class EventfulRequests {
public:
    EventfulRequests() = default;
    explicit EventfulRequests(std::size_t requests) : is_member_(requests) { members_.reserve(requests); }

    void add(std::size_t request) {
        if (is_member_[request]) return;
        is_member_[request] = true;
        members_.push_back(request);
    }

    /// @param keep(request)  whether it stays
    template <class Keep>
    void remove_unless(const Keep& keep) {
        std::erase_if(members_, [&](std::size_t request) { return !(is_member_[request] = keep(request)); });
    }

    [[nodiscard]] std::span<const std::size_t> all() const { return members_; }

private:
    std::vector<bool> is_member_;  // by request
    std::vector<std::size_t> members_;
};

}  // namespace takt::poll
