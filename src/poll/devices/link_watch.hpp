// The link of a line: its state, and connections that are of no use.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "takt/base/time.hpp"
#include "takt/bus/health.hpp"
#include "takt/model/line.hpp"
#include "takt/value/value.hpp"

namespace takt::poll {

enum class LinkState : std::uint8_t {
    none,    ///< there was none yet
    up,      ///< requests can be sent
    closed,  ///< the peer closed it, or it was not needed: the next request opens it
    lost,    ///< the port is gone, connecting failed, or each unit met a close
};

/// The state of the link, and how long nothing was received on it.
///
/// A connection that is closed is no failure: the devices behind it keep their states. The next one may be
/// made at once, unless the last one was closed before it was of any use.
///
/// A peer that closes twice in a row directly after the only response of a connection is served as with
/// ConnectionUse::per_request, until the link is lost.
///
/// A peer that vanished leaves a connection that accepts bytes and never answers: it must be made again. A
/// gateway whose devices are all dead looks the same, hence the back-off: the time without a byte after which
/// the connection is given up doubles, until a byte is received.
class LinkWatch {
public:
    LinkWatch() = default;
    explicit LinkWatch(const model::ConnectionRules& rules)
        : use_(rules.use), idle_close_(rules.idle_close) {}

    /// How long no byte may be received before the connection is made again.
    static constexpr bus::Backoff kSilence{std::chrono::seconds(30), std::chrono::minutes(10)};
    /// A close so soon after a response belongs to it.
    static constexpr Duration kDirectly = std::chrono::milliseconds(100);
    /// After a connection on which no request ended.
    static constexpr bus::Backoff kUseless{std::chrono::milliseconds(250), std::chrono::seconds(5)};

    void up(Instant t) {
        if (!usable()) up_since_ = t;
        state_ = LinkState::up;
        last_byte_at_ = last_end_at_ = t;
        answers_ = 0;
        useful_ = given_up_ = done_ = false;
    }
    void lost() {
        if (state_ != LinkState::none) state_ = LinkState::lost;
        up_since_.reset();
        single_ = 0;
        given_up_ = done_ = speaks_modbus_ = false;
    }
    /// Of an open connection. @param named  it is a failure of the request that waited
    void closed(Instant t, bool named) {
        state_ = LinkState::closed;
        if (!done_) single_ = !named && answers_ == 1 && t - answered_at_ <= kDirectly ? single_ + 1 : 0;
        reopen_at_ = useful_ || done_ ? t : after(t, useless_.next());
        given_up_ = done_ = needed_ = false;
    }
    void received(Instant t) {
        last_byte_at_ = t;
        allowed_.reset();
        limit_ = allowed_.next();
    }
    /// A request has ended, answered or not. @param answered  with a response
    void request_ended(Instant t, bool answered) {
        last_end_at_ = t;
        useful_ = true;
        if (!answered) return;
        useless_.reset();
        ++answers_;
        speaks_modbus_ = true;
        answered_at_ = t;
    }
    /// No device answers. The connection is given up if it was silent for long enough.
    void check(Instant t) {
        if (given_up_ || t < after(last_byte_at_, limit_)) return;
        given_up_ = true;
        limit_ = allowed_.next();
    }
    /// While the link is closed: whether a request is due.
    void need(bool now) { needed_ = now; }
    /// The connection is not needed for now: it is to be closed.
    void finish() { done_ = true; }

    [[nodiscard]] LinkState state() const { return state_; }
    /// Requests may be accepted: the link is up, or is opened for them.
    [[nodiscard]] bool usable() const { return state_ == LinkState::up || state_ == LinkState::closed; }
    /// Since when it is usable.
    [[nodiscard]] std::optional<Instant> up_since() const { return up_since_; }
    /// There was a link at some time.
    [[nodiscard]] bool was_up() const { return state_ != LinkState::none; }
    /// Why nothing is sent without a link.
    [[nodiscard]] value::Reason no_link() const {
        return was_up() ? value::Reason::link_lost : value::Reason::never_connected;
    }
    /// The connection must be made again.
    [[nodiscard]] bool given_up() const { return given_up_; }
    [[nodiscard]] bool done() const { return done_; }
    /// The connection has served its only request.
    [[nodiscard]] bool ends_after_request() const { return one_request() && useful_; }
    /// A connection serves one request.
    [[nodiscard]] bool one_request() const {
        return use_ == model::ConnectionUse::per_request || single_ >= 2;
    }
    /// When a request ended last on this connection, or when it was opened.
    [[nodiscard]] Instant last_end() const { return last_end_at_; }
    /// Responses on this connection.
    [[nodiscard]] unsigned answers() const { return answers_; }
    /// A response came since the link was lost.
    [[nodiscard]] bool speaks_modbus() const { return speaks_modbus_; }
    /// From when on it is to be closed if nothing is due.
    [[nodiscard]] Instant closes_at() const {
        if (state_ != LinkState::up) return kNever;
        if (use_ == model::ConnectionUse::per_cycle) return useful_ ? last_end_at_ : kNever;
        return use_ == model::ConnectionUse::on_demand ? after(last_end_at_, *idle_close_) : kNever;
    }
    /// When to connect again; nothing: by the back-off of the driver.
    [[nodiscard]] std::optional<Instant> opens_at() const {
        if (state_ != LinkState::closed) return std::nullopt;
        return needed_ ? reopen_at_ : kNever;
    }

    /// Continues where that of another poller is.
    void take_over(const LinkWatch& old) {
        const auto use = use_;
        const auto idle_close = idle_close_;
        *this = old;
        use_ = use;
        idle_close_ = idle_close;
        given_up_ = done_ = false;
    }

private:
    model::ConnectionUse use_ = model::ConnectionUse::keep;
    std::optional<Duration> idle_close_;  // with ConnectionUse::on_demand
    LinkState state_ = LinkState::none;
    std::optional<Instant> up_since_;
    bool given_up_ = false;
    bool useful_ = false;  // a request has ended on this connection
    bool done_ = false;
    bool speaks_modbus_ = false;
    bool needed_ = false;
    unsigned answers_ = 0;  // on this connection
    unsigned single_ = 0;   // connections in a row that the peer closed directly after their only response
    Instant answered_at_ = Instant::min();
    Instant last_byte_at_ = Instant::min();  // or when the link came up
    Instant last_end_at_ = Instant::min();
    Instant reopen_at_ = Instant::min();
    bus::Backoff useless_ = kUseless;
    bus::Backoff allowed_ = kSilence;
    Duration limit_ = allowed_.next();
};

}  // namespace takt::poll
