// The link of a line, and connections on which nothing is received any more.
#pragma once

#include <optional>

#include "takt/base/time.hpp"
#include "takt/bus/health.hpp"
#include "takt/value/value.hpp"

namespace takt::poll {

/// Whether there is a link, and how long nothing was received on it.
///
/// A peer that vanished leaves a connection that accepts bytes and never answers: it must be made again. A
/// gateway whose devices are all dead looks the same, hence the back-off: the time without a byte after which
/// the connection is given up doubles, until a byte is received.
class LinkWatch {
public:
    /// How long no byte may be received before the connection is made again.
    static constexpr bus::Backoff kSilence{std::chrono::seconds(30), std::chrono::minutes(10)};

    void up(Instant t) {
        up_since_ = last_byte_at_ = t;
        was_up_ = true;
        given_up_ = false;
    }
    void down() {
        up_since_.reset();
        given_up_ = false;
    }
    void received(Instant t) {
        last_byte_at_ = t;
        allowed_.reset();
        limit_ = allowed_.next();
    }
    /// No device answers. The connection is given up if it was silent for long enough.
    void check(Instant t) {
        if (given_up_ || t < after(last_byte_at_, limit_)) return;
        given_up_ = true;
        limit_ = allowed_.next();
    }

    [[nodiscard]] std::optional<Instant> up_since() const { return up_since_; }
    /// There was a link at some time.
    [[nodiscard]] bool was_up() const { return was_up_; }
    /// Why nothing is sent without a link.
    [[nodiscard]] value::Reason no_link() const {
        return was_up_ ? value::Reason::link_lost : value::Reason::never_connected;
    }
    /// The connection must be made again.
    [[nodiscard]] bool given_up() const { return given_up_; }

    /// Continues where that of another poller is.
    void take_over(const LinkWatch& old) {
        *this = old;
        given_up_ = false;
    }

private:
    std::optional<Instant> up_since_;
    bool was_up_ = false;
    bool given_up_ = false;
    Instant last_byte_at_ = Instant::min();  // or when the link came up
    bus::Backoff allowed_ = kSilence;
    Duration limit_ = allowed_.next();
};

}  // namespace takt::poll
