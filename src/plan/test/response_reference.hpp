// The equations of the guarantees as they stand there, without a thought for speed: what the analysis must
// equal.
#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include "takt/plan/response.hpp"

namespace takt::plan::reference {

inline Microseconds sum(const std::vector<Microseconds>& frames) {
    Microseconds total = 0;
    for (const auto frame : frames) total += frame;
    return total;
}

inline std::vector<std::vector<Microseconds>> shapes(const Task& task) {
    if (!task.shapes.empty()) return task.shapes;
    return {task.frames};
}

/// Sum of n shapes in a row that end with that one.
inline Microseconds ending_at(const Task& task, std::size_t end, Microseconds n) {
    const auto all = shapes(task);
    Microseconds total = 0;
    for (Microseconds k = 0; k < n; ++k) {
        total += sum(all[end]);
        end = (end + all.size() - 1) % all.size();
    }
    return total;
}

inline Microseconds most(const Task& task, Microseconds n) {
    Microseconds best = 0;
    for (std::size_t end = 0; end < shapes(task).size(); ++end)
        best = std::max(best, ending_at(task, end, n));
    return best;
}

inline Microseconds longest_frame(const Task& task) {
    Microseconds longest = 0;
    for (const auto& shape : shapes(task))
        for (const auto frame : shape) longest = std::max(longest, frame);
    return longest;
}

struct Case {
    const std::vector<Task>& tasks;
    std::optional<FaultRate> faults;
    bool failed_blocks = false;  // B from F, E - 1

    [[nodiscard]] Microseconds failed(Microseconds t) const {
        if (!faults) return 0;
        const Microseconds all = faults->burst + t / faults->every;
        return failed_blocks ? std::max<Microseconds>(0, all - 1) : all;
    }
};

inline std::optional<Microseconds> response(const Case& set, std::size_t i) {
    constexpr Microseconds kEndless = 1'000'000;
    const Task& own = set.tasks[i];
    if (own.period == 0) return std::nullopt;
    const auto lower = [&](const Task& k) { return k.period == 0 || k.priority > own.priority; };
    const auto higher = [&](const Task& k) { return k.period > 0 && k.priority < own.priority; };
    Microseconds blocking = 0;
    Microseconds failure = 0;
    for (const Task& k : set.tasks) {
        if (lower(k)) blocking = std::max(blocking, set.failed_blocks ? k.failure : longest_frame(k));
        if (!lower(k)) failure = std::max(failure, k.failure);
    }
    double load = set.faults ? static_cast<double>(failure) / static_cast<double>(set.faults->every) : 0;
    for (const Task& k : set.tasks)
        if (!lower(k)) {
            const auto cycle = static_cast<Microseconds>(shapes(k).size());
            load += static_cast<double>(most(k, cycle)) / static_cast<double>(cycle * k.period);
        }
    if (load > 1 + 1e-9) return std::nullopt;
    const auto half_open = [](const Task& k, Microseconds t) {
        return k.burst + (t + k.jitter - 1) / k.period;
    };
    const auto closed = [](const Task& k, Microseconds t) { return k.burst + (t + k.jitter) / k.period; };
    Microseconds busy = 1;
    for (Microseconds next = 0;; busy = next) {
        next = blocking + set.failed(busy) * failure;
        for (const Task& k : set.tasks)
            if (!lower(k)) next += most(k, half_open(k, busy));
        if (next > kEndless) return std::nullopt;
        if (next <= busy) break;
    }
    Microseconds longest = 0;
    for (Microseconds q = 0; q < half_open(own, busy); ++q) {
        const Microseconds release = std::max<Microseconds>(0, q - own.burst + 1) * own.period - own.jitter;
        for (std::size_t end = 0; end < shapes(own).size(); ++end) {
            if (shapes(own)[end].empty()) continue;
            const Microseconds last = shapes(own)[end].back();
            Microseconds start = 0;
            for (Microseconds next = 0;; start = next) {
                next = blocking + ending_at(own, end, q + 1) - last + set.failed(start + last) * failure;
                for (const Task& k : set.tasks) {
                    if (higher(k)) next += most(k, closed(k, start));
                    if (!lower(k) && !higher(k) && &k != &own)
                        next += most(k, closed(k, std::max<Microseconds>(0, release)));
                }
                if (next <= start) break;
            }
            longest = std::max(longest, start + last - release);
        }
    }
    return longest;
}

inline Responses responses(const std::vector<Task>& tasks, const std::optional<FaultRate>& faults = {}) {
    Responses all;
    for (std::size_t i = 0; i < tasks.size(); ++i) {
        auto longest = response({tasks, faults, false}, i);
        if (faults) {
            const auto second = response({tasks, faults, true}, i);
            longest = longest && second ? std::optional(std::max(*longest, *second)) : std::nullopt;
        }
        all.push_back(longest);
    }
    return all;
}

}  // namespace takt::plan::reference
