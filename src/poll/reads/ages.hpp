// The greatest ages that values may reach while they are shown as good.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "reads/indexed_heap.hpp"
#include "takt/base/time.hpp"

namespace takt::poll {

/// The deadlines of values by their age. Variables that the same requests read, with the same bound, share
/// one deadline, so that a response changes few of them. Does not know variables: they are numbers of the
/// caller.
///
/// A deadline is never later than that of any value of its group. When it passes, the caller looks at the
/// values one by one (expired()): some may have been read by something else.
///
/// Allocates while groups are added. One owner, one thread.
class AgeLimits {
public:
    static constexpr std::uint32_t kNone = UINT32_MAX;

    struct Group {
        Duration bound{};
        std::vector<std::size_t> requests;
        std::vector<std::size_t> variables;
        Instant read_at = Instant::min();  // when its values were published last
        Instant deadline = kNever;         // kNever: nothing is watched
    };

    AgeLimits() : queue_(0) {}
    /// @param groups  are watched from their first value on
    explicit AgeLimits(std::vector<Group> groups) : groups_(std::move(groups)), queue_(groups_.size()) {}

    [[nodiscard]] std::size_t size() const { return groups_.size(); }
    [[nodiscard]] Group& operator[](std::uint32_t group) { return groups_[group]; }

    /// All values of the group were published at `read_at`; the device had them at `sampled` or later.
    void refresh(std::uint32_t group, Instant sampled, Instant read_at) {
        groups_[group].read_at = read_at;
        watch(group, sampled);
    }
    /// A value of the group was published that the device had at `sampled` or later. It is watched at least.
    void notice(std::uint32_t group, Instant sampled) {
        if (groups_[group].deadline == kNever) watch(group, sampled);
    }

    /// No value of the group is good any more.
    void forget(std::uint32_t group) {
        groups_[group].deadline = kNever;
        queue_.remove(group);
    }

    /// When the next deadline passes.
    [[nodiscard]] Instant next() const { return queue_.empty() ? kNever : queue_.top_key(); }

    /// The next group whose deadline has passed at `t`; it is not watched any more.
    [[nodiscard]] std::optional<std::uint32_t> take_expired(Instant t) {
        if (next() > t) return std::nullopt;
        const std::uint32_t group = queue_.top();
        forget(group);
        return group;
    }

private:
    // A value is too old when it is older than its bound.
    void watch(std::uint32_t group, Instant sampled) {
        groups_[group].deadline = after(after(sampled, groups_[group].bound), Duration(1));
        if (groups_[group].deadline != kNever) queue_.put(group, groups_[group].deadline);
    }

    std::vector<Group> groups_;
    IndexedHeap<Instant> queue_;
};

}  // namespace takt::poll
