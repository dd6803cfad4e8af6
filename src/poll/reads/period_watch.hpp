// The real periods of requests and variables, and their overruns.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "line/tables.hpp"
#include "reads/indexed_heap.hpp"
#include "reads/refresh_watch.hpp"
#include "takt/bus/release.hpp"

namespace takt::poll {

using bus::PeriodMeter;

/// Measures how often each polled request and each variable is really read, and finds overruns, also while a
/// read is awaited. A value that several requests read in parts has the period of its first part.
///
/// It reads the tables of the line and changes none of them. Allocates in set_requests(). One owner, one
/// thread; the tables must outlive it.
class PeriodWatch {
public:
    explicit PeriodWatch(const LineTables& tables) : tables_(tables) {}

    /// The line has new requests. Variables keep their meters, those that are new get one.
    void set_requests();

    /// A polled read starts.
    /// @returns whether its overrun() changed
    bool started(Instant t, std::size_t request);
    /// It got a normal response. @param start  of its transaction
    /// @returns whether its values were refreshed later than their bound
    bool answered(Instant start, Instant end, std::size_t request);
    /// An attempt on the line failed.
    void failed(Instant t) { refreshes_.failed(t); }
    /// The values of the request became too old, which was counted: the end of that does not count again.
    void forget_refresh(std::size_t request) { refreshes_.forget(request); }
    /// Polling of the request is interrupted on purpose: the time until its next start is no overrun.
    void interrupt(std::size_t request);
    /// Its device is switched off: the time until its next answer is no period.
    void pause(std::size_t request);

    /// When an overrun begins if nothing is read until then.
    [[nodiscard]] Instant next_overrun() const { return due_.empty() ? kNever : due_.top_key(); }
    /// The next request whose overrun begins because it is awaited for too long. Call it until it returns
    /// nothing.
    [[nodiscard]] std::optional<std::size_t> take_overrun(Instant t);

    [[nodiscard]] const PeriodMeter& request(std::size_t request) const { return requests_[request]; }
    [[nodiscard]] const PeriodMeter& variable(std::size_t variable) const { return variables_[variable]; }

    /// The meters of all requests, in their order.
    [[nodiscard]] const std::vector<PeriodMeter>& requests() const { return requests_; }
    /// A request or variable goes on with a meter from before, which has the same period.
    void carry_request(std::size_t request, const PeriodMeter& before);
    void carry_variable(std::size_t variable, const PeriodMeter& before) { variables_[variable] = before; }

private:
    void watch(std::size_t request);
    template <class Act>
    void for_first_parts(std::size_t request, const Act& act);

    LineTables tables_;
    std::vector<PeriodMeter> requests_;
    std::vector<PeriodMeter> variables_;
    RefreshWatch refreshes_;
    IndexedHeap<Instant> due_{0};  // by request: when its interval is an overrun
};

}  // namespace takt::poll
