// A slave with configured faults, for testing masters.
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
    delay,       ///< a later answer
    silence,     ///< no answer; the request is executed
    exception,   ///< an exception; the request is not executed
    bad_crc,     ///< a wrong checksum; no effect on Modbus TCP, which has none
    wrong_unit,  ///< the unit's number + 1
    cut,         ///< the end is missing
};
inline constexpr std::size_t kAnswerFaults = 6;

/// One fault and how often it happens.
struct FaultRule {
    AnswerFault kind = AnswerFault::silence;
    Duration least{};  ///< of a delay
    Duration most{};
    std::uint8_t code = 4;                  ///< of an exception, 1..255
    std::uint32_t per_million = 1'000'000;  ///< of the answers
    Duration every{};                       ///< not zero: one answer per interval instead of at random
    friend bool operator==(const FaultRule&, const FaultRule&) = default;
};

/// Parses `silence`, `delay=50ms`, `delay=50ms..2s`, `exception=6`, optionally followed by `:10%` (that part
/// of the answers, at random) or `@10s` (one answer every ten seconds).
std::optional<FaultRule> parse_fault(std::string_view text);

/// The text that parse_fault() parses to the rule.
std::string to_text(const FaultRule& rule);

/// The active rules. For each answer they are evaluated in order. One owner, one thread.
class AnswerFaults {
public:
    static constexpr std::size_t kMost = 64;

    explicit AnswerFaults(std::uint64_t seed = 1) : random_(seed) {}

    /// @returns false when there are kMost already
    bool add(Instant t, const FaultRule& rule);
    void clear() { rules_.clear(); }
    [[nodiscard]] std::vector<FaultRule> rules() const;

    /// The rule that applies to this answer, among the kinds that a responder carries out (delay, silence,
    /// exception) or among the others; nullptr: none.
    [[nodiscard]] const FaultRule* strike(Instant t, bool handling);
    [[nodiscard]] Duration draw_delay(const FaultRule& rule);

    /// How often each kind was applied.
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
[[nodiscard]] serve::Answer with_faults(AnswerFaults& faults, const serve::Context& context,
                                        const wire::RequestView& request, const Handle& handle) {
    if (context.broadcast) return handle();
    const FaultRule* const rule = faults.strike(context.time, true);
    if (!rule) return handle();
    if (rule->kind == AnswerFault::exception)
        return serve::Answer::response(
            serve::exception_to(request.pdu()[0], static_cast<wire::ExceptionCode>(rule->code)));
    serve::Answer answer = handle();
    if (rule->kind == AnswerFault::silence) return {};
    answer.delay += faults.draw_delay(*rule);
    return answer;
}

/// Sends as `inner`, a slave's engine, does, with damaged frames. On a byte stream each Modbus TCP frame is
/// damaged by itself; RTU and ASCII frames that are sent together are damaged together.
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

/// Applies `rule` to a frame.
std::vector<std::uint8_t> damaged(const FaultRule& rule, wire::Framing framing, Bytes frame);

}  // namespace takt::sim
