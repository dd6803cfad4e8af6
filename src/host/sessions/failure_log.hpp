// The log lines of failed exchanges and links.
#pragma once

#include <cstdint>
#include <optional>

#include "sessions/repeat_filter.hpp"
#include "takt/base/log.hpp"
#include "takt/base/result.hpp"
#include "takt/model/project.hpp"
#include "takt/poll/statistics.hpp"

namespace takt::host {

/// Writes one line for each failed exchange: line, device, request, reason, duration, attempt; and one for
/// each link that is closed. Equal lines are summarised each kWindow. The project must outlive it. Without a
/// sink it does nothing. One owner, one thread.
class FailureLog {
public:
    static constexpr Duration kWindow = std::chrono::seconds(60);
    static constexpr std::size_t kMostKinds = 512;

    FailureLog(const Log& log, const model::Project& project);

    void on_failed(Instant t, std::size_t line, const poll::FailedExchange& failed);
    /// @param why       nothing: the connection was lost
    /// @param repeated  how many attempts failed like the last one, in what time
    void on_link_down(std::size_t line, const std::optional<Error>& why, std::uint64_t repeated, Duration in);
    /// The connection was closed, and the next request opens it again.
    /// @param why  connection_lost: by the peer; not_modbus: the bytes for which the program closed it
    void on_link_closed(Instant t, std::size_t line, const Error& why);
    /// The next failure of the line is not a repetition.
    void on_link_up(Instant t, std::size_t line);
    void on_tick(Instant t);
    /// Writes the summaries that are due later.
    void finish(Instant t);

    /// The same reason; the bytes of Code::not_modbus may differ.
    [[nodiscard]] static bool same_error(const Error& a, const Error& b);

private:
    /// A failed exchange without its duration; without `exchange` the failure of a link.
    struct Kind {
        std::size_t line = 0;
        std::optional<poll::FailedExchange> exchange;
        Error error;
        bool closed = false;  // the link is opened with the next request
        friend bool operator==(const Kind& a, const Kind& b) {
            return a.line == b.line && a.exchange == b.exchange && same_error(a.error, b.error) &&
                   a.closed == b.closed;
        }
    };

    void write(const Kind& kind, Duration took, std::uint64_t repeated) const;
    void write_omitted(std::uint64_t count, Duration in) const;

    Log log_;
    const model::Project& project_;
    RepeatFilter<Kind> filter_{kWindow, kMostKinds};
};

}  // namespace takt::host
