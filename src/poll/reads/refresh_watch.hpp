// Reads that refresh their values later than the proof allows.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "takt/base/time.hpp"
#include "takt/plan/plan.hpp"

namespace takt::poll {

/// Compares the time from the begin of a read to the end of the next one with the bound of the plan
/// (plan::RefreshBound). After a failed attempt on the line the bound does not hold, until the bound with
/// failures has passed.
///
/// Requests are numbers of the caller. Allocates in set_requests(). One owner, one thread.
class RefreshWatch {
public:
    /// The line has other requests.
    void set_requests(std::size_t count) { begun_.assign(count, std::nullopt); }

    /// An attempt on the line failed, or its response is in doubt.
    void failed(Instant t) { failed_at_ = t; }
    /// The time until the next read of the request does not count.
    void forget(std::size_t request) { begun_[request].reset(); }

    /// A read of the request got its values.
    /// @returns whether it is later than its bound
    [[nodiscard]] bool answered(Instant begin, Instant end, std::size_t request,
                                const std::optional<plan::RefreshBound>& bound) {
        const auto before = begun_[request];
        begun_[request] = begin;
        if (!bound || !before || end - *before <= bound->age) return false;
        return !failed_at_ || after(*failed_at_, bound->with_failures) < *before;
    }

private:
    std::vector<std::optional<Instant>> begun_;  // of the last read, by request
    std::optional<Instant> failed_at_;
};

}  // namespace takt::poll
