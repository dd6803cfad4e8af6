// The course of a measured time over a capture of unknown length.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "takt/base/time.hpp"

namespace takt::capture {

/// Divides the time into at most kMost spans of equal width, which doubles when the time grows beyond them.
/// Allocates at construction. One owner, one thread.
class TimeLine {
public:
    static constexpr std::size_t kMost = 2048;

    struct Span {
        std::uint64_t count = 0;
        Duration min{};
        Duration max{};
        std::uint64_t sum_ns = 0;
        void add(const Span& other);
    };

    TimeLine() : spans_(kMost) {}

    /// @param time_ns  since 1970. A time before that of the first sample counts as it
    void record(std::int64_t time_ns, Duration sample);

    [[nodiscard]] std::int64_t begin_ns() const { return begin_ns_; }
    [[nodiscard]] std::int64_t width_ns() const { return width_ns_; }
    /// The spans up to the last one with a sample.
    [[nodiscard]] std::size_t size() const { return used_; }
    [[nodiscard]] const Span& operator[](std::size_t index) const { return spans_[index]; }

private:
    void halve();

    std::vector<Span> spans_;
    std::int64_t begin_ns_ = 0;
    std::int64_t width_ns_ = 1'000'000;
    std::size_t used_ = 0;
};

}  // namespace takt::capture
