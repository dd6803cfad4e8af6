// A slave that misbehaves as it is told, for testing masters.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "takt/base/engine.hpp"
#include "takt/serve/answer.hpp"
#include "takt/sim/random.hpp"
#include "takt/wire/frame.hpp"

namespace takt::sim {

enum class AnswerFault : std::uint8_t {
    delay,       ///< the answer comes later
    silence,     ///< it does not come; what was asked is done
    exception,   ///< what was asked is not done
    bad_crc,     ///< a wrong checksum; Modbus TCP has none, and there it is nothing
    wrong_unit,  ///< from the unit with the next number
    cut,         ///< its end is missing
};
inline constexpr std::size_t kAnswerFaults = 6;

/// One fault and how often it happens.
struct FaultRule {
    AnswerFault kind = AnswerFault::silence;
    Duration least{};  ///< of a delay
    Duration most{};
    std::uint8_t code = 4;                  ///< of an exception, 1..255
    std::uint32_t per_million = 1'000'000;  ///< of the answers
    Duration every{};                       ///< not zero: one answer each such time, instead of at random
    friend bool operator==(const FaultRule&, const FaultRule&) = default;
};

/// `silence`, `delay=50ms`, `delay=50ms..2s`, `exception=6`, each of them with `:10%` (at random, so many of
/// the answers) or `@10s` (one answer each ten seconds) behind it.
std::optional<FaultRule> parse_fault(std::string_view text);

/// The text parse_fault() reads as that rule.
std::string to_text(const FaultRule& rule);

/// The rules in force. Every rule is asked for every answer, in their order. One owner, one thread.
class AnswerFaults {
public:
    static constexpr std::size_t kMost = 64;

    explicit AnswerFaults(std::uint64_t seed = 1) : random_(seed) {}

    /// @returns false when there are kMost already
    bool add(Instant t, const FaultRule& rule);
    void clear() { rules_.clear(); }
    [[nodiscard]] std::vector<FaultRule> rules() const;

    /// The rule that strikes this answer, of the kinds that are struck by what handles requests (delay,
    /// silence, exception), or of the others; nullptr: none.
    [[nodiscard]] const FaultRule* strike(Instant t, bool handling);
    [[nodiscard]] Duration draw_delay(const FaultRule& rule);

    /// How often each kind struck.
    [[nodiscard]] std::uint64_t of(AnswerFault kind) const { return struck_[static_cast<std::size_t>(kind)]; }

private:
    struct Timed {
        FaultRule rule;
        Instant due;
    };

    Random random_;
    std::vector<Timed> rules_;
    std::array<std::uint64_t, kAnswerFaults> struck_{};
};

/// The answer to a request with delays, silences and exceptions injected. A broadcast has none: it is not
/// answered.
/// @param handle  `serve::Answer()`: the answer without faults; not called for an injected exception
template <class Handle>
[[nodiscard]] serve::Answer with_faults(AnswerFaults& faults, const serve::Context& context, Bytes request,
                                        const Handle& handle) {
    if (context.broadcast) return handle();
    const FaultRule* const rule = faults.strike(context.time, true);
    if (!rule) return handle();
    if (rule->kind == AnswerFault::exception)
        return serve::Answer::response(
            serve::exception_to(request[0], static_cast<wire::ExceptionCode>(rule->code)));
    serve::Answer answer = handle();
    if (rule->kind == AnswerFault::silence) return {};
    answer.delay += faults.draw_delay(*rule);
    return answer;
}

/// Sends as `inner` does, a slave's engine, but for frames that are damaged. Over a byte stream whole frames
/// of Modbus TCP are damaged one by one, those of RTU and ASCII all that go out together.
class FaultyEngine final : public Engine {
public:
    /// @param inner, faults  outlive it
    FaultyEngine(Engine& inner, wire::Framing framing, AnswerFaults& faults)
        : inner_(inner), framing_(framing), faults_(faults) {}

    void on_link(Instant t, bool up) override { inner_.on_link(t, up); }
    void on_bytes(Instant t, Bytes bytes) override { inner_.on_bytes(t, bytes); }
    void on_tick(Instant t) override { inner_.on_tick(t); }
    [[nodiscard]] Bytes transmit(Instant t) override;
    [[nodiscard]] Instant next_wakeup() const override { return inner_.next_wakeup(); }

private:
    void send(Instant t, Bytes frame);

    Engine& inner_;
    wire::Framing framing_;
    AnswerFaults& faults_;
    std::vector<std::uint8_t> out_;  // valid until the next transmit(), as those of `inner` are
};

/// What `rule` makes of a frame.
std::vector<std::uint8_t> damaged(const FaultRule& rule, wire::Framing framing, Bytes frame);

}  // namespace takt::sim
