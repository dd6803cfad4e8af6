// A Modbus TCP connection with scripted responses and a clock that only the script moves.
#pragma once

#include <algorithm>
#include <deque>
#include <optional>
#include <utility>
#include <vector>

#include "takt/client/client.hpp"
#include "takt/client/connection.hpp"

namespace takt::client::test {

using namespace std::chrono_literals;
using ByteVector = std::vector<std::uint8_t>;

/// The reaction to a request.
struct Reply {
    Duration delay = 1ms;
    ByteVector pdu;          ///< empty: nothing
    bool lost_link = false;  ///< instead: the connection breaks
    ByteVector raw{};        ///< instead: these bytes, not framed
};

/// The requests it got are in `requests`. Without a scripted reply it is silent.
class ScriptedConnection final : public Connection {
public:
    explicit ScriptedConnection(std::vector<Reply> replies = {})
        : replies_(replies.begin(), replies.end()), engine_(config()) {
        engine_.on_link(now_, true);
    }

    bus::TransactionCore& engine() override { return engine_; }
    void poke() override {}
    [[nodiscard]] bool up() const override { return engine_.link_up(); }
    [[nodiscard]] Instant now() const override { return now_; }
    [[nodiscard]] bool stopped() const override { return stopped_; }

    void run_until(const std::function<bool()>& done, Duration limit) override {
        const Instant end = now_ + limit;
        while (!stopped_ && !done()) {
            transmit();
            const Instant next =
                std::min({engine_.next_wakeup(), incoming_ ? incoming_->first : kNever, end});
            now_ = std::max(now_, next);
            if (incoming_ && incoming_->first <= now_) {
                receive();
            } else if (engine_.next_wakeup() <= now_) {
                engine_.on_tick(now_);
            } else if (now_ >= end) {
                return;
            }
        }
    }

    void stop_after(std::size_t request_count) { stop_after_ = request_count; }

    std::vector<ByteVector> requests;  ///< PDUs
    std::vector<Instant> sent_at;

private:
    static bus::LineConfig config() {
        bus::LineConfig config;
        config.framing = wire::Framing::tcp;
        config.echo = bus::Echo::absent;
        return config;
    }

    void transmit() {
        const Bytes frame = engine_.transmit(now_);
        if (frame.empty()) return;
        requests.emplace_back(frame.begin() + kHeader, frame.end());
        sent_at.push_back(now_);
        header_.assign(frame.begin(), frame.begin() + kHeader);
        if (requests.size() == stop_after_) stopped_ = true;
        if (replies_.empty()) return;
        incoming_.emplace(now_ + replies_.front().delay, std::move(replies_.front()));
        replies_.pop_front();
    }

    void receive() {
        const Reply reply = std::exchange(incoming_, std::nullopt)->second;
        if (reply.lost_link) return engine_.on_link(now_, false);
        ByteVector frame = reply.raw;
        if (!reply.pdu.empty()) {
            frame = header_;
            frame[4] = 0;
            frame[5] = static_cast<std::uint8_t>(reply.pdu.size() + 1);
            frame.insert(frame.end(), reply.pdu.begin(), reply.pdu.end());
        }
        if (!frame.empty()) engine_.on_bytes(now_, frame);
    }

    static constexpr std::ptrdiff_t kHeader = 7;  // MBAP, with the unit

    std::deque<Reply> replies_;
    bus::TransactionEngine engine_;
    Instant now_{1s};
    std::optional<std::pair<Instant, Reply>> incoming_;
    ByteVector header_;
    std::size_t stop_after_ = 0;
    bool stopped_ = false;
};

/// A client and the connection that it owns.
struct Rig {
    explicit Rig(std::vector<Reply> replies, Options options = {}) {
        options.target = "tcp://plc";
        auto owned = std::make_unique<ScriptedConnection>(std::move(replies));
        connection = owned.get();
        client.emplace(std::move(owned), options);
    }
    ScriptedConnection* connection;
    std::optional<Client> client;
};

}  // namespace takt::client::test
