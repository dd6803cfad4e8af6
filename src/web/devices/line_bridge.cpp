#include "devices/line_bridge.hpp"

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "takt/line/loop.hpp"

namespace takt::web {
namespace {

using host::Command;

constexpr std::size_t kHead = 7;  // MBAP: transaction, protocol, length, unit
constexpr Duration kRetryAfter = std::chrono::milliseconds(250);
constexpr std::uint8_t kException = 0x80;
constexpr std::uint8_t kTargetFailed = 11;  // the gateway target device failed to respond

/// Takes the frames of an engine with Modbus TCP framing, and answers them.
class LineBridge final : public line::Driver {
public:
    LineBridge(line::Loop& loop, std::shared_ptr<host::Session> session, std::size_t line,
               const BridgeOptions& bridging, std::string name, Engine& engine, line::DriverOptions options)
        : session_(std::move(session)),
          line_(line),
          bridging_(bridging),
          name_(std::move(name)),
          engine_(engine),
          options_(std::move(options)),
          timer_(loop, [this](Instant t) { on_timer(t); }),
          watch_(loop, session_->descriptor(), [this] { on_outcomes(); }) {
        timer_.set(line::now());
    }

    void poke() override { move(line::now()); }
    [[nodiscard]] bool up() const override { return up_; }
    [[nodiscard]] const std::string& name() const override { return name_; }
    [[nodiscard]] line::DriverCounters counters() const override { return {.links = began_ ? 1U : 0U}; }

private:
    void on_timer(Instant t) {
        if (!std::exchange(began_, true)) {
            up_ = true;
            if (options_.on_link) options_.on_link(t, true, std::nullopt);
            engine_.on_link(t, true);
            on_outcomes();
        } else if (up_) {
            engine_.on_tick(t);
        } else {
            return retry(t);
        }
        move(t);
    }

    // What the engine has to send, and its next wake-up.
    void move(Instant t) {
        if (!up_) return;
        for (auto bytes = engine_.transmit(t); !bytes.empty(); bytes = engine_.transmit(t))
            sent_.insert(sent_.end(), bytes.begin(), bytes.end());
        std::size_t taken = 0;
        for (Bytes left(sent_); up_ && left.size() > kHead; left = Bytes(sent_).subspan(taken)) {
            const std::size_t size = kHead - 1 + (std::size_t{left[4]} << 8 | left[5]);
            if (size <= kHead || left.size() < size) break;
            submit(t, left.first(size));
            taken += size;
        }
        sent_.erase(sent_.begin(), sent_.begin() + static_cast<std::ptrdiff_t>(taken));
        if (up_) timer_.set(engine_.next_wakeup());
    }

    // The head of the frame and its function come back with the response.
    void submit(Instant t, Bytes frame) {
        const Bytes head = frame.first(kHead + 1);
        const Bytes pdu = frame.subspan(kHead);
        heads_[next_tag_].assign(head.begin(), head.end());
        const auto submitted =
            session_->submit({.kind = Command::Kind::exchange,
                              .tag = next_tag_++,
                              .exchange = Command::Exchange{.line = line_,
                                                            .unit = UnitId{head[kHead - 1]},
                                                            .pdu = {pdu.begin(), pdu.end()},
                                                            .wait = bridging_.wait,
                                                            .spare = bridging_.spare},
                              .expires = after(t, bridging_.longest_wait)});
        if (!submitted) lose(t, submitted.error());
    }

    void on_outcomes() {
        do {
            while (auto outcome = session_->next_outcome()) answer(line::now(), *outcome);
        } while (session_->rearm());
        watch_.want_read();
    }

    void answer(Instant t, const host::Outcome& outcome) {
        const auto head = heads_.extract(outcome.tag);
        if (head.empty() || !up_) return;
        // An earlier request of a client that no longer waits for it may still be in flight.
        const bool busy = outcome.error && outcome.error->code == Code::queue_full;
        if (!bridging_.report_absent && outcome.response.empty() && (busy || !outcome.error)) return;
        if (outcome.error) return lose(t, *outcome.error);
        if (outcome.result == value::CommandResult::expired)
            return lose(
                t, fail(outcome.reason == value::Reason::link_lost ? Code::connection_lost : Code::timed_out,
                        name_, bridging_.longest_wait / std::chrono::milliseconds(1))
                       .error());
        auto pdu = outcome.response;
        if (pdu.empty()) pdu = {static_cast<std::uint8_t>(head.mapped().back() | kException), kTargetFailed};
        auto frame = head.mapped();
        frame.resize(kHead);
        frame[4] = static_cast<std::uint8_t>((pdu.size() + 1) >> 8);
        frame[5] = static_cast<std::uint8_t>((pdu.size() + 1) & 0xFF);
        frame.insert(frame.end(), pdu.begin(), pdu.end());
        engine_.on_bytes(t, frame);
        move(t);
    }

    void lose(Instant t, const Error& why) {
        if (!std::exchange(up_, false)) return;
        engine_.on_link(t, false);
        lost_ = why;
        if (options_.on_link) options_.on_link(t, false, why);
        timer_.set(after(t, kRetryAfter));
    }

    // It does not come back: each attempt fails, so that the search gives up.
    void retry(Instant t) {
        timer_.set(after(t, kRetryAfter));
        if (options_.on_link) options_.on_link(t, false, lost_);
    }

    std::shared_ptr<host::Session> session_;
    std::size_t line_;
    BridgeOptions bridging_;
    std::string name_;
    Engine& engine_;
    line::DriverOptions options_;
    bool began_ = false;
    bool up_ = false;
    std::optional<Error> lost_;
    std::vector<std::uint8_t> sent_;
    std::map<std::uint64_t, std::vector<std::uint8_t>> heads_;  // by tag
    std::uint64_t next_tag_ = 1;
    line::Timer timer_;
    line::Watch watch_;
};

}  // namespace

model::Line bridged_line(const model::Line& polled) {
    model::Line line;
    line.name = line.port = polled.name;
    line.transport = model::Transport::tcp;
    line.framing = wire::Framing::tcp;
    return line;
}

client::OpenLine bridge_to(std::shared_ptr<host::Session> session, std::size_t line,
                           const BridgeOptions& bridging) {
    return [session = std::move(session), line, bridging](
               line::Loop& loop, const model::Line& bridged, Engine& engine,
               const line::DriverOptions& options) -> Result<std::unique_ptr<line::Driver>> {
        return std::make_unique<LineBridge>(loop, session, line, bridging, bridged.name, engine, options);
    };
}

}  // namespace takt::web
