// The memory of requests and answers, shared out among visitors.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <string_view>

namespace takt::web {

/// Counts bytes in all and of each visitor. The excess of a visitor counts for that visitor alone, so one
/// visitor takes at most its share from the others. Not thread-safe.
class BufferQuota {
public:
    /// @param visitor  bytes that one visitor may hold
    /// @param all      bytes that all may hold, each counted with at most `visitor`
    BufferQuota(std::size_t visitor, std::size_t all) : visitor_(visitor), all_(all) {}

    enum class Verdict {
        admitted,
        visitor_full,  ///< the visitor holds more than its share
        full,          ///< all together hold too much
    };
    /// Counts the change with each verdict; a caller that gives the bytes back calls it once more.
    /// @param change  bytes; negative: at most what the visitor holds
    Verdict change(std::string_view visitor, std::ptrdiff_t change);

    [[nodiscard]] std::size_t held() const { return held_; }

private:
    std::size_t visitor_;
    std::size_t all_;
    std::size_t held_ = 0;                                 // with at most visitor_ of each
    std::map<std::string, std::size_t, std::less<>> own_;  // of visitors that hold something
};

}  // namespace takt::web
