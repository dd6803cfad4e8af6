// A slave with configured faults, for testing masters.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "takt/base/engine.hpp"
#include "takt/serve/answer.hpp"
#include "takt/sim/random.hpp"
#include "takt/wire/frame.hpp"
#include "takt/wire/request_view.hpp"

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

/// The answers that a rule applies to: those of one device of one line, or those that touch some of its
/// items.
struct FaultScope {
    struct Items {
        wire::Area area = wire::Area::holding_register;
        std::uint16_t start = 0;
        std::uint16_t count = 1;
        friend bool operator==(const Items&, const Items&) = default;
    };

    std::string name;  ///< of the device or variable, as the user wrote it
    std::string line;
    UnitId unit{1};
    std::optional<Items> items;  ///< nothing: all answers of the device
    friend bool operator==(const FaultScope&, const FaultScope&) = default;
};

/// The line whose devices answer.
struct FaultSite {
    std::string line;
    std::vector<UnitId> units;

    /// Over TCP the units 0 and 255 mean the first unit, where they are none themselves.
    [[nodiscard]] UnitId device_of(UnitId unit) const;
};

/// One answer.
struct FaultSubject {
    std::string_view line;
    UnitId unit{1};
    std::span<const wire::ItemAccess> accesses;  ///< of the request; empty where only the frame is known
};

/// One fault and how often it happens.
struct FaultRule {
    AnswerFault kind = AnswerFault::silence;
    Duration least{};  ///< of a delay
    Duration most{};
    std::uint8_t code = 4;                  ///< of an exception, 1..255
    std::uint32_t per_million = 1'000'000;  ///< of the answers
    Duration every{};                       ///< not zero: one answer per interval instead of at random
    std::optional<FaultScope> scope = {};   ///< nothing: all answers
    friend bool operator==(const FaultRule&, const FaultRule&) = default;
};

/// Parses `silence`, `delay=50ms`, `delay=50ms..2s`, `exception=6`, optionally followed by `:10%` (that part
/// of the answers, at random) or `@10s` (one answer every ten seconds).
std::optional<FaultRule> parse_fault(std::string_view text);

/// The fault damages a frame, which shows its unit and not its items.
[[nodiscard]] bool damages_frames(AnswerFault kind);

/// The text that parse_fault() parses to the rule. Its scope is not in it.
std::string to_text(const FaultRule& rule);

/// The active rules. For each answer they are evaluated in order. One owner, one thread.
class AnswerFaults {
public:
    static constexpr std::size_t kMost = 64;

    explicit AnswerFaults(std::uint64_t seed = 1) : random_(seed) {}

    /// @returns false when there are kMost already
    bool add(Instant t, const FaultRule& rule);
    void clear() { rules_.clear(); }
    /// Removes the rules of that scope. @returns how many
    std::size_t clear(std::string_view scope_name);
    [[nodiscard]] std::vector<FaultRule> rules() const;

    /// The rule that applies to this answer, among the kinds that a responder carries out (delay, silence,
    /// exception) or among the others; nullptr: none.
    [[nodiscard]] const FaultRule* strike(Instant t, bool handling, const FaultSubject& subject = {});
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
[[nodiscard]] serve::Answer with_faults(AnswerFaults& faults, const FaultSite& site,
                                        const serve::Context& context, const wire::RequestView& request,
                                        const Handle& handle) {
    if (context.broadcast) return handle();
    const FaultRule* const rule =
        faults.strike(context.time, true, {site.line, site.device_of(context.unit), request.accesses()});
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
    FaultyEngine(Engine& inner, wire::Framing framing, AnswerFaults& faults, FaultSite site = {})
        : inner_(inner), framing_(framing), faults_(faults), site_(std::move(site)) {}

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
    FaultSite site_;
    std::vector<std::uint8_t> out_;  // valid until the next transmit(), as those of `inner` are
};

/// Applies `rule` to a frame.
std::vector<std::uint8_t> damaged(const FaultRule& rule, wire::Framing framing, Bytes frame);

}  // namespace takt::sim
