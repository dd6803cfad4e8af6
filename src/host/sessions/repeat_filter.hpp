// Which of many equal log lines are written.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "takt/base/time.hpp"

namespace takt::host {

/// Admits the first message of each key. Equal messages within the next `window` are counted instead, and
/// sweep() reports the count when the window ends. While messages repeat, each window has one report, and the
/// next window is twice as long, up to `longest`. A message that comes half a window or later after the one
/// before it is admitted.
///
/// At most `most` keys are remembered. Messages with further keys are not admitted; sweep() reports their
/// number. Time must not run backwards. One owner, one thread.
template <class Key>
class RepeatFilter {
public:
    /// @param longest  at least `window`
    RepeatFilter(Duration window, std::size_t most, Duration longest)
        : window_(window), longest_(longest), most_(most) {}
    RepeatFilter(Duration window, std::size_t most) : RepeatFilter(window, most, window) {}

    /// @returns whether the message is to be written now
    [[nodiscard]] bool admit(Instant t, const Key& key) {
        const auto known = std::ranges::find(entries_, key, &Entry::key);
        if (known != entries_.end()) {
            const bool rare = known->repeated == 0 && t - known->last >= window_ / 2;
            known->last = t;
            if (rare)
                known->since = t;
            else
                ++known->repeated;
            return rare;
        }
        if (entries_.size() == most_) {
            if (omitted_++ == 0) omitted_since_ = t;
            return false;
        }
        entries_.push_back({key, t, t, window_});
        return true;
    }

    /// Ends the windows that are over at `t`.
    /// @param report   called with the key, how often its message was repeated, and in what time
    /// @param omitted  called with the number of messages of further keys, and in what time
    template <class Report, class Omitted>
    void sweep(Instant t, Report report, Omitted omitted) {
        end_windows(t, false, report, omitted);
    }

    /// Ends the windows of the keys that `which` selects: the next message of each is admitted.
    template <class Which, class Report>
    void end(Instant t, Which which, Report report) {
        std::erase_if(entries_, [&](const Entry& entry) {
            if (!which(entry.key)) return false;
            if (entry.repeated > 0) report(entry.key, entry.repeated, t - entry.since);
            return true;
        });
    }

    /// Ends all windows.
    template <class Report, class Omitted>
    void finish(Instant t, Report report, Omitted omitted) {
        end_windows(t, true, report, omitted);
        entries_.clear();
    }

private:
    struct Entry {
        Key key;
        Instant since;
        Instant last;  // when its last message came
        Duration window;
        std::uint64_t repeated = 0;
    };

    template <class Report, class Omitted>
    void end_windows(Instant t, bool all, Report& report, Omitted& omitted) {
        std::erase_if(entries_, [&](Entry& entry) {
            if (!all && t - entry.since < entry.window) return false;
            if (entry.repeated == 0) return true;
            report(entry.key, entry.repeated, t - entry.since);
            entry.since = t;
            entry.window = std::min(2 * entry.window, longest_);
            entry.repeated = 0;
            return false;
        });
        if (omitted_ > 0 && (all || t - omitted_since_ >= window_))
            omitted(std::exchange(omitted_, 0), t - omitted_since_);
    }

    Duration window_;
    Duration longest_;
    std::size_t most_;
    std::vector<Entry> entries_;
    std::uint64_t omitted_ = 0;
    Instant omitted_since_;
};

}  // namespace takt::host
