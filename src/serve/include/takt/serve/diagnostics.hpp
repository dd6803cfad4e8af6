// The diagnostics of a unit: functions 7, 8, 11 and 12 (MODBUS Application Protocol V1.1b3,
// sections 6.7..6.10).
#pragma once

#include <cstdint>
#include <optional>

#include "takt/base/inplace_vector.hpp"
#include "takt/serve/server.hpp"

namespace takt::serve {

/// The last 64 communication events, for function 12. Optional, because it costs 72 bytes.
class EventLog {
public:
    static constexpr std::size_t kMost = 64;

    /// Drops the oldest event if the log is full.
    void add(std::uint8_t event);
    void clear() { events_.clear(); }
    /// @param age  0: the latest; below size()
    [[nodiscard]] std::uint8_t operator[](std::size_t age) const;
    [[nodiscard]] std::size_t size() const { return events_.size(); }

private:
    InplaceVector<std::uint8_t, kMost> events_;
    std::size_t next_ = 0;  // index of the oldest event once the log is full
};

struct DiagnosticsOptions {
    bool may_restart = false;      ///< 8/1, restart communications; without the right exception 1
    bool may_listen_only = false;  ///< 8/4, force listen-only mode; likewise
    /// Function 7: the first of the eight coils that it reads; coils that do not exist are 0. Nothing: the
    /// byte of set_exception_status().
    std::optional<std::uint16_t> status_coils;
};

/// Counters, diagnostic register, listen-only mode and event log of a unit.
///
/// Functions: 7; 8 with the sub-functions 0..4, 10..18 and 20; 11; 12 if there is a log, else exception 1.
/// Sub-function 3, the ASCII delimiter, accepts only LF; other values are exception 3. Other sub-functions
/// are exception 1. In listen-only mode the unit receives and counts, but neither executes nor answers
/// anything until a restart (8/1), which is not answered either. Counters are 16 bits wide and wrap around.
///
/// The comm event counter counts successful requests, except functions 11 and 12. A pending answer counts as
/// success.
class Diagnostics final : public Extension {
public:
    /// @param log  outlives it; may be absent
    explicit Diagnostics(const DiagnosticsOptions& options = {}, EventLog* log = nullptr);

    [[nodiscard]] bool listens_only() const { return listen_only_; }
    void set_exception_status(std::uint8_t status) { exception_status_ = status; }
    /// The bits of 8/2; cleared by 8/10.
    void set_diagnostic_register(std::uint16_t bits) { register_ = bits; }

    bool handle(Unit& unit, const Context& context, const wire::RequestView& request,
                Answer& answer) override;
    bool admit(const Context& context, const wire::RequestView& request) override;
    void done(const Context& context, const wire::RequestView& request, const Answer& answer) override;
    void on_line_event(LineEvent event) override;

private:
    struct Counts {
        std::uint16_t messages = 0;      // 8/11, of any unit
        std::uint16_t errors = 0;        // 8/12
        std::uint16_t exceptions = 0;    // 8/13
        std::uint16_t own_messages = 0;  // 8/14, for this unit or broadcast
        std::uint16_t silences = 0;      // 8/15
        std::uint16_t refusals = 0;      // 8/16, exception 7
        std::uint16_t busy = 0;          // 8/17, exception 6
        std::uint16_t overruns = 0;      // 8/18
        std::uint16_t events = 0;        // function 11
    };
    using Refusal = std::optional<wire::ExceptionCode>;

    [[nodiscard]] std::uint8_t exception_status(const Unit& unit) const;
    Refusal diagnose(const wire::RequestView& request, Answer& answer);
    Refusal restart(const wire::RequestView& request, Answer& answer);
    Refusal listen_only(Answer& answer);
    [[nodiscard]] const std::uint16_t* counter(std::uint16_t sub_function) const;
    void tell_log(Answer& answer) const;
    void count_answer(const Answer& answer);
    void log(unsigned event);

    DiagnosticsOptions options_;
    EventLog* log_;
    Counts counts_;
    std::uint16_t register_ = 0;
    std::uint8_t exception_status_ = 0;
    bool listen_only_ = false;
};

}  // namespace takt::serve
